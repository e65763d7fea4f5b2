#pragma once
/// Keeps a stream of joint velocities within acceleration and jerk. rad and seconds. One thread; nothing
/// allocates.
#include "drivers/wire/shaper.hpp"

namespace polyarm::franka {

using wire::Seven;

/// A velocity within the limits is passed on unchanged; another one is approached as fast as they allow.
class VelocityShaper {
 public:
  explicit VelocityShaper(double period = 0.001) noexcept : period_(period) {}
  void begin() noexcept {
    at_ = acceleration_ = {};
    shaped_ = 0;
  }
  const Seven& next(const Seven& wanted, const wire::AxisLimitsOf<7>& limits) noexcept;
  const Seven& brake(const wire::AxisLimitsOf<7>& limits) noexcept { return next({}, limits); }
  const Seven& at() const noexcept { return at_; }
  bool still() const noexcept;
  /// Commands that were not the wanted velocity.
  std::uint64_t shaped() const noexcept { return shaped_; }

 private:
  double approach(std::size_t axis, double wanted, const wire::AxisLimitsOf<7>& limits) noexcept;
  double period_;
  Seven at_{}, acceleration_{};
  std::uint64_t shaped_ = 0;
  trajectory::StateToState planner_;
};

}  // namespace polyarm::franka
