// This room's kernels, compiled for every processor of the architecture.
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // in the header
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

#include <cstddef>
#include <cstdint>

#include "polyarm/collision/check_model.hpp"
#include "polyarm/collision/robot_body.hpp"

#define POLYARM_INLINE_MEMBER __attribute__((always_inline)) inline

#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"

#define POLYARM_FLOATS 4
namespace polyarm::collision::portable {
constexpr std::size_t kMostLinks = kMostBodies;
#include "polyarm/simd/float_lanes.inc"
// uses the file above
#include "polyarm/collision/check_kernels.inc"
}  // namespace polyarm::collision::portable
