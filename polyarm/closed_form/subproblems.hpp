#pragma once
/// The small geometric problems that closed-form inverse kinematics consists of (Paden 1985; Kahan 1983; the
/// numbering and the least-squares answers after Elias and Wen 2025), eight at a time. Angles are kept as
/// sine and cosine. If a problem has no solution, the answer is the nearest one, continuous at the border; if
/// any angle is a solution, the answer is the offered one. Private to this room.
#include "polyarm/closed_form/closed_form.hpp"
#include "polyarm/simd/lanes.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace POLYARM_LANES {

/// The angle of the point (c, s). If the point is within `least` of the origin, the answer is `offered` and
/// the lane is marked in `free`.
POLYARM_INLINE LaneAngle toward(Lane s, Lane c, double least, const LaneAngle& offered, LaneMask& free) {
  const Lane square = s * s + c * c;
  const LaneMask any = below(square, splat(least * least));
  free |= any;
  const Lane scale = inverse_root(select(any, splat(1.0), square));
  return {select(any, offered.s, s * scale), select(any, offered.c, c * scale)};
}

/// 1: turns p as near to q as possible, about the unit axis k. Free if either is within `least` of the axis
/// (as the product of both distances).
POLYARM_INLINE LaneAngle subproblem_1(const LaneVec& p, const LaneVec& q, const Vec3& k, double least,
                                      const LaneAngle& offered, LaneMask& free) {
  // From the parts perpendicular to the axis, which keep their digits when they are small.
  const LaneVec a = cross(k, p), b = cross(k, q);
  return toward(dot(k, cross(a, b)), dot(a, b), least, offered, free);
}

/// How solutions that meet are kept apart. On the ideal form of a slightly non-ideal arm, two solutions near
/// a border may be one or none. With `part` > 0 the answer is not the border itself but a solution on either
/// side of it; descents on the true arm find both from there.
struct Edge {
  double part = 0;             ///< of the square of the circle's radius
  double slope = 0;            ///< sqrt(part / (1 - part))
  bool tell = false;           ///< a pose near a border counts as free
  double near = 0;             ///< near: up to this part of the squared radius of the circle
  LaneMask* beyond = nullptr;  ///< output: lanes without a solution; null disables it
};

/// s * along.s + c * along.c = b, the solution on the side of `sign` (+1 or -1). `open` is |along|^2 - b^2;
/// callers may know it to more digits.
POLYARM_INLINE LaneAngle level(const LaneAngle& along, Lane b, Lane open, Lane sign, const Edge& edge,
                               double least, const LaneAngle& offered, LaneMask& free) {
  const Lane square = along.s * along.s + along.c * along.c;
  const LaneMask any = below(square, splat(least * least));
  free |= any;
  if (edge.tell) free |= below(magnitude(open), edge.near * square);
  if (edge.beyond) *edge.beyond |= below(open, Lane{});
  const LaneMask crossing = below(edge.part * square, open);
  const Lane taken = root(select(crossing, open, square * (1.0 - edge.part)));
  const Lane side = sign * select(crossing, taken, taken * edge.slope);
  const Lane ahead = select(crossing, b, with_sign(taken, b));
  const Lane scale = inverse(select(any, splat(1.0), square));
  const LaneAngle out{(ahead * along.s + side * along.c) * scale, (ahead * along.c - side * along.s) * scale};
  return select(any, offered, out);
}

/// The angle between two known lengths at which their ends are a given distance apart (subproblem 3 with
/// points p and q, with everything but the distance constant).
POLYARM_INLINE LaneAngle reach_with(const Reach& known, Lane d_squared, Lane sign, const Edge& edge,
                                    const LaneAngle& offered, LaneMask& free) {
  const Lane b = fnma(d_squared, splat(0.5), splat(known.half));
  return level({splat(known.s), splat(known.c)}, b, (known.radius - b) * (known.radius + b), sign, edge,
               known.least, offered, free);
}

/// 4: h . R(k, angle) p = d.
POLYARM_INLINE LaneAngle subproblem_4(const LaneVec& h, const LaneVec& p, const Vec3& k, Lane d, Lane sign,
                                      const Edge& edge, double least, const LaneAngle& offered,
                                      LaneMask& free) {
  const Lane hk = dot(k, h), pk = dot(k, p);
  const LaneAngle along{dot(h, cross(k, p)), dot(h, p) - hk * pk};
  const Lane b = d - hk * pk;
  return level(along, b, along.s * along.s + along.c * along.c - b * b, sign, edge, least, offered, free);
}

/// 3: |R(k, angle) p - q| = d, with the square of d.
POLYARM_INLINE LaneAngle subproblem_3(const LaneVec& p, const LaneVec& q, const Vec3& k, Lane d_squared,
                                      Lane sign, const Edge& edge, double least, const LaneAngle& offered,
                                      LaneMask& free) {
  return subproblem_4(q, p, k, 0.5 * (dot(p, p) + dot(q, q) - d_squared), sign, edge, least, offered, free);
}

/// 2: R(a, first) p = R(b, second) q. Free if p or q is within `least` of its axis.
POLYARM_INLINE void subproblem_2(const LaneVec& p, const LaneVec& q, const Vec3& a, const Vec3& b, Lane sign,
                                 const Edge& edge, double least, const LaneAngle& offered_first,
                                 const LaneAngle& offered_second, LaneAngle& first, LaneAngle& second,
                                 LaneMask& free) {
  first = subproblem_4(splat(b), p, a, dot(b, q), sign, edge, least, offered_first, free);
  second = subproblem_1(q, turned(a, first, p), b, least * least, offered_second, free);
}

/// 4 for unit vectors: a . R(b, angle) c = a . u. It is exact where u is near +-a and the axes a, b, c have
/// equal angles, which is where a wrist is singular. The opening (1 - (a.b)^2)(1 - (b.c)^2) - (a.u -
/// (a.b)(b.c))^2 is computed with |a x u|^2 instead of 1 - (a.u)^2.
POLYARM_INLINE LaneAngle wrist_bend(const Vec3& a, const Vec3& b, const Vec3& c, const LaneVec& u, Lane sign,
                                    const Edge& edge, LaneMask& free) {
  const double ab = dot(a, b), bc = dot(b, c);
  const Vec3 across = cross(b, c);
  const LaneAngle along{splat(dot(a, across)), splat(dot(a, c) - ab * bc)};
  const Lane d = dot(a, u);
  const LaneVec off = cross(a, u);
  const Lane off2 = dot(off, off), side = with_sign(splat(1.0), d);
  const Lane unequal = ab - side * bc;
  const Lane open = off2 * (1.0 - 2 * ab * bc * side / (1.0 + magnitude(d))) - unequal * unequal;
  return level(along, d - ab * bc, open, sign, edge, 0, {splat(0.0), splat(1.0)}, free);
}

}  // namespace POLYARM_LANES

#pragma GCC diagnostic pop
