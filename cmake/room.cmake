# A room is a folder of headers and sources side by side, one static library, and one test program.
#
#   polyarm_room(kinematics USES base description LIBRARIES Eigen3::Eigen)
#
# makes the target polyarm_kinematics from polyarm/kinematics/*.cpp. USES are the arrows between rooms,
# LIBRARIES what it takes from outside. tests/kinematics/*_test.cpp become the program test_kinematics.
function(polyarm_room name)
  cmake_parse_arguments(ROOM "" "" "USES;LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/polyarm/${name}/*.cpp)
  list(TRANSFORM ROOM_USES PREPEND polyarm_ OUTPUT_VARIABLE uses)
  if(sources)
    add_library(polyarm_${name} STATIC ${sources})
    target_include_directories(polyarm_${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(polyarm_${name} PUBLIC ${uses} ${ROOM_LIBRARIES})
  else()
    add_library(polyarm_${name} INTERFACE)
    target_include_directories(polyarm_${name} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(polyarm_${name} INTERFACE ${uses} ${ROOM_LIBRARIES})
  endif()
endfunction()

# polyarm_test(kinematics polyarm_kinematics …): the test program of tests/<name>, linked with what follows.
function(polyarm_test name)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${name}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE ${ARGN} GTest::gtest_main)
  target_precompile_headers(test_${name} PRIVATE <gtest/gtest.h>)
  target_compile_definitions(test_${name} PRIVATE POLYARM_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                                                  POLYARM_COMMAND="$<TARGET_FILE:polyarm>")
  # The live tests run on the wall clock, one after the other and with nothing beside them.
  set(serial FALSE)
  if(name STREQUAL "live")
    set(serial TRUE)
  endif()
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60
                       PROPERTIES TIMEOUT 600 RUN_SERIAL ${serial})
endfunction()
