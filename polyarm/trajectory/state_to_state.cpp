#include "polyarm/trajectory/state_to_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/trajectory/axis_plan.hpp"
#include "polyarm/trajectory/constant_jerk.hpp"

namespace polyarm::trajectory {

const char* name(MotionStatus status) noexcept {
  switch (status) {
    case MotionStatus::ok:
      return "ok";
    case MotionStatus::wrong_size:
      return "wrong size";
    case MotionStatus::bad_number:
      return "a number is not finite";
    case MotionStatus::bad_limit:
      return "a limit is on the wrong side of zero";
    case MotionStatus::target_outside:
      return "the target's velocity and acceleration cannot be reached within the limits";
  }
  return "";
}

// --- motion of one axis

namespace {
MotionState passed(const MotionState& s, double t, double jerk) noexcept {
  const JerkState end = after({s.position, s.velocity, s.acceleration}, t, jerk);
  return {end.p, end.v, end.a};
}
}  // namespace

MotionState AxisMotion::at(double t) const noexcept {
  if (!(t < duration_)) {
    const double beyond = t - duration_;
    return {end_.position + end_.velocity * (beyond > 0 ? beyond : 0), end_.velocity,
            beyond > 0 ? 0 : end_.acceleration};
  }
  if (!(t > 0)) return pieces_[0].state;
  std::size_t i = count_ - 1;
  while (i > 0 && pieces_[i].begin > t) --i;
  return passed(pieces_[i].state, t - pieces_[i].begin, pieces_[i].jerk);
}

// --- the plan

MotionStatus StateToState::plan(std::span<const MotionState> start, std::span<const MotionState> target,
                                std::span<const MotionLimits> limits, const MotionOptions& options) noexcept {
  const std::size_t n = start.size();
  if (n == 0 || n > kMostAxes || target.size() != n || limits.size() != n) return MotionStatus::wrong_size;
  if (!std::isfinite(options.minimum_duration)) return MotionStatus::bad_number;
  alignas(AxisPlan) std::byte room[kMostAxes * sizeof(AxisPlan)];  // only what is used is touched
  AxisPlan* const axis = reinterpret_cast<AxisPlan*>(room);
  for (std::size_t i = 0; i < n; ++i) {
    new (&axis[i]) AxisPlan;
    const MotionStatus status = axis[i].prepare(start[i], target[i], limits[i], options.target);
    if (status != MotionStatus::ok) return status;
  }
  count_ = n;
  straight_ =
      options.synchronization == Synchronization::phase && plan_straight(start, target, limits, options);
  if (straight_) return MotionStatus::ok;

  const double least = std::max(0.0, options.minimum_duration);
  const bool together = options.synchronization != Synchronization::none;
  double common = least;
  for (bool moved = together; moved;) {
    moved = false;
    for (std::size_t i = 0; i < n; ++i) {
      const double t = axis[i].arrival(common);
      moved |= t > common;
      common = t;
    }
  }
  duration_ = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = together ? common : axis[i].arrival(least);
    axis[i].build(t, motions_[i]);
    duration_ = std::max(duration_, t);
  }
  return MotionStatus::ok;
}

/// If all differences of the states are multiples of one direction, the motion is that of one axis, with the
/// limits of the most restrictive axis.
bool StateToState::plan_straight(std::span<const MotionState> start, std::span<const MotionState> target,
                                 std::span<const MotionLimits> limits,
                                 const MotionOptions& options) noexcept {
  if (options.target != TargetKind::position) return false;
  const std::size_t n = start.size();
  const auto distance = [&](std::size_t i) { return target[i].position - start[i].position; };
  std::size_t lead = 0;
  for (std::size_t i = 1; i < n; ++i)
    if (std::abs(distance(i)) > std::abs(distance(lead))) lead = i;
  if (distance(lead) == 0) return false;
  MotionLimits l = limits[lead];
  std::array<double, kMostAxes> share;
  for (std::size_t i = 0; i < n; ++i) {
    share[i] = distance(i) / distance(lead);
    const auto proportional = [&](double own, double leads) {
      return std::abs(own - share[i] * leads) <= 1e-9 * (std::abs(own) + std::abs(leads));
    };
    if (!proportional(start[i].velocity, start[lead].velocity) ||
        !proportional(start[i].acceleration, start[lead].acceleration) ||
        !proportional(target[i].velocity, target[lead].velocity) ||
        !proportional(target[i].acceleration, target[lead].acceleration))
      return false;
    if (share[i] == 0) continue;
    const bool along = share[i] > 0;
    const MotionLimits& own = limits[i];
    l.max_velocity = std::min(l.max_velocity, (along ? own.max_velocity : own.min_velocity) / share[i]);
    l.min_velocity = std::max(l.min_velocity, (along ? own.min_velocity : own.max_velocity) / share[i]);
    l.max_acceleration =
        std::min(l.max_acceleration, (along ? own.max_acceleration : own.min_acceleration) / share[i]);
    l.min_acceleration =
        std::max(l.min_acceleration, (along ? own.min_acceleration : own.max_acceleration) / share[i]);
    l.max_jerk = std::min(l.max_jerk, own.max_jerk / std::abs(share[i]));
  }
  AxisPlan one;
  if (one.prepare(start[lead], target[lead], l, options.target) != MotionStatus::ok || one.brakes())
    return false;
  duration_ = one.arrival(std::max(0.0, options.minimum_duration));
  one.build(duration_, motions_[lead]);
  const AxisMotion& model = motions_[lead];
  for (std::size_t i = 0; i < n; ++i) {
    if (i == lead) continue;
    AxisMotion& motion = motions_[i];
    motion.start(start[i]);
    for (std::size_t k = 0; k < model.count_; ++k)
      motion.append((k + 1 < model.count_ ? model.pieces_[k + 1].begin : duration_) - model.pieces_[k].begin,
                    share[i] * model.pieces_[k].jerk);
    motion.finish(target[i], duration_);
  }
  return true;
}

void StateToState::sample(double t, std::span<MotionState> out) const noexcept {
  for (std::size_t i = 0; i < count_ && i < out.size(); ++i) out[i] = motions_[i].at(t);
}

}  // namespace polyarm::trajectory
