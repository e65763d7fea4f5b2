// This room's kernels, compiled for AVX2 and FMA.
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"  // in the header
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#endif

#include <cstddef>

#include "polyarm/kinematics/tree_model.hpp"
#if defined(__x86_64__)
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
#define POLYARM_WIDTH 4
namespace polyarm::kinematics::avx2 {
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
}  // namespace polyarm::kinematics::avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
