#include "drivers/franka/velocity.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::franka {

namespace {
using wire::LimitKind;
constexpr double kTolerance = 1e-6;  // of a limit, for rounding
constexpr double kShare = 0.95;      // of acceleration and jerk, for velocities that the shaper chooses
constexpr double kStill = 1e-6;      // rad/s
}  // namespace

/// One period along the fastest change to the wanted velocity, cut so that no difference exceeds its limit.
double VelocityShaper::approach(std::size_t axis, double wanted,
                                const wire::AxisLimitsOf<7>& limits) noexcept {
  const double v = limits.at(LimitKind::velocity, axis), a = limits.at(LimitKind::acceleration, axis),
               j = limits.at(LimitKind::jerk, axis);
  const trajectory::MotionState start{0, at_[axis], acceleration_[axis]};
  const trajectory::MotionState target{0, std::clamp(wanted, -v, v), 0};
  const auto bound = trajectory::MotionLimits::symmetric(v, kShare * a, kShare * j);
  trajectory::MotionOptions options;
  options.target = trajectory::TargetKind::velocity;
  const auto status =
      planner_.plan(std::span(&start, 1), std::span(&target, 1), std::span(&bound, 1), options);
  double acceleration = 0;
  if (status == trajectory::MotionStatus::ok)
    acceleration = (planner_.axis(0).at(period_).velocity - at_[axis]) / period_;
  acceleration =
      std::clamp(acceleration, acceleration_[axis] - j * period_, acceleration_[axis] + j * period_);
  return at_[axis] + std::clamp(acceleration, -a, a) * period_;
}

const Seven& VelocityShaper::next(const Seven& wanted, const wire::AxisLimitsOf<7>& limits) noexcept {
  bool all = true;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    double target = wanted[i];
    const double acceleration = (target - at_[i]) / period_,
                 jerk = (acceleration - acceleration_[i]) / period_;
    const auto within = [&](double value, LimitKind kind) {
      return std::abs(value) <= limits.at(kind, i) * (1 + kTolerance);
    };
    if (!within(target, LimitKind::velocity) || !within(acceleration, LimitKind::acceleration) ||
        !within(jerk, LimitKind::jerk)) {
      target = approach(i, wanted[i], limits);
      all = false;
    }
    acceleration_[i] = (target - at_[i]) / period_;
    at_[i] = target;
  }
  if (!all) ++shaped_;
  return at_;
}

bool VelocityShaper::still() const noexcept {
  for (std::size_t i = 0; i < at_.size(); ++i)
    if (std::abs(at_[i]) > kStill || std::abs(acceleration_[i]) * period_ > kStill) return false;
  return true;
}

}  // namespace polyarm::franka
