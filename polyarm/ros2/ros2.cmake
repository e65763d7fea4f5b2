# ROS 2's graph: a module of its own, since Fast DDS is not what every cell needs. Not built where it is not installed.
# Fast DDS is called fastdds from its third generation on (Debian 13), and fastrtps before (Debian 12, Ubuntu 24.04).
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
add_library(polyarm_ros2_wire STATIC ros2/participant.cpp ros2/wire.cpp ros2/options.cpp)
target_include_directories(polyarm_ros2_wire PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(polyarm_ros2_wire PUBLIC polyarm_base polyarm_messages Threads::Threads PRIVATE ${fast_dds})
add_library(polyarm_door_ros2 MODULE ros2/module.cpp ros2/bridge.cpp ros2/controller_nodes.cpp ros2/manager_node.cpp
  ros2/robot_node.cpp ros2/cell_node.cpp ros2/action_server.cpp ros2/parameters.cpp ros2/type_descriptions.cpp
  ros2/life_cycle.cpp recording/state_messages.cpp)
set_target_properties(polyarm_door_ros2 PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/drivers)
# What it uses of the cell it finds in the command that loads it.
target_include_directories(polyarm_door_ros2 PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_link_libraries(polyarm_door_ros2 PRIVATE polyarm_ros2_wire fmt::fmt nlohmann_json::nlohmann_json)
polyarm_together(polyarm_door_ros2 ros2 "${POLYARM_ROOMS_TOGETHER}")
polyarm_around_cell(polyarm_door_ros2)
install(TARGETS polyarm_door_ros2 LIBRARY DESTINATION lib/polyarm)
