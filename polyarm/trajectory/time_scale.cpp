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

TimeScale::TimeScale(double ramp_s, double initial) noexcept
    : most_rate_{1.5 / std::max(kShortestRamp, ramp_s)},
      most_change_{2 * most_rate_ * most_rate_},
      value_{within_unit(initial)} {}

double TimeScale::advance(double dt, double target) noexcept {
  if (!(dt > 0)) return 0;
  target = within_unit(target);
  const double before = value_, step = most_change_ * dt;
  const double sign = target >= value_ ? 1.0 : -1.0;
  const double left = std::abs(target - value_), towards = sign * rate_;
  if (std::abs(towards) <= step && left <= step * dt) {
    value_ = target;
    rate_ = 0;
    return 0.5 * (before + value_) * dt;
  }
  // The rate r after this step from which braking still ends at the target: r²/(2c) + (rate + r) dt/2 = left.
  const double room = step * step / 4 + 2 * most_change_ * (left - towards * dt / 2);
  double next = room > 0 ? std::sqrt(room) - step / 2 : -most_rate_;
  next = std::clamp(next, towards - step, towards + step);
  next = std::clamp(next, -most_rate_, most_rate_);
  const double moved = before + sign * 0.5 * (towards + next) * dt;
  value_ = within_unit(moved);
  rate_ = value_ == moved ? sign * next : 0.0;
  return 0.5 * (before + value_) * dt;
}

}  // namespace polyarm::trajectory
