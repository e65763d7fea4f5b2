// This room's kernels, compiled for AVX2 and FMA.
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
#if defined(__x86_64__)
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif
#define POLYARM_FLOATS 8
namespace polyarm::collision::avx2 {
constexpr std::size_t kMostLinks = kMostBodies;
#include "polyarm/simd/float_lanes.inc"
// uses the file above
#include "polyarm/collision/check_kernels.inc"
}  // namespace polyarm::collision::avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
