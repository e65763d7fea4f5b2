#pragma once
/// Two doubles at a time, as every 64-bit processor can. For loops over joints, which are short: six joints
/// are three steps. Each lane's operations are those of plain doubles, so that the bits are the same.
#include <cstddef>
#include <cstring>
#include <span>

namespace polyarm {

using Pair = double __attribute__((vector_size(16)));

inline Pair load_pair(const double* from) noexcept {
  Pair out;
  std::memcpy(&out, from, sizeof out);
  return out;
}
inline void store_pair(double* to, Pair value) noexcept {
  std::memcpy(to, &value, sizeof value);
}

/// The outcome of a comparison in both lanes. (Written with the processor's own operations where there are
/// some: compilers make twice as many of the general ones.)
#ifdef __SSE2__
struct PairTest {
  Pair bits;
  friend PairTest operator&(PairTest a, PairTest b) noexcept {
    return {__builtin_ia32_andpd(a.bits, b.bits)};
  }
  friend PairTest operator|(PairTest a, PairTest b) noexcept { return {__builtin_ia32_orpd(a.bits, b.bits)}; }
  bool both() const noexcept { return __builtin_ia32_movmskpd(bits) == 3; }
};
/// a <= b; false for NaN.
inline PairTest at_most(Pair a, Pair b) noexcept {
  return {__builtin_ia32_cmplepd(a, b)};
}
inline Pair magnitude(Pair value) noexcept {
  return __builtin_ia32_andnpd(Pair{-0.0, -0.0}, value);
}
#else
struct PairTest {
  bool first, second;
  friend PairTest operator&(PairTest a, PairTest b) noexcept {
    return {a.first && b.first, a.second && b.second};
  }
  friend PairTest operator|(PairTest a, PairTest b) noexcept {
    return {a.first || b.first, a.second || b.second};
  }
  bool both() const noexcept { return first && second; }
};
inline PairTest at_most(Pair a, Pair b) noexcept {
  return {a[0] <= b[0], a[1] <= b[1]};
}
inline Pair magnitude(Pair value) noexcept {
  return value < 0 ? -value : value;
}
#endif

/// Copies as many values as `from` has. Short rows are copied here and now, long ones by the library.
inline void copy_row(std::span<const double> from, double* to) noexcept {
  constexpr std::size_t kLong = 128;
  const double* const source = from.data();
  const std::size_t n = from.size();
  if (n > kLong) {
    std::memcpy(to, source, n * sizeof *source);
    return;
  }
  std::size_t j = 0;
  for (; j + 2 <= n; j += 2) store_pair(to + j, load_pair(source + j));
  if (j < n) to[j] = source[j];
}

}  // namespace polyarm
