#include "drivers/wire/shaper.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::wire {

namespace {

constexpr double kShare = 0.95;      // of the limits, for commands that the shaper makes itself
constexpr double kSteady = 0.9;      // of the limits: a target that moves faster jumps
constexpr double kTolerance = 1e-6;  // of a limit, for rounding
constexpr double kStill = 1e-6;      // degrees/s

}  // namespace

template <std::size_t N>
void ShaperOf<N>::begin(const Axes& at) noexcept {
  at_ = wanted_ = at;
  velocity_ = acceleration_ = desired_velocity_ = {};
  behind_ = 0;
  axis_behind_ = 0;
  shaped_ = 0;
}

template <std::size_t N>
bool ShaperOf<N>::allows(std::size_t axis, double target, const Limits& limits) noexcept {
  const double velocity = (target - at_[axis]) / period_;
  const double acceleration = (velocity - velocity_[axis]) / period_;
  const double jerk = (acceleration - acceleration_[axis]) / period_;
  const auto within = [&](double value, LimitKind kind) {
    if (std::abs(value) <= limits.at(kind, axis) * (1 + kTolerance)) return true;
    exceeded_[axis] = kind;
    return false;
  };
  return within(velocity, LimitKind::velocity) && within(acceleration, LimitKind::acceleration) &&
         within(jerk, LimitKind::jerk);
}

/// One period along the fastest motion to a target that moves on as it did, seen from that target; then cut
/// so that no difference exceeds its limit.
template <std::size_t N>
double ShaperOf<N>::steer(std::size_t axis, const Moving& moving, const Limits& limits) noexcept {
  const double v = limits.at(LimitKind::velocity, axis), a = limits.at(LimitKind::acceleration, axis),
               j = limits.at(LimitKind::jerk, axis);
  const trajectory::MotionState start{at_[axis] - moving.position, velocity_[axis] - moving.velocity,
                                      acceleration_[axis] - moving.acceleration};
  const trajectory::MotionState target;
  const trajectory::MotionLimits bound{kShare * v - moving.velocity, kShare * a - moving.acceleration,
                                       kShare * j, -kShare * v - moving.velocity,
                                       -kShare * a - moving.acceleration};
  trajectory::MotionOptions options;
  options.target = moving.brake ? trajectory::TargetKind::velocity : trajectory::TargetKind::position;
  const auto status =
      planner_.plan(std::span(&start, 1), std::span(&target, 1), std::span(&bound, 1), options);
  double acceleration = 0;  // at the end of the period
  if (status == trajectory::MotionStatus::ok)
    acceleration = planner_.axis(0).at(period_).acceleration + moving.acceleration;
  acceleration =
      std::clamp(acceleration, acceleration_[axis] - j * period_, acceleration_[axis] + j * period_);
  acceleration = std::clamp(acceleration, -a, a);
  return at_[axis] + (velocity_[axis] + acceleration * period_) * period_;
}

/// How the target moves; one that jumps counts as at rest.
template <std::size_t N>
typename ShaperOf<N>::Moving ShaperOf<N>::motion_of(std::size_t axis, double wanted,
                                                    const Limits& limits) const noexcept {
  const double velocity = (wanted - wanted_[axis]) / period_;
  const double acceleration = (velocity - desired_velocity_[axis]) / period_;
  const double v = kSteady * limits.at(LimitKind::velocity, axis),
               a = kSteady * limits.at(LimitKind::acceleration, axis);
  if (std::abs(velocity) > v || std::abs(desired_velocity_[axis]) > v) return {wanted, 0, 0, false};
  return {wanted_[axis], desired_velocity_[axis], std::abs(acceleration) > a ? 0 : acceleration, false};
}

template <std::size_t N>
void ShaperOf<N>::advance(std::size_t axis, double position) noexcept {
  const double velocity = (position - at_[axis]) / period_;
  acceleration_[axis] = (velocity - velocity_[axis]) / period_;
  velocity_[axis] = velocity;
  at_[axis] = position;
}

template <std::size_t N>
std::array<double, N> ShaperOf<N>::next(const Axes& wanted, const Limits& limits) noexcept {
  behind_ = 0;
  bool all = true;
  for (std::size_t i = 0; i < N; ++i) {
    double target = wanted[i];
    if (!allows(i, target, limits)) {
      target = steer(i, motion_of(i, wanted[i], limits), limits);
      all = false;
    }
    advance(i, target);
    if (const double off = std::abs(wanted[i] - target); off > behind_) {
      behind_ = off;
      axis_behind_ = i;
    }
  }
  for (std::size_t i = 0; i < N; ++i) desired_velocity_[i] = (wanted[i] - wanted_[i]) / period_;
  wanted_ = wanted;
  if (!all) ++shaped_;
  return at_;
}

template <std::size_t N>
std::array<double, N> ShaperOf<N>::brake(const Limits& limits) noexcept {
  for (std::size_t i = 0; i < N; ++i) {
    double target = at_[i];  // at once, where that is within the limits
    if (!allows(i, target, limits)) target = steer(i, {at_[i], 0, 0, true}, limits);
    advance(i, target);
  }
  wanted_ = at_;
  desired_velocity_ = velocity_;
  behind_ = 0;
  return at_;
}

template <std::size_t N>
bool ShaperOf<N>::still() const noexcept {
  for (std::size_t i = 0; i < N; ++i)
    if (std::abs(velocity_[i]) > kStill || std::abs(acceleration_[i]) * period_ > kStill) return false;
  return true;
}

template class ShaperOf<6>;
template class ShaperOf<7>;

}  // namespace polyarm::wire
