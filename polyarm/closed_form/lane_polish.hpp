#pragma once
/// The true arm in lanes: the error of eight joint states against a pose, and descent from all of them.
/// Private to this room. Errors in m and rad.
#include <algorithm>

#include "polyarm/closed_form/closed_form.hpp"
#include "polyarm/simd/lanes.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace POLYARM_LANES {

inline constexpr double kGoodEnough = 1e-11;  // m and rad: smaller errors are not polished
inline constexpr double kLargestTurn = 0.3;   // rad in one step of the polish
/// If the second step is longer than this part of the first, the path bends as much as it is long, and the
/// result may be one of several. Second steps shorter than kLeastBend (rad) are rounding.
inline constexpr double kMostOfTheStepBefore = 0.1, kLeastBend = 1e-7;
/// Errors on the true arm, in units of BranchJob::ideal. Up to these values the error is that of: an ideal
/// arm's answer; a pose just beyond its reach; a pose not far beyond its reach. kNearlyThere: a descent that
/// ends this close may be near a solution.
inline constexpr double kAnswer = 30, kNearAnswer = 300, kAroundAnswer = 3000, kNearlyThere = 100;

inline constexpr std::size_t kMost = ArmGeometry::kMostAxes;

constexpr double squared(double a) {
  return a * a;
}

POLYARM_INLINE void turn_pair(const LaneAngle& a, Lane& u, Lane& v) {
  const Lane was = u;
  u = fnma(a.s, v, a.c * was);
  v = fma(a.s, was, a.c * v);
}

/// Two of the tool's axes and its origin, by the faster form (LaneArm::square).
POLYARM_INLINE void place_square(const LaneArm& arm, const LaneAngle* q, LaneVec& x, LaneVec& y, LaneVec& p) {
  x = splat(arm.tool_x), y = splat(arm.tool_y), p = splat(arm.tool_step);
  for (std::size_t i = arm.count; i-- > 0;) {
    const SquareStep& step = arm.along[i];
    LaneAngle a = q[i];
    if (step.against) a.s = -a.s;
    if (step.about == 0)
      turn_pair(a, x.y, x.z), turn_pair(a, y.y, y.z), turn_pair(a, p.y, p.z);
    else if (step.about == 1)
      turn_pair(a, x.z, x.x), turn_pair(a, y.z, y.x), turn_pair(a, p.z, p.x);
    else
      turn_pair(a, x.x, x.y), turn_pair(a, y.x, y.y), turn_pair(a, p.x, p.y);
    if (step.aside) p = p + step.step;
  }
  if (arm.level) return;
  x = arm.frame * x, y = arm.frame * y, p = arm.frame * p;
}

/// Squared errors between the target and the pose at these angles. Goes from the tool to the base with three
/// vectors: two of the tool's axes and its origin.
template <class Target>
POLYARM_INLINE void measure(const LaneArm& arm, const LaneAngle* q, const Target& target, Lane& position,
                            Lane& orientation) {
  const std::size_t n = arm.square ? 0 : arm.count;
  LaneVec x, y, p;
  if (arm.square)
    place_square(arm, q, x, y, p);
  else
    x = splat(arm.turn[n].x), y = splat(arm.turn[n].y), p = splat(arm.step[n]);
  for (std::size_t i = n; i-- > 0;) {
    const LaneAngle a = q[i];
    if (arm.slides[i]) {
      x = arm.turn[i] * x;
      y = arm.turn[i] * y;
      p = arm.turn[i] * LaneVec{p.x, p.y, p.z + a.s} + arm.step[i];
      continue;
    }
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
/// all branches. `moves`: the axes that may move. Returns the step of axis `watched`; `largest`: the largest
/// step of any axis before steps are clipped.
POLYARM_INLINE Lane descend(const LaneArm& arm, const bool* moves, const PoseTarget& target, LaneAngle* q,
                            std::size_t watched = 0, Lane* largest = nullptr) {
  const std::size_t n = arm.count;
  LaneVec axis[kMost], origin[kMost];
  LaneFrame frame{splat(arm.turn[0].x), splat(arm.turn[0].y), splat(arm.turn[0].z), splat(arm.step[0])};
  for (std::size_t i = 0; i < n; ++i) {
    axis[i] = frame.z;
    origin[i] = frame.p;
    if (arm.slides[i]) {
      frame.p = frame.p + q[i].s * frame.z;
      advance(frame, arm.turn[i + 1], arm.step[i + 1]);
      continue;
    }
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
    const bool slides = arm.slides[k];
    const LaneVec linear = slides ? axis[k] : cross(axis[k], frame.p - origin[k]);
    const LaneVec angular = slides ? LaneVec{} : axis[k];
    const Lane c[6] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    for (int i = 0; i < 6; ++i) {
      column[k][i] = c[i];
      for (int j = 0; j <= i; ++j) a[i][j] += c[i] * c[j];
    }
  }
  solve_definite(a, b);
  Lane moved{}, step[kMost], most{};
  for (std::size_t k = 0; k < n; ++k) {
    if (!moves[k]) continue;
    Lane d{};
    for (int i = 0; i < 6; ++i) d += column[k][i] * b[i];
    if (k == watched) moved = d;
    step[k] = d;
    if (!arm.slides[k]) most = most_of(most, magnitude(d));
  }
  if (largest) *largest = most;
  const Lane part = select(below(splat(kLargestTurn), most), kLargestTurn * inverse(most), splat(1.0));
  for (std::size_t k = 0; k < n; ++k) {
    if (!moves[k]) continue;
    const Lane d = part * step[k];
    if (arm.slides[k]) {
      q[k].s += d;
      continue;
    }
    const Lane d2 = d * d;
    const LaneAngle by{d * (1.0 - d2 * (1.0 / 6) * (1.0 - d2 * (1.0 / 20))),
                       1.0 - d2 * 0.5 * (1.0 - d2 * (1.0 / 12))};
    LaneAngle next = q[k] + by;
    const Lane unit = 1.5 - 0.5 * (next.s * next.s + next.c * next.c);
    q[k] = {next.s * unit, next.c * unit};
  }
  return moved;
}

#ifndef POLYARM_WIDTH
POLYARM_INLINE std::uint32_t bits_of(LaneMask mask) {
  std::uint32_t out = 0;
  for (std::size_t i = 0; i < kLanes; ++i) out |= mask[i] ? 1u << i : 0u;
  return out;
}

POLYARM_INLINE void store(Lane value, double* to) {
  for (std::size_t i = 0; i < kLanes; ++i) to[i] = value[i];
}
POLYARM_INLINE Lane load(const double* from) {
  Lane out;
  for (std::size_t i = 0; i < kLanes; ++i) out[i] = from[i];
  return out;
}
#endif

/// True if a branch is not exact but near enough to become so.
POLYARM_INLINE bool worth_more(Lane position, Lane orientation, double good_enough, double worth) {
  const Lane worst = most_of(position, orientation);
  return bits_of(below(splat(good_enough * good_enough), worst) & below(worst, splat(worth * worth))) != 0;
}

/// An arm of five axes or fewer reaches few poses: some branches of the six axes end close by and stay there.
struct Staying {
  LaneMask stays{};
  Lane last{};

  /// True if all branches that are worth more steps have stalled. Called after each step.
  POLYARM_INLINE bool over(const BranchJob& job, int step, Lane position, Lane orientation, double worth) {
    constexpr int kFirstSteps = 3;
    constexpr double kLess = 0.9;    // of the squared error in one step: above this the branch has stalled
    constexpr double kClose = 1e-4;  // m and rad: a descent from farther off may be slow at first
    if (job.arm->count > 5 || step < kFirstSteps) return false;
    const Lane left = most_of(position, orientation);
    if (step > kFirstSteps) stays |= ~below(left, kLess * last) & below(left, splat(kClose * kClose));
    last = left;
    const Lane moving = select(stays, splat(0.0), left);
    return !worth_more(moving, moving, job.good_enough, worth);
  }
};

/// The next greater integer; for |a| < 2^51.
POLYARM_INLINE Lane whole_above(Lane a) {
  const Lane near = rounded(a);
  return near + select(below(near, a), splat(1.0), Lane{});
}

/// Moves one joint's values to the turn within limits nearest to `near`; returns the lanes that have one.
POLYARM_INLINE LaneMask bring_near(Lane& value, double near, double lower, double upper, bool slides) {
  constexpr double kTurn = 6.283185307179586477, kAtLimit = 1e-10;  // rad or m beyond a limit: rounding
  const Lane low = splat(lower - kAtLimit), high = splat(upper + kAtLimit);
  if (!slides) {
    // Half a turn is equally near on either side; rounding must not decide.
    value += kTurn * rounded((near - value) * (1 / kTurn) - 1e-9);
    const Lane up = value + kTurn * whole_above((lower - value) * (1 / kTurn) - 1e-11);
    value = select(below(value, low), up, value);
    const Lane down = value - kTurn * whole_above((value - upper) * (1 / kTurn) - 1e-11);
    value = select(below(high, value), down, value);
  }
  const LaneMask outside = below(value, low) | below(high, value);
  const Lane raised = select(below(value, splat(lower)), splat(lower), value);
  value = select(outside, value, select(below(splat(upper), raised), splat(upper), raised));
  return ~outside;
}

/// Writes joint values from angles.
POLYARM_INLINE void write_values(const BranchJob& job, const LaneAngle* q, Branches& out) {
  const LaneArm& arm = *job.arm;
  Lane distance2{};
  LaneMask inside = ~LaneMask{};
  for (std::size_t i = 0; i < arm.count; ++i) {
    Lane value = arm.slides[i] ? q[i].s : angle_of(q[i].s, q[i].c);
    if (job.limits) {
      inside &= bring_near(value, job.near[i], job.limits->lower[i], job.limits->upper[i], arm.slides[i]);
      const Lane away = value - job.near[i];
      distance2 += job.limits->weight[i] * away * away;
    }
    store(value, out.value[i]);
  }
  store(distance2, out.distance2);
  out.inside = bits_of(inside);
}
/// One joint value as the angle that the sweeps take.
POLYARM_INLINE LaneAngle angle_at(const LaneArm& arm, std::size_t axis, double value) {
  if (arm.slides[axis]) return {splat(value), splat(1.0)};
  return {splat(__builtin_sin(value)), splat(__builtin_cos(value))};
}

/// The lanes with an angle far from where it began.
POLYARM_INLINE LaneMask far_from(const LaneArm& arm, const LaneAngle* begin, const LaneAngle* q) {
  constexpr double kCosineOfFar = 0.995;  // 0.1 rad
  LaneMask out{};
  for (std::size_t i = 0; i < arm.count; ++i)
    if (!arm.slides[i]) out |= below(begin[i].s * q[i].s + begin[i].c * q[i].c, splat(kCosineOfFar));
  return out;
}

/// Rates a start for a slightly non-ideal arm: an answer of the ideal arm, or its nearest state to a pose
/// beyond its reach.
struct Beginning {
  LaneMask answer{}, near{}, around{};
  LaneAngle q[kMost];
};
POLYARM_INLINE Beginning beginning_of(const BranchJob& job, const LaneAngle* q, Lane error2) {
  Beginning out;
  const auto within = [&](double times) { return below(error2, splat(squared(times * job.ideal))); };
  out.answer = within(kAnswer);
  out.near = within(kNearAnswer) & ~out.answer;
  out.around = within(kAroundAnswer) & ~out.answer;
  std::copy(q, q + job.arm->count, out.q);
  return out;
}

/// Bit mask of strayed branches: the descent from the ideal arm's answer went far, bent or did not converge;
/// or there is almost a solution where the ideal arm has none.
POLYARM_INLINE std::uint32_t strayed(const BranchJob& job, const Beginning& begin, const LaneAngle* q,
                                     const Lane* largest, Lane error2) {
  const LaneMask unfinished = below(splat(1e-18), error2);
  const LaneMask bent = below(most_of(kMostOfTheStepBefore * largest[0], splat(kLeastBend)), largest[1]);
  const LaneMask found = below(error2, splat(squared(kNearlyThere * job.ideal)));
  return bits_of((begin.answer & (unfinished | bent | far_from(*job.arm, begin.q, q))) | begin.near |
                 (begin.around & found));
}

POLYARM_INLINE void check_and_polish(const BranchJob& job, LaneAngle* q, const bool* moves, Branches& out) {
  Lane position, orientation;
  Staying staying;
  double worth = job.worth_polishing;
  Beginning begin;
  Lane largest[3]{};
  for (int i = 0;; ++i) {
    measure(*job.arm, q, job.target, position, orientation);
    if (i == 0 && job.ideal > 0) begin = beginning_of(job, q, most_of(position, orientation));
    store(position, out.position_error2);
    store(orientation, out.orientation_error2);
    if (i >= job.patience) worth = std::min(worth, 1e-4);
    if (staying.over(job, i, position, orientation, worth)) break;
    if (i == job.most_steps || !worth_more(position, orientation, job.good_enough, worth)) break;
    descend(*job.arm, moves, job.target, q, 0, &largest[std::min(i, 2)]);
  }
  out.strayed = 0;
  if (bits_of(begin.around | begin.answer) != 0)
    out.strayed = strayed(job, begin, q, largest, most_of(position, orientation));
}

}  // namespace POLYARM_LANES

#pragma GCC diagnostic pop
