#include "polyarm/controllers/speed_limiter.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::controllers {

namespace {
double stated(double value, double otherwise) noexcept {
  return std::isnan(value) ? otherwise : value;
}
}  // namespace

std::optional<std::string> check(const SpeedLimits& l) {
  if (l.max_velocity < 0 || l.max_acceleration < 0 || l.max_jerk < 0)
    return "max_velocity, max_acceleration and max_jerk are zero or positive";
  if (l.min_velocity > 0 || l.max_acceleration_reverse > 0 || l.min_jerk > 0)
    return "min_velocity, max_acceleration_reverse and min_jerk are zero or negative";
  if (l.max_deceleration >= 0) return "max_deceleration must be negative; with 0 nothing could ever stop";
  if (l.max_deceleration_reverse <= 0)
    return "max_deceleration_reverse must be positive; with 0 nothing could ever stop";
  return std::nullopt;
}

void SpeedLimiter::set(const SpeedLimits& l) noexcept {
  const bool velocity = !std::isnan(l.max_velocity);
  max_ = velocity ? l.max_velocity : kAny;
  min_ = velocity ? stated(l.min_velocity, -l.max_velocity) : -kAny;
  const bool acceleration = !std::isnan(l.max_acceleration);
  faster_forwards_ = acceleration ? l.max_acceleration : kAny;
  faster_backwards_ = acceleration ? stated(l.max_acceleration_reverse, -l.max_acceleration) : -kAny;
  slower_forwards_ = acceleration ? stated(l.max_deceleration, faster_backwards_) : -kAny;
  slower_backwards_ = acceleration ? stated(l.max_deceleration_reverse, -slower_forwards_) : kAny;
  const bool jerk = !std::isnan(l.max_jerk);
  max_jerk_ = jerk ? l.max_jerk : kAny;
  min_jerk_ = jerk ? stated(l.min_jerk, -l.max_jerk) : -kAny;
}

double SpeedLimiter::next(double wanted, double dt) noexcept {
  if (std::isnan(wanted) || !(dt > 0)) return last_;
  double change = wanted - last_;
  const double change_before = last_ - before_;
  if ((change - change_before) * change > 0)
    change = change_before + std::clamp(change - change_before, min_jerk_ * dt * dt, max_jerk_ * dt * dt);
  const double most = (last_ < 0 ? slower_backwards_ : faster_forwards_) * dt;
  const double least = (last_ > 0 ? slower_forwards_ : faster_backwards_) * dt;
  // What is wanted is met exactly, not to rounding.
  const double limited = std::clamp(change, least, most);
  const double speed = limited == wanted - last_ ? wanted : last_ + limited;
  before_ = last_;
  last_ = std::clamp(speed, min_, max_);
  return last_;
}

}  // namespace polyarm::controllers
