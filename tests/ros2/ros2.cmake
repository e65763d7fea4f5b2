# The far side is Cyclone DDS with its own compiler and its own CDR, where it is installed.
polyarm_test(ros2 polyarm_ros2_objects polyarm_ros2_wire polyarm_ros2_participant polyarm_signals polyarm_description nlohmann_json::nlohmann_json)
# Alone, so that in no batch headers of Fast DDS follow those of Cyclone, whose macros they do not bear.
set_source_files_properties(${CMAKE_CURRENT_SOURCE_DIR}/ros2/attack_test.cpp ${CMAKE_CURRENT_SOURCE_DIR}/ros2/remote_test.cpp
                            ${CMAKE_CURRENT_SOURCE_DIR}/ros2/disposal_keys_test.cpp
                            PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
if(TARGET test_ros2)
  add_dependencies(test_ros2 polyarm polyarm_door_ros2 polyarm_link_ros2)  # it runs the command
  # Clients that tests kill.
  add_executable(ros2_client_process ros2/client_process.cpp)
  target_link_libraries(ros2_client_process PRIVATE polyarm_ros2_wire polyarm_ros2_participant nlohmann_json::nlohmann_json)
  target_compile_definitions(test_ros2 PRIVATE POLYARM_ROS2_CLIENT="$<TARGET_FILE:ros2_client_process>")
  add_dependencies(test_ros2 ros2_client_process)
endif()
find_package(CycloneDDS QUIET)
if(TARGET test_ros2 AND CycloneDDS_FOUND)
  idlc_generate(TARGET polyarm_cyclone_idl FILES ${CMAKE_CURRENT_SOURCE_DIR}/ros2/messages.idl)
  add_library(polyarm_cyclone_messages STATIC)
  target_link_libraries(polyarm_cyclone_messages PRIVATE polyarm_cyclone_idl CycloneDDS::ddsc)
  target_compile_options(polyarm_cyclone_messages PRIVATE -w)
  target_include_directories(polyarm_cyclone_messages PUBLIC ${CMAKE_CURRENT_BINARY_DIR})
  target_link_libraries(test_ros2 PRIVATE polyarm_cyclone_messages CycloneDDS::ddsc)
  target_compile_definitions(test_ros2 PRIVATE POLYARM_CYCLONE=1)
endif()
