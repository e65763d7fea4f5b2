#pragma once
#include <limits>
#include <optional>
#include <string>

namespace polyarm::controllers {

/// Bounds of one speed, linear (m/s) or angular (rad/s), by the names and signs of diff_drive_controller's
/// parameters. NaN is not stated: without a `max_` velocity, acceleration or jerk that quantity is free;
/// an unstated `min_` is the negative of its `max_`.
struct SpeedLimits {
  static constexpr double kFree = std::numeric_limits<double>::quiet_NaN();
  double max_velocity = kFree, min_velocity = kFree;  ///< >= 0, <= 0
  double max_acceleration = kFree;                    ///< >= 0: from rest or forwards, faster forwards
  double max_deceleration = kFree;            ///< < 0: forwards, slower; unstated: max_acceleration_reverse
  double max_acceleration_reverse = kFree;    ///< <= 0: from rest or backwards, faster backwards
  double max_deceleration_reverse = kFree;    ///< > 0: backwards, slower; unstated: -max_deceleration
  double max_jerk = kFree, min_jerk = kFree;  ///< >= 0, <= 0; holds while getting faster only
};

/// Why these limits cannot be, as a sentence without a full stop.
std::optional<std::string> check(const SpeedLimits& limits);

/// Follows a wanted speed within limits: jerk first, then acceleration, then velocity. Real-time.
class SpeedLimiter {
 public:
  /// Takes limits that pass check().
  void set(const SpeedLimits& limits) noexcept;
  /// The speed `dt` seconds after the last one. A wanted speed that is NaN, or a dt that is not positive,
  /// leaves the speed as it is.
  double next(double wanted, double dt) noexcept;
  /// From here on as if it had moved at this speed for some time.
  void reset(double speed = 0) noexcept { last_ = before_ = speed; }
  double speed() const noexcept { return last_; }

 private:
  static constexpr double kAny = std::numeric_limits<double>::infinity();
  double max_ = kAny, min_ = -kAny;
  double faster_forwards_ = kAny, slower_forwards_ = -kAny;
  double faster_backwards_ = -kAny, slower_backwards_ = kAny;
  double max_jerk_ = kAny, min_jerk_ = -kAny;
  double last_ = 0, before_ = 0;
};

}  // namespace polyarm::controllers
