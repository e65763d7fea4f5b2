#include "polyarm/trajectory/time_scale.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::trajectory {

namespace {
constexpr double kShortestRamp = 1e-9;  // s

double within_unit(double x) {
  return x > 0 ? std::min(x, 1.0) : 0.0;
}
}  // namespace

ScaleRates ScaleRates::of_ramp(double ramp_s) noexcept {
  const double rate = 1.5 / std::max(kShortestRamp, ramp_s);
  return {rate, rate, 2 * rate * rate};
}

void ScaleRates::narrow(double velocity, double acceleration, double s, const JointDynamics& joint) noexcept {
  const double speed = std::abs(velocity);
  if (!(speed > 0)) return;
  const double along = std::copysign(1.0, velocity) * acceleration * s * s;  // acceleration of the plan
                                                                             // itself
  up = std::clamp((joint.acceleration - along) / speed, 0.0, up);
  down = std::clamp((joint.deceleration + along) / speed, 0.0, down);
  change = std::min(change, joint.jerk / speed);
}

TimeScale::TimeScale(double ramp_s, double initial) noexcept
    : own_{ScaleRates::of_ramp(ramp_s)}, value_{within_unit(initial)} {}

void TimeScale::jump(double target) noexcept {
  value_ = within_unit(target);
  rate_ = 0;
}

double TimeScale::advance(double dt, double target, const ScaleRates& rates) noexcept {
  if (!(dt > 0)) return 0;
  target = within_unit(target);
  const double before = value_, step = rates.change * dt;
  const double sign = target >= value_ ? 1.0 : -1.0;
  const double most_towards = sign > 0 ? rates.up : rates.down, most_back = sign > 0 ? rates.down : rates.up;
  const double left = std::abs(target - value_), towards = sign * rate_;
  if (std::abs(towards) <= step && left <= step * dt && left <= most_towards * dt) {
    value_ = target;
    rate_ = 0;
    return 0.5 * (before + value_) * dt;
  }
  // The rate r after this step from which braking still ends at the target: r²/(2c) + (rate + r) dt/2 =
  // remaining.
  const double room = step * step / 4 + 2 * rates.change * (left - towards * dt / 2);
  double next = room > 0 ? std::sqrt(room) - step / 2 : -most_back;
  next = std::clamp(next, towards - step, towards + step);
  next = std::clamp(next, -most_back, most_towards);
  const double moved = before + sign * 0.5 * (towards + next) * dt;
  value_ = within_unit(moved);
  rate_ = value_ == moved ? sign * next : 0.0;
  return 0.5 * (before + value_) * dt;
}

}  // namespace polyarm::trajectory
