# Rooms whose files, and test programs whose files, may be compiled together, some at a time: a clean build takes
# half the time, a change in one file a few seconds more. Names without a name space of their own that two files of
# one folder share must mean the same thing. Off where one edits (preset dev).
option(POLYARM_TOGETHER "compile several source files at a time" ON)

# Headers of others that most sources include, compiled once instead of in every source. A source still includes what it
# uses: -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds without them.
set(POLYARM_PRECOMPILED <algorithm> <array> <atomic> <cmath> <cstdint> <deque> <filesystem> <fstream> <functional> <limits>
    <map> <memory> <mutex> <numbers> <optional> <random> <set> <span> <sstream> <stdexcept> <string> <string_view> <thread>
    <unordered_map> <utility> <variant> <vector>)
# Where nothing optimizes, fmt asks GCC to do so by a pragma, which outlives its end when it is precompiled.
set(POLYARM_PRECOMPILED_FORMAT <fmt/format.h>)
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  set(POLYARM_PRECOMPILED_FORMAT "")
endif()

# polyarm_headers(NAME LIBRARIES [HEADERS...]): what polyarm_precompiled(TARGET NAME) then uses.
function(polyarm_headers name libraries)
  add_library(${name} OBJECT ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  target_link_libraries(${name} PRIVATE ${libraries})
  target_precompile_headers(${name} PRIVATE ${POLYARM_PRECOMPILED} ${ARGN})
  # Not out of ccache: it does not see that a tree at another's path has other headers of ours.
  set_target_properties(${name} PROPERTIES CXX_COMPILER_LAUNCHER "${POLYARM_COMPILER_LAUNCHER}")
endfunction()

# The same for programs, whose code the compiler places in another way than a library's.
function(polyarm_program_headers name libraries)
  polyarm_headers(${name} "${libraries}" ${ARGN})
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(${name} PRIVATE ${CMAKE_CXX_COMPILE_OPTIONS_PIE})
endfunction()

# Where its library switches these warnings off, GCC 12 forgets in a header that was compiled before.
set(POLYARM_PRECOMPILED_OPTIONS "")
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(POLYARM_PRECOMPILED_OPTIONS -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
endif()

function(polyarm_precompiled target headers)
  target_precompile_headers(${target} REUSE_FROM ${headers})
  target_compile_options(${target} PRIVATE ${POLYARM_PRECOMPILED_OPTIONS})
endfunction()

polyarm_headers(polyarm_library_headers fmt::fmt ${POLYARM_PRECOMPILED_FORMAT})
polyarm_headers(polyarm_reckoning_headers fmt::fmt ${POLYARM_PRECOMPILED_FORMAT})
target_compile_options(polyarm_reckoning_headers PRIVATE ${POLYARM_RECKONING_OPTIONS})

# Rooms that wait for people, files and sockets, and all of which look at a cell: less optimized, which takes a quarter
# off a compiler's work, and with cell.hpp (two seconds) compiled before. Where one edits (preset dev) a change in a
# header of the cell's costs less without that.
set(POLYARM_WAITING_OPTIONS "")
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  set(POLYARM_WAITING_OPTIONS -O1)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    list(APPEND POLYARM_WAITING_OPTIONS -Wno-maybe-uninitialized)  # GCC 12 is wrong about an optional there
  endif()
endif()
set(POLYARM_CELL_HEADERS ${PROJECT_SOURCE_DIR}/cmake/precompiled_json.hpp)
if(POLYARM_TOGETHER)
  list(APPEND POLYARM_CELL_HEADERS ${PROJECT_SOURCE_DIR}/polyarm/inside/inside.hpp
       ${PROJECT_SOURCE_DIR}/polyarm/inside/view.hpp)
endif()
add_library(polyarm_cell_uses INTERFACE)  # what a compiler has to be told for these headers
target_include_directories(polyarm_cell_uses INTERFACE ${PROJECT_SOURCE_DIR})
target_link_libraries(polyarm_cell_uses INTERFACE fmt::fmt nlohmann_json::nlohmann_json)
polyarm_headers(polyarm_cell_headers polyarm_cell_uses ${POLYARM_PRECOMPILED_FORMAT} ${POLYARM_CELL_HEADERS})
target_compile_options(polyarm_cell_headers PRIVATE ${POLYARM_WAITING_OPTIONS})
function(polyarm_around_cell target)
  target_compile_options(${target} PRIVATE ${POLYARM_WAITING_OPTIONS})
  polyarm_precompiled(${target} polyarm_cell_headers)
endfunction()
