#pragma once
/// The families that three neighbouring axes make solvable, eight branches side by side. Used inside this
/// room only.
#include "polyarm/kinematics/closed_form.hpp"
#include "polyarm/kinematics/conic.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {

constexpr double squared(double a) {
  return a * a;
}

struct SixAngles {
  LaneAngle q[6];
  LaneMask free;
};

/// Which of two solutions a branch takes at each of the three places where there are two.
POLYARM_INLINE Lane sign_of_first() {
  return Lane{1, -1, 1, -1, 1, -1, 1, -1};
}
POLYARM_INLINE Lane sign_of_second() {
  return Lane{1, 1, -1, -1, 1, 1, -1, -1};
}
POLYARM_INLINE Lane sign_of_third() {
  return Lane{1, 1, 1, 1, -1, -1, -1, -1};
}

/// Angles 4 to 6 of a wrist that puts axis 6 along `u` and what is beside it along `w`, both as the third
/// link sees them.
POLYARM_INLINE void wrist(const SixAxisForm& f, const Edge& edge, const LaneVec& u, const LaneVec& w,
                          const LaneAngle* offered, SixAngles& out) {
  out.q[4] = wrist_bend(f.h[3], f.h[4], f.h[5], u, sign_of_third(), edge, out.free);
  const LaneVec bent = turned(f.h[4], out.q[4], splat(f.h[5]));
  out.q[3] = subproblem_1(bent, u, f.h[3], squared(f.least_sine), offered[3], out.free);
  const LaneVec back = turned(f.h[4], -out.q[4], turned(f.h[3], -out.q[3], w));
  out.q[5] = subproblem_1(splat(f.beside_6), back, f.h[5], f.least_sine, offered[5], out.free);
}

/// The wrist's point as seen from axis 1, and the rotation from zero to the target.
struct Aim {
  Vec3 p;
  Rotation r;
};
POLYARM_INLINE Aim aim_of(const SixAxisForm& f, const PoseTarget& target) {
  return {target.position + target.rotation * f.center_in_tool - f.first,
          target.rotation * f.from_tool_rotation};
}

POLYARM_INLINE void wrist_2_parallel_3(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                       const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  out.q[0] = subproblem_4(splat(f.h[1]), splat(aim.p), -f.h[0], splat(f.height), sign_of_first(), edge,
                          f.least_length, offered[0], out.free);
  const LaneVec v = turned(f.h[0], -out.q[0], splat(aim.p)) - f.p12;
  // In the plane of both axes only: what is along them has been the first step's.
  const LaneVec flat = v - dot(f.h[1], v) * f.h[1];
  const double least2 = f.least_length * norm(f.p23);
  out.q[2] = subproblem_3(splat(f.p34), splat(-f.p23), f.h[2], dot(flat, flat), sign_of_second(), edge,
                          least2, offered[2], out.free);
  const LaneVec upper = turned(f.h[2], out.q[2], splat(f.p34)) + f.p23;
  out.q[1] = subproblem_1(upper, flat, f.h[1], squared(f.least_length), offered[1], out.free);
  const LaneAngle q23 = out.q[1] + times(f.side_3, out.q[2]);
  const auto seen = [&](const Vec3& world) __attribute__((always_inline)) {
    return turned(f.h[1], -q23, turned(f.h[0], -out.q[0], splat(aim.r * world)));
  };
  wrist(f, edge, seen(f.h[5]), seen(f.beside_6), offered, out);
}

/// With the first three angles known, the wrist.
POLYARM_INLINE void wrist_after(const SixAxisForm& f, const Edge& edge, const Aim& aim,
                                const LaneAngle* offered, SixAngles& out) {
  const auto seen = [&](const Vec3& world) __attribute__((always_inline)) {
    return turned(f.h[2], -out.q[2],
                  turned(f.h[1], -out.q[1], turned(f.h[0], -out.q[0], splat(aim.r * world))));
  };
  wrist(f, edge, seen(f.h[5]), seen(f.beside_6), offered, out);
}

POLYARM_INLINE void wrist_1_parallel_2(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                       const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  const double least2 = f.least_length * norm(f.p12);
  out.q[2] = subproblem_4(splat(f.h[0]), splat(f.p34), f.h[2], splat(dot(f.h[0], aim.p) - f.height),
                          sign_of_first(), edge, f.least_length, offered[2], out.free);
  const LaneVec v = turned(f.h[2], out.q[2], splat(f.p34)) + f.p23;
  const Vec3 flat = aim.p - dot(f.h[0], aim.p) * f.h[0];
  const LaneVec v_flat = v - dot(f.h[0], v) * f.h[0];
  const Vec3 p12 = f.p12 - dot(f.h[0], f.p12) * f.h[0];
  out.q[1] = subproblem_3(v_flat, splat(-p12), f.h[1], splat(dot(flat, flat)), sign_of_second(), edge, least2,
                          offered[1], out.free);
  const LaneVec upper = turned(f.h[1], out.q[1], v_flat) + p12;
  out.q[0] = subproblem_1(upper, splat(flat), f.h[0], squared(f.least_length), offered[0], out.free);
  wrist_after(f, edge, aim, offered, out);
}

POLYARM_INLINE void wrist_1_meets_2(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                    const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  const double least2 = f.least_length * norm(f.p23);
  out.q[2] = subproblem_3(splat(f.p34), splat(-f.p23), f.h[2], splat(dot(aim.p, aim.p)), sign_of_first(),
                          edge, least2, offered[2], out.free);
  const LaneVec v = turned(f.h[2], out.q[2], splat(f.p34)) + f.p23;
  // R1 R2 v = p, that is R1^T p = R2 v.
  LaneAngle back;
  subproblem_2(splat(aim.p), v, f.h[0], f.h[1], sign_of_second(), edge, f.least_length, -offered[0],
               offered[1], back, out.q[1], out.free);
  out.q[0] = -back;
  wrist_after(f, edge, aim, offered, out);
}

POLYARM_INLINE void wrist_2_meets_3(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                    const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  const double least2 = f.least_length * norm(f.p12);
  // |R1^T p - p12| = |p34|
  const LaneAngle back = subproblem_3(splat(aim.p), splat(f.p12), f.h[0], splat(dot(f.p34, f.p34)),
                                      sign_of_first(), edge, least2, -offered[0], out.free);
  out.q[0] = -back;
  const LaneVec v = turned(f.h[0], back, splat(aim.p)) - f.p12;
  LaneAngle back2;
  subproblem_2(v, splat(f.p34), f.h[1], f.h[2], sign_of_second(), edge, f.least_length, -offered[1],
               offered[2], back2, out.q[2], out.free);
  out.q[1] = -back2;
  wrist_after(f, edge, aim, offered, out);
}

/// Any shoulder: the first three angles through a conic.
POLYARM_INLINE void wrist_any(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                              const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  const ShoulderAim shoulder = aim_shoulder(f.shoulder, splat(aim.p), splat(f.p34));
  solve_shoulder(f.shoulder, shoulder, sign_of_first(), sign_of_second(), edge, offered, out.q, out.free);
  wrist_after(f, edge, aim, offered, out);
}

/// Angles 2 to 4 and 6 where 2 to 4 turn about parallel axes and 1 and 5 are known; `elbow` is the side.
POLYARM_INLINE void parallel_middle(const SixAxisForm& f, const Edge& edge, const Aim& aim,
                                    const LaneVec& p46, Lane elbow, const LaneAngle* offered,
                                    SixAngles& out) {
  const LaneVec u = turned(f.h[0], -out.q[0], splat(aim.r * f.h[5]));
  const LaneVec w = turned(f.h[0], -out.q[0], splat(aim.r * f.beside_6));
  // Where axis 6 is parallel to axes 2 to 4 its angle is free, and the sum of theirs follows from it.
  const LaneVec bent = turned(f.h[4], out.q[4], splat(f.h[5]));
  LaneMask singular{};
  LaneAngle q234 = subproblem_1(bent, u, f.h[1], squared(f.least_sine), {splat(0.0), splat(1.0)}, singular);
  const LaneVec across = cross(u, w);
  const LaneVec freed = offered[5].c * w - offered[5].s * across;  // R6^T of what is beside axis 6
  LaneMask never{};
  const LaneAngle q234_free = subproblem_1(turned(f.h[4], out.q[4], splat(f.beside_6)), freed, f.h[1],
                                           f.least_sine, {splat(0.0), splat(1.0)}, never);
  q234 = select(singular, q234_free, q234);
  out.free |= singular;
  const LaneVec back = turned(f.h[4], -out.q[4], turned(f.h[1], -q234, w));
  out.q[5] = subproblem_1(splat(f.beside_6), back, f.h[5], f.least_sine, offered[5], out.free);
  const LaneVec d = turned(f.h[0], -out.q[0], splat(aim.p)) - f.p12 - turned(f.h[1], q234, p46);
  const LaneVec flat = d - dot(f.h[1], d) * f.h[1];
  const double least2 = f.least_length * norm(f.p23);
  out.q[2] = subproblem_3(splat(f.p34), splat(-f.p23), f.h[2], dot(flat, flat), elbow, edge, least2,
                          offered[2], out.free);
  const LaneVec upper = turned(f.h[2], out.q[2], splat(f.p34)) + f.p23;
  out.q[1] = subproblem_1(upper, flat, f.h[1], squared(f.least_length), offered[1], out.free);
  const LaneAngle q23 = out.q[1] + times(f.side_3, out.q[2]);
  out.q[3] = times(f.side_4, q234 + -q23);
}

/// Axes 5 and 6 apart: heights along axis 2 of a point and of a direction tie angle 5 to angle 1.
POLYARM_INLINE void parallel_234_apart(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                       const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  const Vec3 u = aim.r * f.h[5];
  const double h12 = dot(f.h[0], f.h[1]), h25 = dot(f.h[1], f.h[4]);
  const Vec3 turn = cross(f.h[1], f.h[0]);  // h2 . (h1 x v) = turn . v
  const Vec3 flat = f.h[1] - h12 * f.h[0];
  const double a[2][3] = {
      {h12 * dot(f.h[0], aim.p) - f.height - h25 * dot(f.h[4], f.p56), dot(flat, aim.p), -dot(turn, aim.p)},
      {h12 * dot(f.h[0], u) - h25 * dot(f.h[4], f.h[5]), dot(flat, u), -dot(turn, u)}};
  double five[2][3];
  for (int k = 0; k < 3; ++k) {
    five[0][k] = f.from_5[0] * a[0][k] + f.from_5[1] * a[1][k];
    five[1][k] = f.from_5[2] * a[0][k] + f.from_5[3] * a[1][k];
  }
  LaneConic conic;
  for (const auto& row : five) conic.add_square(splat(row[0]), splat(row[1]), splat(row[2]), 1);
  conic.one -= 1.0;
  const LaneLines lines = lines_of(conic, squared(f.least_sine));
  const LaneMask second = below(sign_of_first(), Lane{});
  out.q[0] = point_on(select(second, lines.normal[1], lines.normal[0]),
                      select(second, lines.reach[1], lines.reach[0]), sign_of_second(), edge, out.free);
  const auto value = [&](const double(&row)[3]) __attribute__((always_inline)) {
    return row[0] + row[1] * out.q[0].c + row[2] * out.q[0].s;
  };
  out.q[4] = toward(value(five[1]), value(five[0]), 1e-9, offered[4], out.free);
  const LaneVec p46 = turned(f.h[4], out.q[4], splat(f.p56)) + f.p45;
  parallel_middle(f, edge, aim, p46, sign_of_third(), offered, out);
}

POLYARM_INLINE void parallel_234(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                 const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  out.q[0] = subproblem_4(splat(f.h[1]), splat(aim.p), -f.h[0], splat(f.height), sign_of_first(), edge,
                          f.least_length, offered[0], out.free);
  const LaneVec u = turned(f.h[0], -out.q[0], splat(aim.r * f.h[5]));
  out.q[4] = wrist_bend(f.h[1], f.h[4], f.h[5], u, sign_of_third(), edge, out.free);
  parallel_middle(f, edge, aim, splat(f.p45), sign_of_second(), offered, out);
}

POLYARM_INLINE void parallel_123(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                 const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  out.q[3] = subproblem_4(splat(f.h[0]), splat(f.p45), f.h[3], splat(dot(f.h[0], aim.p) - f.height),
                          sign_of_first(), edge, f.least_length, offered[3], out.free);
  // h1 . R4 R5 = (R^T h1) . R6^T, of which h5 keeps its part whatever q5 is.
  const Vec3 seen = transposed(aim.r) * f.h[0];
  const LaneVec lifted = turned(f.h[3], -out.q[3], splat(f.h[0]));
  out.q[5] = subproblem_4(splat(seen), splat(f.h[4]), -f.h[5], dot(f.h[4], lifted), sign_of_third(), edge,
                          f.least_sine, offered[5], out.free);
  const LaneVec from_six = turned(f.h[5], out.q[5], splat(seen));
  const LaneAngle back = subproblem_1(lifted, from_six, -f.h[4], squared(f.least_sine), offered[4], out.free);
  out.q[4] = back;
  // All that turns about axis 1 together.
  const LaneVec before =
      turned(f.h[3], out.q[3],
             turned(f.h[4], out.q[4], turned(f.h[5], out.q[5], splat(transposed(aim.r) * f.beside_1))));
  const LaneAngle q123 =
      subproblem_1(before, splat(f.beside_1), f.h[0], f.least_sine, {splat(0.0), splat(1.0)}, out.free);
  const LaneVec arm = turned(f.h[0], q123, turned(f.h[3], out.q[3], splat(f.p45)) + f.p34);
  const LaneVec d = splat(aim.p) - arm;
  const LaneVec flat = d - dot(f.h[0], d) * f.h[0];
  const Vec3 p12 = f.p12 - dot(f.h[0], f.p12) * f.h[0], p23 = f.p23 - dot(f.h[0], f.p23) * f.h[0];
  const double least2 = f.least_length * norm(p12);
  out.q[1] = subproblem_3(splat(p23), splat(-p12), f.h[1], dot(flat, flat), sign_of_second(), edge, least2,
                          offered[1], out.free);
  const LaneVec upper = turned(f.h[1], out.q[1], splat(p23)) + p12;
  out.q[0] = subproblem_1(upper, flat, f.h[0], squared(f.least_length), offered[0], out.free);
  const LaneAngle q12 = out.q[0] + times(f.side_3, out.q[1]);
  out.q[2] = times(f.side_4, q123 + -q12);
}

POLYARM_INLINE void solve_family(const SixAxisForm& f, const PoseTarget& target, const LaneAngle* offered,
                                 SixAngles& out) {
  const Edge edge{f.edge, __builtin_sqrt(f.edge / (1 - f.edge)), f.wary};
  out.free = LaneMask{};
  switch (f.family) {
    case ArmFamily::wrist_2_parallel_3:
      return wrist_2_parallel_3(f, edge, target, offered, out);
    case ArmFamily::wrist_1_parallel_2:
      return wrist_1_parallel_2(f, edge, target, offered, out);
    case ArmFamily::wrist_1_meets_2:
      return wrist_1_meets_2(f, edge, target, offered, out);
    case ArmFamily::wrist_2_meets_3:
      return wrist_2_meets_3(f, edge, target, offered, out);
    case ArmFamily::parallel_234_5_meets_6:
      return parallel_234(f, edge, target, offered, out);
    case ArmFamily::wrist:
      return wrist_any(f, edge, target, offered, out);
    case ArmFamily::parallel_234:
      return parallel_234_apart(f, edge, target, offered, out);
    case ArmFamily::parallel_123_5_meets_6:
      return parallel_123(f, edge, target, offered, out);
    default:
      for (LaneAngle& angle : out.q) angle = {splat(0.0), splat(1.0)};
  }
}

}  // namespace polyarm::kinematics

#pragma GCC diagnostic pop
