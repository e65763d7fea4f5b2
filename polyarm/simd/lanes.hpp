#pragma once
/// Arithmetic on eight numbers side by side. Private to the kernels. Everything here is inlined into its
/// caller and becomes the vector instructions that the caller is compiled for, or pairs of numbers if the
/// caller is compiled for any x86-64 (vector extension of GCC and Clang). A file that is compiled once for
/// each instruction set defines POLYARM_WIDTH, the numbers in one register, and POLYARM_LANES, its own
/// namespace (native_eight.hpp).
#include <cstddef>

#include "polyarm/base/pose.hpp"
#include "polyarm/simd/rotation.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"

#define POLYARM_INLINE __attribute__((always_inline)) inline
#ifndef POLYARM_LANES
#define POLYARM_LANES polyarm::kinematics
#endif

#ifdef POLYARM_WIDTH
#include "polyarm/simd/native_eight.hpp"
#else
namespace POLYARM_LANES {

inline constexpr std::size_t kLanes = 8;
typedef double Lane __attribute__((vector_size(64)));
typedef long long LaneMask __attribute__((vector_size(64)));  ///< all bits set: true

POLYARM_INLINE Lane splat(double v) {
  return Lane{} + v;
}
POLYARM_INLINE Lane select(LaneMask where, Lane yes, Lane no) {
  return (Lane)((where & (LaneMask)yes) | (~where & (LaneMask)no));
}
POLYARM_INLINE Lane magnitude(Lane a) {
  return (Lane)((LaneMask)a & 0x7fffffffffffffffLL);
}
/// The size of `a` with the sign of `sign`.
POLYARM_INLINE Lane with_sign(Lane a, Lane sign) {
  constexpr long long kSign = static_cast<long long>(0x8000000000000000ULL);
  return (Lane)(((LaneMask)a & ~kSign) | ((LaneMask)sign & kSign));
}
/// True where a < b. Uses the sign of the difference: the compiler would split a comparison into eight
/// scalars before it inlines it.
POLYARM_INLINE LaneMask below(Lane a, Lane b) {
  return (LaneMask)(a - b) >> 63;
}
POLYARM_INLINE Lane root(Lane a) {
#if defined(__SSE2__)
  typedef double Pair __attribute__((vector_size(16)));
  typedef double Four __attribute__((vector_size(32)));
  const Pair p0 = __builtin_ia32_sqrtpd(__builtin_shufflevector(a, a, 0, 1));
  const Pair p1 = __builtin_ia32_sqrtpd(__builtin_shufflevector(a, a, 2, 3));
  const Pair p2 = __builtin_ia32_sqrtpd(__builtin_shufflevector(a, a, 4, 5));
  const Pair p3 = __builtin_ia32_sqrtpd(__builtin_shufflevector(a, a, 6, 7));
  const Four low = __builtin_shufflevector(p0, p1, 0, 1, 2, 3),
             high = __builtin_shufflevector(p2, p3, 0, 1, 2, 3);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  Lane out;
  for (std::size_t i = 0; i < kLanes; ++i) out[i] = __builtin_sqrt(a[i]);
  return out;
#endif
}
POLYARM_INLINE LaneMask of_unlike_sign(Lane a, Lane b) {
  return ((LaneMask)a ^ (LaneMask)b) >> 63;
}
/// a * b + c
POLYARM_INLINE Lane fma(Lane a, Lane b, Lane c) {
  return a * b + c;
}
/// c - a * b
POLYARM_INLINE Lane fnma(Lane a, Lane b, Lane c) {
  return c - a * b;
}
POLYARM_INLINE Lane least_of(Lane a, Lane b) {
  return select(below(a, b), a, b);
}
POLYARM_INLINE Lane most_of(Lane a, Lane b) {
  return select(below(a, b), b, a);
}
POLYARM_INLINE Lane inverse(Lane a) {
  return 1.0 / a;
}
POLYARM_INLINE Lane inverse_root(Lane a) {
  return 1.0 / root(a);
}

}  // namespace POLYARM_LANES
#endif

namespace POLYARM_LANES {

/// To the nearest integer, halves to even; for |a| < 2^51.
POLYARM_INLINE Lane rounded(Lane a) {
  constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52: no bits are left for fractions
  return (a + kShift) - kShift;
}

/// `a` minus its nearest integer.
POLYARM_INLINE Lane off_whole(const Lane& a) {
#if defined(POLYARM_WIDTH) && POLYARM_WIDTH == 8
  return Parts{(Part)_mm512_reduce_pd((__m512d)a.v.at[0], 0)};
#else
  return a - rounded(a);
#endif
}

/// The angle of the point (x, y), to about one unit in the last place; 0 if both are zero. m = min/max of the
/// sizes is reduced to [-tan(pi/8), tan(pi/8)]; there the polynomial is the Chebyshev interpolant of
/// atan(m)/m in m^2 with a relative error of 4e-17.
POLYARM_INLINE Lane angle_of(Lane y, Lane x) {
  constexpr double kPi = 3.14159265358979323846, kTanEighth = 0.41421356237309503;
  const Lane ax = magnitude(x), ay = magnitude(y);
  const LaneMask steep = below(ax, ay);
  const Lane small = least_of(ax, ay), large = most_of(ax, ay);
  const LaneMask wide = below(kTanEighth * large, small);
  const Lane over = select(wide, small - large, small);
  const Lane under = most_of(select(wide, small + large, large), splat(1e-290));
  const Lane m = over * inverse(under), z = m * m, z2 = z * z;
  // In pairs, to shorten the chain of dependent steps.
  const auto pair = [&](double a, double b) __attribute__((always_inline)) {
    return fma(z, splat(b), splat(a));
  };
  const Lane high = fma(z2, splat(0.021135373157693246), pair(0.056883492268090106, -0.04348052215716462));
  const Lane middle = fma(z2, high, pair(0.07689953496306857, -0.06640233930429408));
  const Lane low = fma(z2, middle, pair(0.11111106180455946, -0.09090773074808414));
  const Lane p =
      fma(z2, fma(z2, low, pair(0.1999999999885511, -0.14285714180976467)), -0.3333333333332844 * z);
  Lane angle = fma(m, p, m);
  angle = select(wide, angle + kPi / 4, angle);
  angle = select(steep, kPi / 2 - angle, angle);
  angle = select(below(x, Lane{}), kPi - angle, angle);
  return with_sign(angle, y);
}

/// Eight vectors.
struct LaneVec {
  Lane x, y, z;
};
POLYARM_INLINE LaneVec splat(const Vec3& v) {
  return {splat(v.x), splat(v.y), splat(v.z)};
}
POLYARM_INLINE LaneVec operator+(const LaneVec& a, const LaneVec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
POLYARM_INLINE LaneVec operator-(const LaneVec& a, const LaneVec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
POLYARM_INLINE LaneVec operator+(const LaneVec& a, const Vec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
POLYARM_INLINE LaneVec operator-(const LaneVec& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
POLYARM_INLINE LaneVec operator*(Lane s, const LaneVec& a) {
  return {s * a.x, s * a.y, s * a.z};
}
POLYARM_INLINE LaneVec operator*(Lane s, const Vec3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
POLYARM_INLINE Lane dot(const LaneVec& a, const LaneVec& b) {
  return fma(a.z, b.z, fma(a.y, b.y, a.x * b.x));
}
POLYARM_INLINE Lane dot(const Vec3& a, const LaneVec& b) {
  return fma(splat(a.z), b.z, fma(splat(a.y), b.y, a.x * b.x));
}
POLYARM_INLINE LaneVec cross(const LaneVec& a, const LaneVec& b) {
  return {fnma(a.z, b.y, a.y * b.z), fnma(a.x, b.z, a.z * b.x), fnma(a.y, b.x, a.x * b.y)};
}
POLYARM_INLINE LaneVec cross(const Vec3& a, const LaneVec& b) {
  return {fnma(splat(a.z), b.y, a.y * b.z), fnma(splat(a.x), b.z, a.z * b.x),
          fnma(splat(a.y), b.x, a.x * b.y)};
}
POLYARM_INLINE LaneVec select(LaneMask where, const LaneVec& yes, const LaneVec& no) {
  return {select(where, yes.x, no.x), select(where, yes.y, no.y), select(where, yes.z, no.z)};
}
POLYARM_INLINE LaneVec operator*(const Rotation& r, const LaneVec& v) {
  const auto row = [&](double x, double y, double z) __attribute__((always_inline)) {
    return fma(splat(z), v.z, fma(splat(y), v.y, x * v.x));
  };
  return {row(r.x.x, r.y.x, r.z.x), row(r.x.y, r.y.y, r.z.y), row(r.x.z, r.y.z, r.z.z)};
}

/// Eight angles as their sine and cosine.
struct LaneAngle {
  Lane s, c;
};
POLYARM_INLINE LaneAngle operator-(const LaneAngle& a) {
  return {-a.s, a.c};
}
POLYARM_INLINE LaneAngle operator+(const LaneAngle& a, const LaneAngle& b) {
  return {fma(a.c, b.s, a.s * b.c), fnma(a.s, b.s, a.c * b.c)};
}
POLYARM_INLINE LaneAngle select(LaneMask where, const LaneAngle& yes, const LaneAngle& no) {
  return {select(where, yes.s, no.s), select(where, yes.c, no.c)};
}
/// The angle times +1 or -1.
POLYARM_INLINE LaneAngle times(double side, const LaneAngle& a) {
  return {side * a.s, a.c};
}
/// `v` turned about a unit axis (Rodrigues' formula).
POLYARM_INLINE LaneVec turned(const Vec3& axis, const LaneAngle& angle, const LaneVec& v) {
  const LaneVec across = cross(axis, v);
  const Lane along = (1.0 - angle.c) * dot(axis, v);
  const auto part = [&](Lane a, Lane b, double k) __attribute__((always_inline)) {
    return fma(splat(k), along, fma(angle.s, b, angle.c * a));
  };
  return {part(v.x, across.x, axis.x), part(v.y, across.y, axis.y), part(v.z, across.z, axis.z)};
}

/// The same for one vector in all lanes; the parts along and across the axis are computed once.
POLYARM_INLINE LaneVec turned(const Vec3& axis, const LaneAngle& angle, const Vec3& v) {
  const Vec3 still = dot(axis, v) * axis, ahead = v - still, across = cross(axis, v);
  const auto part = [&](double a, double b, double c) __attribute__((always_inline)) {
    return fma(splat(c), angle.s, fma(splat(b), angle.c, splat(a)));
  };
  return {part(still.x, ahead.x, across.x), part(still.y, ahead.y, across.y),
          part(still.z, ahead.z, across.z)};
}

}  // namespace POLYARM_LANES

#pragma GCC diagnostic pop
