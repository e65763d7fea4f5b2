# Files that go into the kit for plugins one by one (sdk.cmake) stand alone.
set(POLYARM_ROOMS_TOGETHER yaml xacro calibration catalogue language vm launch joint_control wheels broadcasters io setup machine tasks operation inside requests cell control controllers data doctor hardware meshes messages plugins program realtime
    server signals sweeps users fleet apps description recording ros2 ros_files paths timing trajectory)
# Test programs: so many files at a time, in all but these (whose files include headers with ROS's names).
set(POLYARM_TESTS_AT_A_TIME 10)
set(POLYARM_TESTS_ALONE ros_packages)
# So many at a time that each takes a compiler some seconds.
set(POLYARM_BY_SIX polyarm polyarm_io polyarm_setup polyarm_machine polyarm_tasks polyarm_operation polyarm_inside polyarm_requests
    polyarm_cell polyarm_server polyarm_sweeps polyarm_fleet)
function(polyarm_in_batches target batch)
  if(POLYARM_TOGETHER)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${batch})
    # Of what stands in another file: a name hidden, a type without linkage "in a header".
    target_compile_options(${target} PRIVATE -Wno-shadow -Wno-subobject-linkage)
  endif()
endfunction()
function(polyarm_together target name rooms)
  if(name IN_LIST rooms)
    set(batch 4)
    if(target IN_LIST POLYARM_BY_SIX)  # less optimized
      set(batch 6)
    endif()
    polyarm_in_batches(${target} ${batch})
  endif()
endfunction()

set(POLYARM_ROOMS_AROUND_CELL io setup machine tasks operation inside requests cell recording server sweeps)
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
    polyarm_together(polyarm_${name} ${name} "${POLYARM_ROOMS_TOGETHER}")
    target_include_directories(polyarm_${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(polyarm_${name} PUBLIC ${uses} ${ROOM_LIBRARIES})
    if(name IN_LIST POLYARM_ROOMS_AROUND_CELL)
      polyarm_around_cell(polyarm_${name})
    elseif(name IN_LIST POLYARM_RECKONING_ROOMS)
      target_compile_options(polyarm_${name} PRIVATE ${POLYARM_RECKONING_OPTIONS})
      polyarm_precompiled(polyarm_${name} polyarm_reckoning_headers)
    else()
      polyarm_precompiled(polyarm_${name} polyarm_library_headers)
    endif()
  else()
    add_library(polyarm_${name} INTERFACE)
    target_include_directories(polyarm_${name} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(polyarm_${name} INTERFACE ${uses} ${ROOM_LIBRARIES})
  endif()
endfunction()

# Tests are compiled in the least time, but for those that reckon much.
set(POLYARM_RECKONING_TESTS simd shapes fitting kinematics closed_form descent ik paths trajectory timing moves jog catalogue hulls collision planning surroundings)
set(POLYARM_CELL_TESTS cell sweeps live plugins links recording ros2 scenario server)
set(test_options "")
set(reckoning_test_options "")
if(CMAKE_BUILD_TYPE STREQUAL "Release" OR POLYARM_SANITIZE)
  set(test_options -O0 -U_FORTIFY_SOURCE)  # which needs an optimizer
  set(reckoning_test_options -O1)
endif()
# The code under test is checked for undefined behaviour; to check what a test writes itself would take as long to compile.
if(POLYARM_SANITIZE MATCHES undefined)
  list(APPEND test_options -fno-sanitize=undefined)
  list(APPEND reckoning_test_options -fno-sanitize=undefined)
endif()
set(cell_test_options ${test_options})
if(POLYARM_TESTS)
  polyarm_program_headers(polyarm_test_headers "fmt::fmt;GTest::gtest" <gtest/gtest.h>)
  polyarm_program_headers(polyarm_reckoning_test_headers "fmt::fmt;GTest::gtest" <gtest/gtest.h>)
  polyarm_program_headers(polyarm_cell_test_headers "polyarm_cell_uses;GTest::gtest" <gtest/gtest.h>
                          ${POLYARM_CELL_HEADERS})
  foreach(kind test reckoning_test cell_test)
    target_compile_options(polyarm_${kind}_headers PRIVATE ${${kind}_options})
  endforeach()
endif()
function(polyarm_compiled_as_test target name)
  set(kind test)
  if(name IN_LIST POLYARM_RECKONING_TESTS)
    set(kind reckoning_test)
  elseif(name IN_LIST POLYARM_CELL_TESTS)
    set(kind cell_test)
  endif()
  target_compile_options(${target} PRIVATE ${${kind}_options})
  polyarm_precompiled(${target} polyarm_${kind}_headers)
endfunction()

# polyarm_test(kinematics polyarm_kinematics …): the test program of tests/<name>, linked with what follows.
function(polyarm_test name)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${name}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE ${ARGN} GTest::gtest_main)
  target_sources(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/own_home.cpp)
  polyarm_compiled_as_test(test_${name} ${name})
  if(NOT name IN_LIST POLYARM_TESTS_ALONE)
    polyarm_in_batches(test_${name} ${POLYARM_TESTS_AT_A_TIME})
  endif()
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
