#pragma once
/// The families that three neighbouring axes make solvable, eight branches side by side. Private to this
/// room.
#include "polyarm/closed_form/closed_form.hpp"
#include "polyarm/closed_form/conic.hpp"
#include "polyarm/closed_form/lane_polish.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace POLYARM_LANES {

/// Eight targets: the columns of their rotations, and their positions.
struct LaneTarget {
  struct {
    LaneVec x, y, z;
  } rotation;
  LaneVec position;
};
POLYARM_INLINE LaneTarget splat(const PoseTarget& target) {
  return {{splat(target.rotation.x), splat(target.rotation.y), splat(target.rotation.z)},
          splat(target.position)};
}
POLYARM_INLINE LaneVec turned_by(const LaneTarget& t, const Vec3& v) {
  const auto part = [&](const Lane& x, const Lane& y, const Lane& z) __attribute__((always_inline)) {
    return fma(splat(v.z), z, fma(splat(v.y), y, v.x * x));
  };
  const auto& [x, y, z] = t.rotation;
  return {part(x.x, y.x, z.x), part(x.y, y.y, z.y), part(x.z, y.z, z.z)};
}
POLYARM_INLINE LaneVec turned_back_by(const LaneTarget& t, const LaneVec& v) {
  return {dot(t.rotation.x, v), dot(t.rotation.y, v), dot(t.rotation.z, v)};
}
/// The pose of the base in the frame of the target.
POLYARM_INLINE LaneTarget inverse(const LaneTarget& t) {
  const auto& [x, y, z] = t.rotation;
  const LaneVec p = turned_back_by(t, t.position);
  return {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, {-p.x, -p.y, -p.z}};
}

/// The wrist's point relative to axis 1, and the rotation from zero to the target.
struct Aim {
  Vec3 p;
  Rotation r;
};
POLYARM_INLINE Aim aim_of(const SixAxisForm& f, const PoseTarget& target) {
  return {target.position + target.rotation * f.center_in_tool - f.first,
          target.rotation * f.from_tool_rotation};
}
/// The same in lanes. Families use of the rotation only the direction of axis 6 and of its perpendicular.
struct LaneAim {
  LaneVec p, u, w;
};
POLYARM_INLINE LaneAim aim_of(const SixAxisForm& f, const LaneTarget& t) {
  return {t.position + turned_by(t, f.center_in_tool) - f.first, turned_by(t, f.axis_in_tool),
          turned_by(t, f.beside_in_tool)};
}

/// The sign of the solution that a branch takes at each of the three places with two solutions.
POLYARM_INLINE Lane sign_of_first() {
  return Lane{1, 1, 1, 1, -1, -1, -1, -1};
}
POLYARM_INLINE Lane sign_of_second() {
  return Lane{1, 1, -1, -1, 1, 1, -1, -1};
}
POLYARM_INLINE Lane sign_of_third() {
  return Lane{1, -1, 1, -1, 1, -1, 1, -1};
}

/// Eight questions on their way through a family. Each of three steps has two solutions. A step stores what
/// later steps need, so eight branches of one question and one branch of eight questions use the same
/// arithmetic.
struct Question {
  LaneAim aim;
  LaneTarget target;
  LaneAngle offered[6];
  LaneAngle q[6];
  LaneMask free[3], beyond[3];  ///< for each step: an angle is free; there is no solution, only a nearest one
  LaneVec seen_1, u_1, w_1, u_2, w_2, held;
  LaneAngle turned_1;
};

POLYARM_INLINE Edge edge_of(const SixAxisForm& f, Question& s, std::size_t step) {
  return {f.edge, f.edge_slope, f.wary, f.near_edge, &s.beyond[step]};
}

/// Angles 4 to 6 of a wrist that turns axis 6 to u_2 and its perpendicular to w_2, both in the frame of the
/// third link. A square wrist bends equally to either side, with axes 4 and 6 half a turn further.
POLYARM_INLINE void wrist(const SixAxisForm& f, Question& s, Lane sign) {
  const Edge edge = edge_of(f, s, 2);
  const Lane bend = f.square_wrist ? splat(1.0) : sign;
  s.q[4] = wrist_bend(f.h[3], f.h[4], f.h[5], s.u_2, bend, edge, s.free[2]);
  const LaneVec bent = turned(f.h[4], s.q[4], f.h[5]);
  s.q[3] = subproblem_1(bent, s.u_2, f.h[3], squared(f.least_sine), s.offered[3], s.free[2]);
  const LaneVec back = turned(f.h[4], -s.q[4], turned(f.h[3], -s.q[3], s.w_2));
  s.q[5] = subproblem_1(splat(f.beside_6), back, f.h[5], f.least_sine, s.offered[5], s.free[2]);
}

/// The other solution of a square wrist that is not singular.
POLYARM_INLINE void flip(const SixAxisForm& f, Question& s, Lane side) {
  if (!f.square_wrist) return;
  const Lane sign = select(s.free[2], splat(1.0), side);
  const LaneMask over = below(sign, Lane{});
  const Lane twice = 2.0 * (s.q[4].s * f.bend_s + s.q[4].c * f.bend_c);
  s.q[3] = {sign * s.q[3].s, sign * s.q[3].c};
  s.q[4] = select(over, LaneAngle{twice * f.bend_s - s.q[4].s, twice * f.bend_c - s.q[4].c}, s.q[4]);
  s.q[5] = {sign * s.q[5].s, sign * s.q[5].c};
}

/// The wrist, after the first three angles are known.
POLYARM_INLINE void see_wrist(const SixAxisForm& f, Question& s) {
  const auto seen = [&](const LaneVec& v) __attribute__((always_inline)) {
    return turned(f.h[2], -s.q[2], turned(f.h[1], -s.q[1], turned(f.h[0], -s.q[0], v)));
  };
  s.u_2 = seen(s.aim.u);
  s.w_2 = seen(s.aim.w);
}

struct Wrist2Parallel3 {
  static constexpr int kFrom[4] = {0, 1, 3, 6};
  static constexpr int kAxes[6] = {0, 1, 2, 3, 4, 5};  ///< in the order in which the steps find them
  POLYARM_INLINE static void first(const SixAxisForm& f, Question& s, Lane sign) {
    s.q[0] = subproblem_4(splat(f.h[1]), s.aim.p, -f.h[0], splat(f.height), sign, edge_of(f, s, 0),
                          f.least_length, s.offered[0], s.free[0]);
    const LaneVec v = turned(f.h[0], -s.q[0], s.aim.p) - f.p12;
    // In the plane perpendicular to both axes only: the first step has solved the part along them.
    s.held = v - dot(f.h[1], v) * f.h[1];
    s.u_1 = turned(f.h[0], -s.q[0], s.aim.u);
    s.w_1 = turned(f.h[0], -s.q[0], s.aim.w);
  }
  POLYARM_INLINE static void second(const SixAxisForm& f, Question& s, Lane sign) {
    s.q[2] = reach_with(f.elbow, dot(s.held, s.held), sign, edge_of(f, s, 1), s.offered[2], s.free[1]);
    const LaneVec upper = turned(f.h[2], s.q[2], f.p34) + f.p23;
    s.q[1] = subproblem_1(upper, s.held, f.h[1], squared(f.least_length), s.offered[1], s.free[1]);
    const LaneAngle q23 = s.q[1] + times(f.side_3, s.q[2]);
    s.u_2 = turned(f.h[1], -q23, s.u_1);
    s.w_2 = turned(f.h[1], -q23, s.w_1);
  }
  POLYARM_INLINE static void third(const SixAxisForm& f, Question& s, Lane sign) { wrist(f, s, sign); }
};

struct Wrist1Parallel2 {
  static constexpr int kFrom[4] = {0, 1, 3, 6};
  static constexpr int kAxes[6] = {2, 0, 1, 3, 4, 5};
  POLYARM_INLINE static void first(const SixAxisForm& f, Question& s, Lane sign) {
    const Lane along = dot(f.h[0], s.aim.p);
    s.q[2] = subproblem_4(splat(f.h[0]), splat(f.p34), f.h[2], along - f.height, sign, edge_of(f, s, 0),
                          f.least_length, s.offered[2], s.free[0]);
    const LaneVec v = turned(f.h[2], s.q[2], f.p34) + f.p23;
    s.held = v - dot(f.h[0], v) * f.h[0];
    s.seen_1 = s.aim.p - along * f.h[0];
  }
  POLYARM_INLINE static void second(const SixAxisForm& f, Question& s, Lane sign) {
    const Vec3 p12 = f.p12 - dot(f.h[0], f.p12) * f.h[0];
    s.q[1] = subproblem_3(s.held, splat(-p12), f.h[1], dot(s.seen_1, s.seen_1), sign, edge_of(f, s, 1),
                          f.least_length * norm(f.p12), s.offered[1], s.free[1]);
    const LaneVec upper = turned(f.h[1], s.q[1], s.held) + p12;
    s.q[0] = subproblem_1(upper, s.seen_1, f.h[0], squared(f.least_length), s.offered[0], s.free[1]);
    see_wrist(f, s);
  }
  POLYARM_INLINE static void third(const SixAxisForm& f, Question& s, Lane sign) { wrist(f, s, sign); }
};

struct Wrist1Meets2 {
  static constexpr int kFrom[4] = {0, 1, 3, 6};
  static constexpr int kAxes[6] = {2, 0, 1, 3, 4, 5};
  POLYARM_INLINE static void first(const SixAxisForm& f, Question& s, Lane sign) {
    s.q[2] = reach_with(f.elbow, dot(s.aim.p, s.aim.p), sign, edge_of(f, s, 0), s.offered[2], s.free[0]);
    s.held = turned(f.h[2], s.q[2], f.p34) + f.p23;
  }
  POLYARM_INLINE static void second(const SixAxisForm& f, Question& s, Lane sign) {
    // R1 R2 v = p, that is R1^T p = R2 v.
    LaneAngle back;
    subproblem_2(s.aim.p, s.held, f.h[0], f.h[1], sign, edge_of(f, s, 1), f.least_length, -s.offered[0],
                 s.offered[1], back, s.q[1], s.free[1]);
    s.q[0] = -back;
    see_wrist(f, s);
  }
  POLYARM_INLINE static void third(const SixAxisForm& f, Question& s, Lane sign) { wrist(f, s, sign); }
};

struct Wrist2Meets3 {
  static constexpr int kFrom[4] = {0, 1, 3, 6};
  static constexpr int kAxes[6] = {0, 1, 2, 3, 4, 5};
  POLYARM_INLINE static void first(const SixAxisForm& f, Question& s, Lane sign) {
    // |R1^T p - p12| = |p34|
    const LaneAngle back =
        subproblem_3(s.aim.p, splat(f.p12), f.h[0], splat(dot(f.p34, f.p34)), sign, edge_of(f, s, 0),
                     f.least_length * norm(f.p12), -s.offered[0], s.free[0]);
    s.q[0] = -back;
    s.held = turned(f.h[0], back, s.aim.p) - f.p12;
  }
  POLYARM_INLINE static void second(const SixAxisForm& f, Question& s, Lane sign) {
    LaneAngle back;
    subproblem_2(s.held, splat(f.p34), f.h[1], f.h[2], sign, edge_of(f, s, 1), f.least_length, -s.offered[1],
                 s.offered[2], back, s.q[2], s.free[1]);
    s.q[1] = -back;
    see_wrist(f, s);
  }
  POLYARM_INLINE static void third(const SixAxisForm& f, Question& s, Lane sign) { wrist(f, s, sign); }
};

/// The sum of angles 2 to 4 for parallel axes, with 1 and 5 known, and angle 6. If axis 6 is parallel to axes
/// 2 to 4, its angle is free and determines the sum.
POLYARM_INLINE LaneAngle parallel_sum(const SixAxisForm& f, Question& s, const LaneVec& u, const LaneVec& w,
                                      std::size_t step) {
  const LaneVec bent = turned(f.h[4], s.q[4], f.h[5]);
  LaneMask singular{};
  LaneAngle q234 = subproblem_1(bent, u, f.h[1], squared(f.least_sine), {splat(0.0), splat(1.0)}, singular);
  if (bits_of(singular) != 0) {
    const LaneVec across = cross(u, w);
    const LaneVec freed = s.offered[5].c * w - s.offered[5].s * across;  // R6^T of the perpendicular of axis
                                                                         // 6
    LaneMask never{};
    const LaneAngle q234_free = subproblem_1(turned(f.h[4], s.q[4], f.beside_6), freed, f.h[1], f.least_sine,
                                             {splat(0.0), splat(1.0)}, never);
    q234 = select(singular, q234_free, q234);
    s.free[step] |= singular;
  }
  const LaneVec back = turned(f.h[4], -s.q[4], turned(f.h[1], -q234, w));
  s.q[5] = subproblem_1(splat(f.beside_6), back, f.h[5], f.least_sine, s.offered[5], s.free[step]);
  return q234;
}
/// Angles 2 to 4 with that sum that put the fourth joint's point at `d`.
POLYARM_INLINE void parallel_parts(const SixAxisForm& f, Question& s, const LaneVec& flat,
                                   const LaneAngle& q234, Lane elbow) {
  s.q[2] = reach_with(f.elbow, dot(flat, flat), elbow, edge_of(f, s, 2), s.offered[2], s.free[2]);
  const LaneVec upper = turned(f.h[2], s.q[2], f.p34) + f.p23;
  s.q[1] = subproblem_1(upper, flat, f.h[1], squared(f.least_length), s.offered[1], s.free[2]);
  const LaneAngle q23 = s.q[1] + times(f.side_3, s.q[2]);
  s.q[3] = times(f.side_4, q234 + -q23);
}

struct Parallel234 {
  static constexpr int kFrom[4] = {0, 1, 3, 6};
  static constexpr int kAxes[6] = {0, 4, 5, 1, 2, 3};
  POLYARM_INLINE static void first(const SixAxisForm& f, Question& s, Lane sign) {
    s.q[0] = subproblem_4(splat(f.h[1]), s.aim.p, -f.h[0], splat(f.height), sign, edge_of(f, s, 0),
                          f.least_length, s.offered[0], s.free[0]);
    s.u_1 = turned(f.h[0], -s.q[0], s.aim.u);
    s.w_1 = turned(f.h[0], -s.q[0], s.aim.w);
    s.seen_1 = turned(f.h[0], -s.q[0], s.aim.p) - f.p12;
  }
  POLYARM_INLINE static void second(const SixAxisForm& f, Question& s, Lane sign) {
    s.q[4] = wrist_bend(f.h[1], f.h[4], f.h[5], s.u_1, sign, edge_of(f, s, 1), s.free[1]);
    s.turned_1 = parallel_sum(f, s, s.u_1, s.w_1, 1);
    const LaneVec d = s.seen_1 - turned(f.h[1], s.turned_1, f.p45);
    s.held = d - dot(f.h[1], d) * f.h[1];
  }
  POLYARM_INLINE static void third(const SixAxisForm& f, Question& s, Lane sign) {
    parallel_parts(f, s, s.held, s.turned_1, sign);
  }
};

struct Parallel123 {
  static constexpr int kFrom[4] = {0, 1, 3, 6};
  static constexpr int kAxes[6] = {3, 4, 5, 0, 1, 2};
  POLYARM_INLINE static void first(const SixAxisForm& f, Question& s, Lane sign) {
    s.q[3] = subproblem_4(splat(f.h[0]), splat(f.p45), f.h[3], dot(f.h[0], s.aim.p) - f.height, sign,
                          edge_of(f, s, 0), f.least_length, s.offered[3], s.free[0]);
    s.seen_1 = turned(f.h[3], s.q[3], f.p45) + f.p34;
    s.u_1 = turned(f.h[3], -s.q[3], f.h[0]);
  }
  POLYARM_INLINE static void second(const SixAxisForm& f, Question& s, Lane sign) {
    // h1 . R4 R5 = (R^T h1) . R6^T; the part along h5 does not depend on q5.
    const auto at_tool = [&](const Vec3& v) __attribute__((always_inline)) {
      return f.tool_rotation * turned_back_by(s.target, splat(v));
    };
    const LaneVec seen = at_tool(f.h[0]);
    s.q[5] = subproblem_4(seen, splat(f.h[4]), -f.h[5], dot(f.h[4], s.u_1), sign, edge_of(f, s, 1),
                          f.least_sine, s.offered[5], s.free[1]);
    const LaneVec from_six = turned(f.h[5], s.q[5], seen);
    s.q[4] = subproblem_1(s.u_1, from_six, -f.h[4], squared(f.least_sine), s.offered[4], s.free[1]);
    // Everything that turns about axis 1.
    const LaneVec before =
        turned(f.h[3], s.q[3], turned(f.h[4], s.q[4], turned(f.h[5], s.q[5], at_tool(f.beside_1))));
    s.turned_1 =
        subproblem_1(before, splat(f.beside_1), f.h[0], f.least_sine, {splat(0.0), splat(1.0)}, s.free[1]);
    const LaneVec d = s.aim.p - turned(f.h[0], s.turned_1, s.seen_1);
    s.held = d - dot(f.h[0], d) * f.h[0];
  }
  POLYARM_INLINE static void third(const SixAxisForm& f, Question& s, Lane sign) {
    const Vec3 p12 = f.p12 - dot(f.h[0], f.p12) * f.h[0], p23 = f.p23 - dot(f.h[0], f.p23) * f.h[0];
    s.q[1] = subproblem_3(splat(p23), splat(-p12), f.h[1], dot(s.held, s.held), sign, edge_of(f, s, 2),
                          f.least_length * norm(p12), s.offered[1], s.free[2]);
    const LaneVec upper = turned(f.h[1], s.q[1], p23) + p12;
    s.q[0] = subproblem_1(upper, s.held, f.h[0], squared(f.least_length), s.offered[0], s.free[2]);
    const LaneAngle q12 = s.q[0] + times(f.side_3, s.q[1]);
    s.q[2] = times(f.side_4, s.turned_1 + -q12);
  }
};

/// A general shoulder: the first three angles from a conic.
__attribute__((noinline)) inline void wrist_any(const SixAxisForm& f, Question& s) {
  const ShoulderAim shoulder = aim_shoulder(f.shoulder, s.aim.p, splat(f.p34));
  solve_shoulder(f.shoulder, shoulder, sign_of_first(), sign_of_second(), edge_of(f, s, 0), s.offered, s.q,
                 s.free[0]);
  see_wrist(f, s);
  wrist(f, s, sign_of_third());
  flip(f, s, sign_of_third());
}

/// If axes 5 and 6 do not meet: the heights along axis 2 of a point and of a direction relate angle 5 to
/// angle 1.
__attribute__((noinline)) inline void parallel_234_apart(const SixAxisForm& f, Question& s) {
  const LaneAim& aim = s.aim;
  const double h12 = dot(f.h[0], f.h[1]), h25 = dot(f.h[1], f.h[4]);
  const Vec3 turn = cross(f.h[1], f.h[0]);  // h2 . (h1 x v) = turn . v
  const Vec3 flat = f.h[1] - h12 * f.h[0];
  const Lane a[2][3] = {
      {h12 * dot(f.h[0], aim.p) - (f.height + h25 * dot(f.h[4], f.p56)), dot(flat, aim.p), -dot(turn, aim.p)},
      {h12 * dot(f.h[0], aim.u) - h25 * dot(f.h[4], f.h[5]), dot(flat, aim.u), -dot(turn, aim.u)}};
  Lane five[2][3];
  for (int k = 0; k < 3; ++k) {
    five[0][k] = f.from_5[0] * a[0][k] + f.from_5[1] * a[1][k];
    five[1][k] = f.from_5[2] * a[0][k] + f.from_5[3] * a[1][k];
  }
  LaneConic conic;
  for (const auto& row : five) conic.add_square(row[0], row[1], row[2], 1);
  conic.one -= splat(1.0);
  const LaneLines lines = lines_of(conic, squared(f.least_sine));
  const LaneMask second = below(sign_of_first(), Lane{});
  s.q[0] =
      point_on(select(second, lines.normal[1], lines.normal[0]),
               select(second, lines.reach[1], lines.reach[0]), sign_of_second(), edge_of(f, s, 0), s.free[0]);
  const auto value = [&](const Lane(&row)[3]) __attribute__((always_inline)) {
    return row[0] + row[1] * s.q[0].c + row[2] * s.q[0].s;
  };
  s.q[4] = toward(value(five[1]), value(five[0]), 1e-9, s.offered[4], s.free[1]);
  const LaneVec u = turned(f.h[0], -s.q[0], aim.u), w = turned(f.h[0], -s.q[0], aim.w);
  const LaneAngle q234 = parallel_sum(f, s, u, w, 1);
  const LaneVec p46 = turned(f.h[4], s.q[4], f.p56) + f.p45;
  const LaneVec d = turned(f.h[0], -s.q[0], aim.p) - f.p12 - turned(f.h[1], q234, p46);
  parallel_parts(f, s, d - dot(f.h[1], d) * f.h[1], q234, sign_of_third());
}

template <class Family>
POLYARM_INLINE void all_branches_in(const SixAxisForm& f, Question& s) {
  Family::first(f, s, sign_of_first());
  Family::second(f, s, sign_of_second());
  Family::third(f, s, sign_of_third());
  if constexpr (Family::kAxes[5] == 5) flip(f, s, sign_of_third());
}

/// One function for each family: a single function for all takes minutes to compile.
template <class Family>
__attribute__((noinline)) void all_branches(const SixAxisForm& f, Question& s) {
  all_branches_in<Family>(f, s);
}

/// Calls `with` with the family if it is solved in steps, without a conic or a search; else returns false.
template <class With>
POLYARM_INLINE bool with_family(ArmFamily family, const With& with) {
  switch (family) {
    case ArmFamily::wrist_2_parallel_3:
      with(Wrist2Parallel3{});
      return true;
    case ArmFamily::wrist_1_parallel_2:
      with(Wrist1Parallel2{});
      return true;
    case ArmFamily::wrist_1_meets_2:
      with(Wrist1Meets2{});
      return true;
    case ArmFamily::wrist_2_meets_3:
      with(Wrist2Meets3{});
      return true;
    case ArmFamily::parallel_234_5_meets_6:
      with(Parallel234{});
      return true;
    case ArmFamily::parallel_123_5_meets_6:
      with(Parallel123{});
      return true;
    default:
      return false;
  }
}

/// Starts a question; `target` is in the arm's view.
POLYARM_INLINE void put(const SixAxisForm& f, const LaneTarget& target, Question& s) {
  s.target = f.from_tool ? inverse(target) : target;
  s.aim = aim_of(f, s.target);
  for (LaneMask& mask : s.free) mask = LaneMask{};
  for (LaneMask& mask : s.beyond) mask = LaneMask{};
}

/// The eight branches of one target side by side; `offered` must be set.
POLYARM_INLINE void solve_family(const SixAxisForm& f, const LaneTarget& target, Question& s) {
  put(f, target, s);
  const bool steps = with_family(
      f.family, [&](auto family) __attribute__((always_inline)) { all_branches<decltype(family)>(f, s); });
  if (steps) return;
  if (f.family == ArmFamily::wrist) return wrist_any(f, s);
  if (f.family == ArmFamily::parallel_234) return parallel_234_apart(f, s);
  for (LaneAngle& angle : s.q) angle = {splat(0.0), splat(1.0)};
}

}  // namespace POLYARM_LANES

#pragma GCC diagnostic pop
