#pragma once
/// Eight numbers that go through the same arithmetic side by side. Used inside this room only. Everything
/// here is inlined into its caller and becomes whatever vector instructions that caller is compiled for, or
/// pairs of numbers where it is compiled for any x86-64 (GCC's and Clang's vector extension).
#include <cstddef>

#include "polyarm/base/pose.hpp"
#include "polyarm/kinematics/arm_geometry.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wpedantic"

#define POLYARM_INLINE __attribute__((always_inline)) inline

namespace polyarm::kinematics {

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
/// Where a < b. By the sign of the difference: a comparison as such would be taken apart into eight before it
/// is inlined to where there are instructions for it.
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
/// To the nearest whole number, halves to even; for |a| < 2^51.
POLYARM_INLINE Lane rounded(Lane a) {
  constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52: no bits are left for fractions
  return (a + kShift) - kShift;
}

/// The angle of the point (x, y), to about one unit in the last place; 0 where both are zero. With
/// m = min/max of the sizes reduced to [-tan(pi/8), tan(pi/8)]; the polynomial is the Chebyshev interpolant
/// of atan(m)/m in m^2 there, relative error 4e-17.
POLYARM_INLINE Lane angle_of(Lane y, Lane x) {
  constexpr double kPi = 3.14159265358979323846, kTanEighth = 0.41421356237309503;
  const Lane ax = magnitude(x), ay = magnitude(y);
  const LaneMask steep = below(ax, ay);
  const Lane small = select(steep, ax, ay), large = select(steep, ay, ax);
  const LaneMask wide = below(kTanEighth * large, small);
  const Lane over = select(wide, small - large, small);
  Lane under = select(wide, small + large, large);
  under = select(below(Lane{}, under), under, splat(1.0));
  const Lane m = over / under, z = m * m;
  Lane p = z * 0.021135373157693246 - 0.04348052215716462;
  p = p * z + 0.056883492268090106;
  p = p * z - 0.06640233930429408;
  p = p * z + 0.07689953496306857;
  p = p * z - 0.09090773074808414;
  p = p * z + 0.11111106180455946;
  p = p * z - 0.14285714180976467;
  p = p * z + 0.1999999999885511;
  p = p * z - 0.3333333333332844;
  Lane angle = m + m * z * p;
  angle = select(wide, angle + kPi / 4, angle);
  angle = select(steep, kPi / 2 - angle, angle);
  angle = select((LaneMask)x >> 63, kPi - angle, angle);
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
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
POLYARM_INLINE Lane dot(const Vec3& a, const LaneVec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
POLYARM_INLINE LaneVec cross(const LaneVec& a, const LaneVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
POLYARM_INLINE LaneVec cross(const Vec3& a, const LaneVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
POLYARM_INLINE LaneVec select(LaneMask where, const LaneVec& yes, const LaneVec& no) {
  return {select(where, yes.x, no.x), select(where, yes.y, no.y), select(where, yes.z, no.z)};
}
POLYARM_INLINE LaneVec operator*(const Rotation& r, const LaneVec& v) {
  return {r.x.x * v.x + r.y.x * v.y + r.z.x * v.z, r.x.y * v.x + r.y.y * v.y + r.z.y * v.z,
          r.x.z * v.x + r.y.z * v.y + r.z.z * v.z};
}

/// Eight angles as their sine and cosine.
struct LaneAngle {
  Lane s, c;
};
POLYARM_INLINE LaneAngle operator-(const LaneAngle& a) {
  return {-a.s, a.c};
}
POLYARM_INLINE LaneAngle operator+(const LaneAngle& a, const LaneAngle& b) {
  return {a.s * b.c + a.c * b.s, a.c * b.c - a.s * b.s};
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
  return angle.c * v + angle.s * cross(axis, v) + ((1.0 - angle.c) * dot(axis, v)) * axis;
}

}  // namespace polyarm::kinematics

#pragma GCC diagnostic pop
