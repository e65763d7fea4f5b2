#pragma once
/// Eight numbers in the registers of the instruction set that the including file is compiled for: one of
/// AVX-512, two of AVX2, four of SSE2. lanes.hpp includes it if POLYARM_WIDTH gives the numbers per register.
/// Everything is in a namespace of that instruction set, so the linker cannot mix code for different
/// processors. The alternative in lanes.hpp, one compiler vector of eight lanes, goes through memory if no
/// register is that wide: it is written in halves and read whole, which defeats the processor's store
/// forwarding.
#include <cstddef>
#include <cstdint>
#include <type_traits>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"

namespace POLYARM_LANES {

inline constexpr std::size_t kLanes = 8;
inline constexpr std::size_t kParts = kLanes / POLYARM_WIDTH;
typedef double Part __attribute__((vector_size(8 * POLYARM_WIDTH)));
typedef long long PartBits __attribute__((vector_size(8 * POLYARM_WIDTH)));
typedef double PartAnywhere __attribute__((vector_size(8 * POLYARM_WIDTH), aligned(8), may_alias));

POLYARM_INLINE Part part_of(double v) {
#if POLYARM_WIDTH == 8
  return Part{v, v, v, v, v, v, v, v};
#elif POLYARM_WIDTH == 4
  return Part{v, v, v, v};
#else
  return Part{v, v};
#endif
}

/// f(0), f(1) … for each register, in braces for `T`.
template <class T, class F>
POLYARM_INLINE T each_part(const F& f) {
  using std::integral_constant;
  if constexpr (kParts == 1)
    return T{f(integral_constant<int, 0>())};
  else if constexpr (kParts == 2)
    return T{f(integral_constant<int, 0>()), f(integral_constant<int, 1>())};
  else
    return T{f(integral_constant<int, 0>()), f(integral_constant<int, 1>()), f(integral_constant<int, 2>()),
             f(integral_constant<int, 3>())};
}
#define POLYARM_EACH(T, expression) \
  each_part<T>([&](auto i) __attribute__((always_inline)) { return expression; })

struct Parts {
  Part at[kParts];
};
struct Lane {
  Parts v;
  Lane() = default;
  POLYARM_INLINE Lane(double all)
      : v(each_part<Parts>([&](auto) __attribute__((always_inline)) { return part_of(all); })) {}
  POLYARM_INLINE Lane(const Parts& parts) : v(parts) {}
  POLYARM_INLINE Lane(double a, double b, double c, double d, double e, double f, double g, double h) {
    const double all[8] = {a, b, c, d, e, f, g, h};
    v = POLYARM_EACH(Parts, (Part)(*reinterpret_cast<const PartAnywhere*>(all + POLYARM_WIDTH * i)));
  }
  POLYARM_INLINE double operator[](std::size_t i) const { return v.at[i / POLYARM_WIDTH][i % POLYARM_WIDTH]; }
};

#if POLYARM_WIDTH == 8
struct LaneMask {
  __mmask8 bits = 0;
};
POLYARM_INLINE LaneMask operator&(LaneMask a, LaneMask b) {
  return {static_cast<__mmask8>(a.bits & b.bits)};
}
POLYARM_INLINE LaneMask operator|(LaneMask a, LaneMask b) {
  return {static_cast<__mmask8>(a.bits | b.bits)};
}
POLYARM_INLINE LaneMask operator^(LaneMask a, LaneMask b) {
  return {static_cast<__mmask8>(a.bits ^ b.bits)};
}
POLYARM_INLINE LaneMask operator~(LaneMask a) {
  return {static_cast<__mmask8>(~a.bits)};
}
POLYARM_INLINE std::uint32_t bits_of(LaneMask mask) {
  return mask.bits;
}
POLYARM_INLINE LaneMask below(const Lane& a, const Lane& b) {
  return {_mm512_cmp_pd_mask((__m512d)a.v.at[0], (__m512d)b.v.at[0], _CMP_LT_OQ)};
}
POLYARM_INLINE Lane select(LaneMask where, const Lane& yes, const Lane& no) {
  return Parts{(Part)_mm512_mask_blend_pd(where.bits, (__m512d)no.v.at[0], (__m512d)yes.v.at[0])};
}
POLYARM_INLINE Part part_root(Part a) {
  return (Part)_mm512_sqrt_pd((__m512d)a);
}
POLYARM_INLINE Part part_fma(Part a, Part b, Part c) {
  return (Part)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
}
POLYARM_INLINE Part part_fnma(Part a, Part b, Part c) {
  return (Part)_mm512_fnmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
}
POLYARM_INLINE Part part_min(Part a, Part b) {
  return (Part)_mm512_min_pd((__m512d)a, (__m512d)b);
}
POLYARM_INLINE Part part_max(Part a, Part b) {
  return (Part)_mm512_max_pd((__m512d)a, (__m512d)b);
}
#else
struct LaneMask {
  PartBits at[kParts] = {};
};
POLYARM_INLINE LaneMask operator&(const LaneMask& a, const LaneMask& b) {
  return POLYARM_EACH(LaneMask, a.at[i] & b.at[i]);
}
POLYARM_INLINE LaneMask operator|(const LaneMask& a, const LaneMask& b) {
  return POLYARM_EACH(LaneMask, a.at[i] | b.at[i]);
}
POLYARM_INLINE LaneMask operator^(const LaneMask& a, const LaneMask& b) {
  return POLYARM_EACH(LaneMask, a.at[i] ^ b.at[i]);
}
POLYARM_INLINE LaneMask operator~(const LaneMask& a) {
  return POLYARM_EACH(LaneMask, ~a.at[i]);
}
POLYARM_INLINE LaneMask below(const Lane& a, const Lane& b) {
  return POLYARM_EACH(LaneMask, (PartBits)(a.v.at[i] < b.v.at[i]));
}
POLYARM_INLINE Lane select(const LaneMask& where, const Lane& yes, const Lane& no) {
  return POLYARM_EACH(Parts,
                      (Part)((where.at[i] & (PartBits)yes.v.at[i]) | (~where.at[i] & (PartBits)no.v.at[i])));
}
POLYARM_INLINE std::uint32_t bits_of(const LaneMask& mask) {
  std::uint32_t out = 0;
#if POLYARM_WIDTH == 4
  for (std::size_t i = 0; i < kParts; ++i)
    out |= static_cast<std::uint32_t>(_mm256_movemask_pd((__m256d)mask.at[i])) << (4 * i);
#elif defined(__x86_64__)
  for (std::size_t i = 0; i < kParts; ++i)
    out |= static_cast<std::uint32_t>(_mm_movemask_pd((__m128d)mask.at[i])) << (2 * i);
#else
  for (std::size_t i = 0; i < kLanes; ++i)
    out |= mask.at[i / POLYARM_WIDTH][i % POLYARM_WIDTH] ? 1u << i : 0u;
#endif
  return out;
}
#if POLYARM_WIDTH == 4
POLYARM_INLINE Part part_root(Part a) {
  return (Part)_mm256_sqrt_pd((__m256d)a);
}
POLYARM_INLINE Part part_fma(Part a, Part b, Part c) {
  return (Part)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
}
POLYARM_INLINE Part part_fnma(Part a, Part b, Part c) {
  return (Part)_mm256_fnmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
}
POLYARM_INLINE Part part_min(Part a, Part b) {
  return (Part)_mm256_min_pd((__m256d)a, (__m256d)b);
}
POLYARM_INLINE Part part_max(Part a, Part b) {
  return (Part)_mm256_max_pd((__m256d)a, (__m256d)b);
}
#else
POLYARM_INLINE Part part_root(Part a) {
#if defined(__x86_64__)
  return (Part)_mm_sqrt_pd((__m128d)a);
#else
  return Part{__builtin_sqrt(a[0]), __builtin_sqrt(a[1])};
#endif
}
POLYARM_INLINE Part part_fma(Part a, Part b, Part c) {
  return a * b + c;
}
POLYARM_INLINE Part part_fnma(Part a, Part b, Part c) {
  return c - a * b;
}
POLYARM_INLINE Part part_min(Part a, Part b) {
  return a < b ? a : b;
}
POLYARM_INLINE Part part_max(Part a, Part b) {
  return a > b ? a : b;
}
#endif
#endif

POLYARM_INLINE LaneMask& operator|=(LaneMask& a, const LaneMask& b) {
  return a = a | b;
}
POLYARM_INLINE LaneMask& operator&=(LaneMask& a, const LaneMask& b) {
  return a = a & b;
}
POLYARM_INLINE Lane operator+(const Lane& a, const Lane& b) {
  return POLYARM_EACH(Parts, a.v.at[i] + b.v.at[i]);
}
POLYARM_INLINE Lane operator-(const Lane& a, const Lane& b) {
  return POLYARM_EACH(Parts, a.v.at[i] - b.v.at[i]);
}
POLYARM_INLINE Lane operator*(const Lane& a, const Lane& b) {
  return POLYARM_EACH(Parts, a.v.at[i] * b.v.at[i]);
}
POLYARM_INLINE Lane operator/(const Lane& a, const Lane& b) {
  return POLYARM_EACH(Parts, a.v.at[i] / b.v.at[i]);
}
POLYARM_INLINE Lane operator-(const Lane& a) {
  return POLYARM_EACH(Parts, -a.v.at[i]);
}
POLYARM_INLINE Lane& operator+=(Lane& a, const Lane& b) {
  return a = a + b;
}
POLYARM_INLINE Lane& operator-=(Lane& a, const Lane& b) {
  return a = a - b;
}
POLYARM_INLINE Lane& operator*=(Lane& a, const Lane& b) {
  return a = a * b;
}
POLYARM_INLINE Lane splat(double v) {
  return Lane(v);
}
POLYARM_INLINE Lane magnitude(const Lane& a) {
  return POLYARM_EACH(Parts, (Part)((PartBits)a.v.at[i] & 0x7fffffffffffffffLL));
}
/// The size of `a` with the sign of `sign`.
POLYARM_INLINE Lane with_sign(const Lane& a, const Lane& sign) {
  constexpr long long kSign = static_cast<long long>(0x8000000000000000ULL);
  return POLYARM_EACH(Parts, (Part)(((PartBits)a.v.at[i] & ~kSign) | ((PartBits)sign.v.at[i] & kSign)));
}
/// True where exactly one of the two is negative (-0 counts as negative).
POLYARM_INLINE LaneMask of_unlike_sign(const Lane& a, const Lane& b) {
  return below(with_sign(1.0, a) * with_sign(1.0, b), 0.0);
}
/// a * b + c, rounded once if there is an instruction for it.
POLYARM_INLINE Lane fma(const Lane& a, const Lane& b, const Lane& c) {
  return POLYARM_EACH(Parts, part_fma(a.v.at[i], b.v.at[i], c.v.at[i]));
}
/// c - a * b
POLYARM_INLINE Lane fnma(const Lane& a, const Lane& b, const Lane& c) {
  return POLYARM_EACH(Parts, part_fnma(a.v.at[i], b.v.at[i], c.v.at[i]));
}
POLYARM_INLINE Lane least_of(const Lane& a, const Lane& b) {
  return POLYARM_EACH(Parts, part_min(a.v.at[i], b.v.at[i]));
}
POLYARM_INLINE Lane most_of(const Lane& a, const Lane& b) {
  return POLYARM_EACH(Parts, part_max(a.v.at[i], b.v.at[i]));
}
POLYARM_INLINE Lane root(const Lane& a) {
  return POLYARM_EACH(Parts, part_root(a.v.at[i]));
}
/// 1 / a to one or two units in the last place, for 1e-290 < |a| < 1e290. If an instruction gives the first
/// 14 bits, Newton's method does the rest without the divider.
POLYARM_INLINE Lane inverse(const Lane& a) {
#if POLYARM_WIDTH == 8
  Lane y = Parts{(Part)_mm512_rcp14_pd((__m512d)a.v.at[0])};
  y = fma(y, fnma(a, y, 1.0), y);
  return fma(y, fnma(a, y, 1.0), y);
#else
  return 1.0 / a;
#endif
}
/// 1 / sqrt(a) to one or two units in the last place, for 1e-290 < a < 1e290.
POLYARM_INLINE Lane inverse_root(const Lane& a) {
#if POLYARM_WIDTH == 8
  Lane y = Parts{(Part)_mm512_rsqrt14_pd((__m512d)a.v.at[0])};
  Lane e = fnma(a * y, y, 1.0);
  y = fma(y * e, fma(e, 0.375, 0.5), y);
  e = fnma(a * y, y, 1.0);
  return fma(y * e, 0.5, y);
#else
  return 1.0 / root(a);
#endif
}
POLYARM_INLINE void store(const Lane& value, double* to) {
  for (std::size_t i = 0; i < kParts; ++i)
    *reinterpret_cast<PartAnywhere*>(to + POLYARM_WIDTH * i) = value.v.at[i];
}
POLYARM_INLINE Lane load(const double* from) {
  return POLYARM_EACH(Parts, (Part)(*reinterpret_cast<const PartAnywhere*>(from + POLYARM_WIDTH * i)));
}

}  // namespace POLYARM_LANES

#pragma GCC diagnostic pop
