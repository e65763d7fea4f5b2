#include "polyarm/trajectory/timing_kernels.hpp"

// Before a loop whose arrays do not overlap.
#ifdef __clang__
#define POLYARM_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define POLYARM_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace polyarm::trajectory::kernels {
namespace {

namespace of_all {
#include "polyarm/trajectory/timing_kernels.inc"
}  // namespace of_all

#if defined(__x86_64__) && defined(__GNUC__)
#define POLYARM_AVX2 1
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
namespace of_avx2 {
#include "polyarm/trajectory/timing_kernels.inc"
}  // namespace of_avx2
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

}  // namespace

const Set& portable() noexcept {
  return of_all::kSet;
}

const Set& best() noexcept {
#ifdef POLYARM_AVX2
  static const bool has_avx2 = __builtin_cpu_supports("avx2");
  if (has_avx2) return of_avx2::kSet;
#endif
  return of_all::kSet;
}

}  // namespace polyarm::trajectory::kernels
