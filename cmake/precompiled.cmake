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
polyarm_headers(polyarm_json_headers "fmt::fmt;nlohmann_json::nlohmann_json" ${POLYARM_PRECOMPILED_FORMAT}
                <nlohmann/json.hpp>)
