// This room's kernels, compiled for every processor of the architecture.
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // in the header
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

#include <cstddef>

#include "polyarm/kinematics/tree_model.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"

#define POLYARM_WIDTH 2
namespace polyarm::kinematics::portable {
#include "polyarm/simd/native_lanes.inc"
#include "polyarm/kinematics/screw_chain_kernels.inc"
namespace many {
#include "polyarm/kinematics/tree_kernels.inc"
}  // namespace many
namespace single {
typedef Pair Lane;
constexpr std::size_t kWidth = 2;
#include "polyarm/kinematics/tree_kernels.inc"
}  // namespace single
}  // namespace polyarm::kinematics::portable
