#include "polyarm/trajectory/time_scale.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::trajectory {

double TimeScale::advance(double dt, double target) noexcept {
  target = std::clamp(target, 0.0, 1.0);
  if (target != to_ || (!ramping_ && value_ != target)) {
    from_ = value_;
    to_ = target;
    elapsed_ = 0;
    length_ = ramp_ * std::abs(to_ - from_);
    ramping_ = length_ > 0;
  }
  const double before = value_;
  if (ramping_) {
    elapsed_ += dt;
    const double u = std::min(1.0, elapsed_ / length_);
    value_ = from_ + (to_ - from_) * u * u * (3 - 2 * u);
    if (u >= 1) {
      value_ = to_;
      ramping_ = false;
    }
  }
  return 0.5 * (before + value_) * dt;
}

}  // namespace polyarm::trajectory
