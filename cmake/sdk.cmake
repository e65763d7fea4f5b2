# What somebody needs who writes hardware or a controller of their own, outside this tree:
#
#   polyarm::plugin   the headers that a plugin may include
#   polyarm::testing  the same rooms as a library, for the test program of a plugin
#   polyarm::polyarm  the command
#
# found by find_package(polyarm CONFIG), where Polyarm is installed or in its build folder.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Every header that plugins may include; they include only each other and the standard library.
set(POLYARM_SDK_HEADERS
    base/error.hpp base/file.hpp base/pose.hpp base/quantity.hpp base/text.hpp base/time.hpp
    realtime/latest.hpp
    description/robot_model.hpp description/scene.hpp
    trajectory/splines.hpp trajectory/trajectory.hpp
    hardware/component.hpp hardware/component_rig.hpp hardware/device_lock.hpp hardware/driver_facts.hpp hardware/node_graph.hpp hardware/plugin.hpp
    hardware/world_state.hpp
    controllers/command_watch.hpp controllers/controller.hpp controllers/controller_rig.hpp controllers/filters.hpp controllers/messages.hpp
    controllers/parameters.hpp controllers/pid.hpp controllers/shared_list.hpp controllers/speed_limiter.hpp
    force/robot_user.hpp)

add_library(polyarm_plugin INTERFACE)
target_compile_features(polyarm_plugin INTERFACE cxx_std_20)
target_include_directories(polyarm_plugin INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

# What lies behind those headers: objects of the rooms that need nothing but the standard library.
function(polyarm_testing_objects room files)
  target_sources(polyarm_testing PRIVATE $<FILTER:$<TARGET_OBJECTS:polyarm_${room}>,INCLUDE,/${files}[.]cpp[.]>)
endfunction()
add_library(polyarm_testing STATIC)
set_target_properties(polyarm_testing PROPERTIES LINKER_LANGUAGE CXX)
target_sources(polyarm_testing PRIVATE $<TARGET_OBJECTS:polyarm_base>
                                       $<TARGET_OBJECTS:polyarm_trajectory>)
polyarm_testing_objects(description robot_model)
polyarm_testing_objects(hardware "(device_lock|lifecycle)")
polyarm_testing_objects(controllers "(controller|filters|parameters|pid|speed_limiter)")
target_link_libraries(polyarm_testing PUBLIC polyarm_plugin)

set_target_properties(polyarm_plugin PROPERTIES EXPORT_NAME plugin)
set_target_properties(polyarm_testing PROPERTIES EXPORT_NAME testing)
set(POLYARM_SDK_TARGETS polyarm_plugin polyarm_testing polyarm)
set(config ${PROJECT_BINARY_DIR}/polyarmConfig.cmake)
set(folder ${CMAKE_INSTALL_LIBDIR}/cmake/polyarm)

configure_file(${PROJECT_SOURCE_DIR}/cmake/polyarmConfig.cmake.in ${config} @ONLY)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/polyarmConfigVersion.cmake COMPATIBILITY SameMinorVersion)
export(TARGETS ${POLYARM_SDK_TARGETS} NAMESPACE polyarm:: FILE ${PROJECT_BINARY_DIR}/polyarmTargets.cmake)

install(TARGETS ${POLYARM_SDK_TARGETS} EXPORT polyarmTargets RUNTIME DESTINATION bin
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT polyarmTargets NAMESPACE polyarm:: DESTINATION ${folder})
install(FILES ${config} ${PROJECT_BINARY_DIR}/polyarmConfigVersion.cmake DESTINATION ${folder})
foreach(header ${POLYARM_SDK_HEADERS})
  get_filename_component(room ${header} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/polyarm/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/polyarm/${room})
endforeach()

# What `polyarm plugin build` builds packages of ROS with: headers with ROS's names, CMake functions, lists.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/ros/ DESTINATION share/polyarm/ros)
install(FILES ${PROJECT_SOURCE_DIR}/polyarm/messages/interfaces.list DESTINATION share/polyarm/ros)
