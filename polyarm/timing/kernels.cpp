#include "polyarm/timing/kernels.hpp"

// Tells the compiler that the arrays of the next loop do not overlap.
#ifdef __clang__
#define POLYARM_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define POLYARM_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace polyarm::timing::kernels {
namespace {

namespace of_all {
#include "polyarm/timing/kernels.inc"
}  // namespace of_all

#if defined(__x86_64__) && defined(__GNUC__)
#define POLYARM_WIDE 1
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
namespace of_avx2 {
#include "polyarm/timing/kernels.inc"
}  // namespace of_avx2
#if defined(__clang__)
#pragma clang attribute pop
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,avx512vl"))), apply_to = function)
#else
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,prefer-vector-width=512")
#endif
namespace of_avx512 {
#include "polyarm/timing/kernels.inc"
}  // namespace of_avx512
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

const Set& choose() noexcept {
#ifdef POLYARM_WIDE
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl"))
    return of_avx512::kSet;
  if (__builtin_cpu_supports("avx2")) return of_avx2::kSet;
#endif
  return of_all::kSet;
}

}  // namespace

const Set& portable() noexcept {
  return of_all::kSet;
}

const Set& best() noexcept {
  static const Set& set = choose();
  return set;
}

}  // namespace polyarm::timing::kernels
