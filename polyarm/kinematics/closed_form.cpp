#include "polyarm/kinematics/closed_form.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/kinematics/subproblems.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {

namespace {

constexpr double kGoodEnough = 1e-11;  // m and rad: better than this is not polished
constexpr int kMostPolish = 30;
constexpr double kLargestTurn = 0.3;  // rad in one step of the polish

Vec3 beside(const Vec3& h) {
  const double x = std::abs(h.x), y = std::abs(h.y), z = std::abs(h.z);
  const Vec3 least = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  return normalized(cross(h, least));
}

/// A frame whose z is the axis.
Rotation frame_of(const Vec3& h) {
  const Vec3 x = beside(h);
  return {x, cross(h, x), h};
}

constexpr double squared(double a) {
  return a * a;
}

// ---- the families -------------------------------------------------------------------------------------

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

POLYARM_INLINE void parallel_234(const SixAxisForm& f, const Edge& edge, const PoseTarget& target,
                                 const LaneAngle* offered, SixAngles& out) {
  const Aim aim = aim_of(f, target);
  out.q[0] = subproblem_4(splat(f.h[1]), splat(aim.p), -f.h[0], splat(f.height), sign_of_first(), edge,
                          f.least_length, offered[0], out.free);
  const LaneVec u = turned(f.h[0], -out.q[0], splat(aim.r * f.h[5]));
  const LaneVec w = turned(f.h[0], -out.q[0], splat(aim.r * f.beside_6));
  out.q[4] = wrist_bend(f.h[1], f.h[4], f.h[5], u, sign_of_third(), edge, out.free);
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
  const LaneVec d = turned(f.h[0], -out.q[0], splat(aim.p)) - f.p12 - turned(f.h[1], q234, splat(f.p45));
  const LaneVec flat = d - dot(f.h[1], d) * f.h[1];
  const double least2 = f.least_length * norm(f.p23);
  out.q[2] = subproblem_3(splat(f.p34), splat(-f.p23), f.h[2], dot(flat, flat), sign_of_second(), edge,
                          least2, offered[2], out.free);
  const LaneVec upper = turned(f.h[2], out.q[2], splat(f.p34)) + f.p23;
  out.q[1] = subproblem_1(upper, flat, f.h[1], squared(f.least_length), offered[1], out.free);
  const LaneAngle q23 = out.q[1] + times(f.side_3, out.q[2]);
  out.q[3] = times(f.side_4, q234 + -q23);
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
    case ArmFamily::parallel_123_5_meets_6:
      return parallel_123(f, edge, target, offered, out);
    default:
      for (LaneAngle& angle : out.q) angle = {splat(0.0), splat(1.0)};
  }
}

// ---- the true arm -------------------------------------------------------------------------------------

constexpr std::size_t kMost = ArmGeometry::kMostAxes;

/// Squares of what is between the target and where these angles lead. Goes from the tool to the base with
/// three vectors: two of the tool's axes and its origin.
POLYARM_INLINE void measure(const LaneArm& arm, const LaneAngle* q, const PoseTarget& target, Lane& position,
                            Lane& orientation) {
  const std::size_t n = arm.count;
  LaneVec x = splat(arm.turn[n].x), y = splat(arm.turn[n].y), p = splat(arm.step[n]);
  for (std::size_t i = n; i-- > 0;) {
    const LaneAngle a = q[i];
    const auto placed = [&](const LaneVec& v) __attribute__((always_inline)) {
      return arm.turn[i] * LaneVec{a.c * v.x - a.s * v.y, a.s * v.x + a.c * v.y, v.z};
    };
    x = placed(x);
    y = placed(y);
    p = placed(p) + arm.step[i];
  }
  const LaneVec dx = x - target.rotation.x, dy = y - target.rotation.y, dp = p - target.position;
  position = dot(dp, dp);
  orientation = dot(dx, dx) + dot(dy, dy);
}

struct LaneFrame {
  LaneVec x, y, z, p;
};
POLYARM_INLINE void advance(LaneFrame& frame, const Rotation& turn, const Vec3& step) {
  const auto along = [&](const Vec3& v) __attribute__((always_inline)) {
    return LaneVec{v.x * frame.x.x + v.y * frame.y.x + v.z * frame.z.x,
                   v.x * frame.x.y + v.y * frame.y.y + v.z * frame.z.y,
                   v.x * frame.x.z + v.y * frame.y.z + v.z * frame.z.z};
  };
  frame = {along(turn.x), along(turn.y), along(turn.z), frame.p + along(step)};
}

/// Solves a x = b for a symmetric positive definite matrix, lower half given (L D L^T); overwrites both.
POLYARM_INLINE void solve_definite(Lane (&a)[6][6], Lane (&b)[6]) {
  for (int j = 0; j < 6; ++j) {
    const Lane inverse = 1.0 / a[j][j];
    for (int i = j + 1; i < 6; ++i) {
      const Lane factor = a[i][j] * inverse;
      for (int k = i; k < 6; ++k) a[k][i] -= factor * a[k][j];
      b[i] -= factor * b[j];
      a[i][j] = factor;
    }
    a[j][j] = inverse;
  }
  for (int i = 5; i >= 0; --i) {
    b[i] *= a[i][i];
    for (int k = i + 1; k < 6; ++k) b[i] -= a[k][i] * b[k];
  }
}

/// One step of damped least squares (damping proportional to the squared error: Chan and Lawrence 1988) of
/// all branches. `moves`: which axes may.
POLYARM_INLINE void descend(const LaneArm& arm, const bool* moves, const PoseTarget& target, LaneAngle* q) {
  const std::size_t n = arm.count;
  LaneVec axis[kMost], origin[kMost];
  LaneFrame frame{splat(arm.turn[0].x), splat(arm.turn[0].y), splat(arm.turn[0].z), splat(arm.step[0])};
  for (std::size_t i = 0; i < n; ++i) {
    axis[i] = frame.z;
    origin[i] = frame.p;
    const LaneVec x = q[i].c * frame.x + q[i].s * frame.y;
    frame.y = q[i].c * frame.y - q[i].s * frame.x;
    frame.x = x;
    advance(frame, arm.turn[i + 1], arm.step[i + 1]);
  }
  const LaneVec dp = splat(target.position) - frame.p;
  const LaneVec twice = cross(frame.x, splat(target.rotation.x)) + cross(frame.y, splat(target.rotation.y)) +
                        cross(frame.z, splat(target.rotation.z));
  const LaneVec dr = splat(0.5) * twice;
  Lane b[6] = {dp.x, dp.y, dp.z, dr.x, dr.y, dr.z};
  const Lane damping = 0.02 * (dot(dp, dp) + dot(dr, dr)) + 1e-15;
  Lane a[6][6];
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) a[i][j] = i == j ? damping : Lane{};
  Lane column[kMost][6];
  for (std::size_t k = 0; k < n; ++k) {
    if (!moves[k]) continue;
    const LaneVec linear = cross(axis[k], frame.p - origin[k]);
    const Lane c[6] = {linear.x, linear.y, linear.z, axis[k].x, axis[k].y, axis[k].z};
    for (int i = 0; i < 6; ++i) {
      column[k][i] = c[i];
      for (int j = 0; j <= i; ++j) a[i][j] += c[i] * c[j];
    }
  }
  solve_definite(a, b);
  for (std::size_t k = 0; k < n; ++k) {
    if (!moves[k]) continue;
    Lane d{};
    for (int i = 0; i < 6; ++i) d += column[k][i] * b[i];
    d = select(below(splat(kLargestTurn), d), splat(kLargestTurn), d);
    d = select(below(d, splat(-kLargestTurn)), splat(-kLargestTurn), d);
    const Lane d2 = d * d;
    const LaneAngle by{d * (1.0 - d2 * (1.0 / 6) * (1.0 - d2 * (1.0 / 20))),
                       1.0 - d2 * 0.5 * (1.0 - d2 * (1.0 / 12))};
    LaneAngle next = q[k] + by;
    const Lane unit = 1.5 - 0.5 * (next.s * next.s + next.c * next.c);
    q[k] = {next.s * unit, next.c * unit};
  }
}

POLYARM_INLINE std::uint32_t bits_of(LaneMask mask) {
  std::uint32_t out = 0;
  for (std::size_t i = 0; i < kLanes; ++i) out |= mask[i] ? 1u << i : 0u;
  return out;
}

/// Whether a branch is not exact, but near enough to become so.
POLYARM_INLINE bool worth_more(const Branches& out, double worth) {
  constexpr double kGood2 = kGoodEnough * kGoodEnough;
  bool more = false;
  for (std::size_t i = 0; i < kBranches; ++i) {
    const double worst = std::max(out.position_error2[i], out.orientation_error2[i]);
    more |= worst > kGood2 && worst < worth * worth;
  }
  return more;
}

POLYARM_INLINE void store(Lane value, double* to) {
  for (std::size_t i = 0; i < kLanes; ++i) to[i] = value[i];
}
POLYARM_INLINE Lane load(const double* from) {
  Lane out;
  for (std::size_t i = 0; i < kLanes; ++i) out[i] = from[i];
  return out;
}

POLYARM_INLINE void check_and_polish(const BranchJob& job, LaneAngle* q, const bool* moves, Branches& out) {
  Lane position, orientation;
  double worth = job.worth_polishing;
  for (int i = 0;; ++i) {
    measure(*job.arm, q, job.target, position, orientation);
    store(position, out.position_error2);
    store(orientation, out.orientation_error2);
    if (i >= job.patience) worth = std::min(worth, 1e-4);
    if (i == kMostPolish || !worth_more(out, worth)) break;
    descend(*job.arm, moves, job.target, q);
  }
}

POLYARM_INLINE void solve(const BranchJob& job, Branches& out) {
  const SixAxisForm& form = *job.form;
  PoseTarget target = job.target;
  if (form.from_tool) {
    target.rotation = transposed(target.rotation);
    target.position = -(target.rotation * target.position);
  }
  LaneAngle q[kMost];
  bool moves[kMost]{};
  LaneAngle offered[6];
  SixAngles six;
  for (LaneAngle& angle : offered) angle = {splat(0.0), splat(1.0)};
  solve_family(form, target, offered, six);
  out.free = bits_of(six.free);
  if (out.free != 0 && job.seed) {
    for (std::size_t k = 0; k < 6; ++k) {
      const double at = job.to_arm[k] < 0 ? 0.0 : job.seed[job.to_arm[k]] + job.beside_seed;
      offered[k] = {splat(__builtin_sin(at)), splat(__builtin_cos(at))};
    }
    solve_family(form, target, offered, six);
  }
  if (job.arm->count > 6)
    for (std::size_t i = 0; i < job.arm->count; ++i)
      q[i] = {splat(__builtin_sin(job.seed[i])), splat(__builtin_cos(job.seed[i]))};
  for (std::size_t k = 0; k < 6; ++k) {
    if (job.to_arm[k] < 0) continue;
    q[job.to_arm[k]] = six.q[k];
    moves[job.to_arm[k]] = true;
  }
  check_and_polish(job, q, moves, out);
  for (std::size_t i = 0; i < job.arm->count; ++i) store(angle_of(q[i].s, q[i].c), out.value[i]);
}

POLYARM_INLINE void polish(const BranchJob& job, Branches& out) {
  LaneAngle q[kMost];
  bool moves[kMost]{};
  for (const int axis : job.to_arm)
    if (axis >= 0) moves[axis] = true;
  for (std::size_t i = 0; i < job.arm->count; ++i) {
    Lane s, c;
    for (std::size_t k = 0; k < kLanes; ++k) {
      s[k] = __builtin_sin(out.value[i][k]);
      c[k] = __builtin_cos(out.value[i][k]);
    }
    q[i] = {s, c};
  }
  check_and_polish(job, q, moves, out);
  for (std::size_t i = 0; i < job.arm->count; ++i) store(angle_of(q[i].s, q[i].c), out.value[i]);
}

// ---- one for each kind of processor ---------------------------------------------------------------------

using Kernel = void (*)(const BranchJob&, Branches&);
struct Kernels {
  Kernel solve, polish;
};

void solve_anywhere(const BranchJob& job, Branches& out) {
  solve(job, out);
}
void polish_anywhere(const BranchJob& job, Branches& out) {
  polish(job, out);
}
#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void solve_avx2(const BranchJob& job, Branches& out) {
  solve(job, out);
}
__attribute__((target("avx2,fma"))) void polish_avx2(const BranchJob& job, Branches& out) {
  polish(job, out);
}
__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))) void solve_avx512(const BranchJob& job,
                                                                                Branches& out) {
  solve(job, out);
}
__attribute__((target("avx512f,avx512dq,avx512vl,avx2,fma"))) void polish_avx512(const BranchJob& job,
                                                                                 Branches& out) {
  polish(job, out);
}
#endif

Kernels kernels_here() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return {solve_avx512, polish_avx512};
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return {solve_avx2, polish_avx2};
#endif
  return {solve_anywhere, polish_anywhere};
}

const Kernels kKernels = kernels_here();

}  // namespace

SixAxisForm form_of(const SixAxisClass& known, bool wary) {
  SixAxisForm f;
  const ArmGeometry& arm = known.ideal;
  const auto point = [&](std::size_t k) { return arm.axes[k - 1].point; };
  f.family = known.family;
  f.from_tool = known.from_tool;
  for (std::size_t k = 0; k < 6; ++k) f.h[k] = arm.axes[k].direction;
  f.first = point(1);
  f.p12 = point(2) - point(1);
  f.p23 = point(3) - point(2);
  f.p34 = point(4) - point(3);
  f.p45 = point(5) - point(4);
  const Vec3 center = point(6);
  f.center_in_tool = transposed(arm.tool_rotation) * (center - arm.tool_position);
  f.from_tool_rotation = transposed(arm.tool_rotation);
  f.beside_6 = beside(f.h[5]);
  f.beside_1 = beside(f.h[0]);
  const double deviation = std::max(known.worst_gap / arm.size(), known.worst_angle);
  f.least_sine = wary ? 1e-7 + 30 * deviation : 1e-10;
  f.least_length = f.least_sine * arm.size();
  f.edge = known.exact() ? 0.0 : std::min(0.1, 1e-6 + (wary ? 100 : 4) * deviation);
  f.wary = wary && !known.exact();
  const auto flattened = [](const Vec3& v, const Vec3& h) { return v - dot(h, v) * h; };
  const auto side = [&](std::size_t a, std::size_t b) {
    return dot(f.h[a - 1], f.h[b - 1]) < 0 ? -1.0 : 1.0;
  };
  switch (f.family) {
    case ArmFamily::wrist_2_parallel_3:
      f.height = dot(f.h[1], center - f.first);
      f.side_3 = side(2, 3);
      f.p23 = flattened(f.p23, f.h[1]);
      f.p34 = flattened(f.p34, f.h[1]);
      break;
    case ArmFamily::wrist_1_parallel_2:
      f.height = dot(f.h[0], f.p12 + f.p23);
      break;
    case ArmFamily::parallel_234_5_meets_6:
      f.height = dot(f.h[1], center - f.first);
      f.side_3 = side(2, 3);
      f.side_4 = side(2, 4);
      f.p23 = flattened(f.p23, f.h[1]);
      f.p34 = flattened(f.p34, f.h[1]);
      break;
    case ArmFamily::parallel_123_5_meets_6:
      f.height = dot(f.h[0], f.p12 + f.p23 + f.p34);
      f.side_3 = side(1, 2);
      f.side_4 = side(1, 3);
      break;
    default:
      break;
  }
  return f;
}

LaneArm lane_arm(const ArmGeometry& arm) {
  LaneArm out;
  out.count = arm.count;
  out.size = arm.size();
  Rotation frame;
  Vec3 at;
  for (std::size_t i = 0; i <= arm.count; ++i) {
    const Rotation next = i < arm.count ? frame_of(arm.axes[i].direction) : arm.tool_rotation;
    const Vec3 point = i < arm.count ? arm.axes[i].point : arm.tool_position;
    out.turn[i] = transposed(frame) * next;
    out.step[i] = transposed(frame) * (point - at);
    frame = next;
    at = point;
  }
  return out;
}

void solve_branches(const BranchJob& job, Branches& out) noexcept {
  kKernels.solve(job, out);
}

void solve_branches_portably(const BranchJob& job, Branches& out) noexcept {
  solve_anywhere(job, out);
}

void polish_branches(const BranchJob& job, Branches& out) noexcept {
  kKernels.polish(job, out);
}

}  // namespace polyarm::kinematics
