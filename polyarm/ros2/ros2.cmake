# The ROS 2 door is a separate module, because not every cell needs Fast DDS. It is built only if Fast DDS is installed:
# the package fastdds from version 3 (Debian 13), fastrtps before (Debian 12, Ubuntu 24.04).
find_package(fastcdr QUIET)
find_package(fastdds QUIET)
set(fast_dds fastdds)
if(NOT fastdds_FOUND)
  find_package(fastrtps QUIET)
  set(fast_dds fastrtps)
endif()
if(NOT fastdds_FOUND AND NOT fastrtps_FOUND)
  message(STATUS "Fast DDS not found (apt install libfastrtps-dev or libfastdds-dev): the ROS 2 module is not built")
  return()
endif()
# Only a separate program links Fast DDS; the cell's process uses it through shared memory.
add_library(polyarm_ros2_types STATIC participant/dds_types.cpp participant/disposal_keys.cpp)
target_include_directories(polyarm_ros2_types PUBLIC ${PROJECT_SOURCE_DIR})
add_library(polyarm_ros2_participant STATIC participant/participant.cpp)
target_include_directories(polyarm_ros2_participant PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(polyarm_ros2_participant PUBLIC polyarm_ros2_types polyarm_base Threads::Threads PRIVATE ${fast_dds})
add_executable(polyarm_ros2_dds participant/dds_process.cpp)
target_link_libraries(polyarm_ros2_dds PRIVATE polyarm_ros2_participant polyarm_process)
set_target_properties(polyarm_ros2_dds PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/drivers)
install(TARGETS polyarm_ros2_dds RUNTIME DESTINATION lib/polyarm)
add_library(polyarm_ros2_wire STATIC ros2/dds_view.cpp ros2/remote_participant.cpp ros2/wire.cpp ros2/options.cpp)
target_include_directories(polyarm_ros2_wire PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(polyarm_ros2_wire PUBLIC polyarm_ros2_types polyarm_base polyarm_realtime polyarm_process polyarm_messages Threads::Threads)
add_dependencies(polyarm_ros2_wire polyarm_ros2_dds)
add_library(polyarm_door_ros2 MODULE ros2/module.cpp ros2/bridge.cpp ros2/controller_nodes.cpp ros2/manager_node.cpp
  ros2/robot_node.cpp ros2/cell_node.cpp ros2/action_server.cpp ros2/parameters.cpp ros2/type_descriptions.cpp
  ros2/life_cycle.cpp ros2/typed_topic.cpp ros2/goal_server.cpp ros2/move_group_cell.cpp ros2/move_group_motion.cpp
  ros2/move_group_node.cpp ros2/plugin_nodes.cpp recording/state_messages.cpp)
set_target_properties(polyarm_door_ros2 PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/drivers)
# The command that loads it exports the symbols of the cell.
target_include_directories(polyarm_door_ros2 PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_link_libraries(polyarm_door_ros2 PRIVATE polyarm_ros2_wire fmt::fmt nlohmann_json::nlohmann_json)
# The room move_group is this module's alone. What that room uses is the command's.
target_link_libraries(polyarm_door_ros2 PRIVATE $<TARGET_FILE:polyarm_move_group>)
add_dependencies(polyarm_door_ros2 polyarm_move_group)
polyarm_together(polyarm_door_ros2 ros2 "${POLYARM_ROOMS_TOGETHER}")
polyarm_around_cell(polyarm_door_ros2)
install(TARGETS polyarm_door_ros2 LIBRARY DESTINATION lib/polyarm)
