#pragma once
/// What a joint may be commanded, worked out for one joint and one cycle: pure functions of limits, measured
/// state and last command, with the rules and numbers of ros2_control's joint_limits. All of it is for the
/// control thread: nothing allocates, locks or throws. Standard types only.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Which limit took hold of a command.
enum class Limit : std::uint8_t {
  none,
  not_a_number,
  position,
  velocity,
  acceleration,
  deceleration,
  jerk,
  effort,
  soft_position,
  out_of_range,  ///< the joint stands outside its limits and may only come back
};
inline constexpr int kLimits = 10;
const char* name(Limit limit);

/// A limit that is infinite does not exist; none is ever 0 by default, so nothing freezes a joint unasked.
struct LimiterSettings {
  double lower = -kUnlimited, upper = kUnlimited;
  double velocity = kUnlimited, acceleration = kUnlimited, deceleration = kUnlimited, jerk = kUnlimited;
  double effort = kUnlimited;
  bool soft = false;
  SoftLimits soft_limits = {};
};

/// What is measured of the joint; NaN where it is not.
struct JointNow {
  double position = std::numeric_limits<double>::quiet_NaN();
  double velocity = std::numeric_limits<double>::quiet_NaN();
};

/// What may be commanded, and why not more; `cause` is the limit nearest to what was asked.
struct Allowed {
  double value;
  Limit cause = Limit::none;
};

/// Beyond its limits by less than this, rad or m, a joint may be moved inwards; beyond by more, a velocity is
/// stopped altogether. (ros2_control's numbers.)
inline constexpr double kExpectedBeyond = 0.002, kFaultBeyond = 0.0087;
/// Outside its soft range a joint comes back at this speed, rad/s or m/s.
inline constexpr double kSoftReturn = 3.14159265358979323846 / 180;

/// An interval that shrinks, with the limits that made its ends.
struct Range {
  double low = -kUnlimited, high = kUnlimited;
  Limit low_cause = Limit::none, high_cause = Limit::none;
  /// Where the two do not meet, the new one's nearer end is all that is left.
  void narrow(double lowest, double highest, Limit cause) noexcept {
    if (lowest > low) low = lowest, low_cause = cause;
    if (highest < high) high = highest, high_cause = cause;
    if (low <= high) return;
    if (lowest >= low)
      high = low, high_cause = cause;
    else
      low = high, low_cause = cause;
  }
  Allowed apply(double asked) const noexcept {
    if (asked < low) return {low, low_cause};
    if (asked > high) return {high, high_cause};
    return {asked, Limit::none};
  }
};

/// Speeds that the soft limits leave, between -velocity and velocity.
inline Range soft_speeds(const LimiterSettings& s, double position) noexcept {
  Range out;
  out.narrow(-s.velocity, s.velocity, Limit::velocity);
  if (!s.soft || !std::isfinite(position)) return out;
  const SoftLimits& soft = s.soft_limits;
  const auto within = [&](double v) { return std::clamp(v, -s.velocity, s.velocity); };
  double low = within(-soft.k_position * (position - soft.lower));
  double high = within(-soft.k_position * (position - soft.upper));
  if (position < soft.lower || position > soft.upper || position < s.lower || position > s.upper) {
    low = std::copysign(kSoftReturn, low);
    high = std::copysign(kSoftReturn, high);
  }
  if (!(low <= high)) std::swap(low, high);
  if (low > out.low) out.low = low, out.low_cause = Limit::soft_position;
  if (high < out.high) out.high = high, out.high_cause = Limit::soft_position;
  return out;
}

/// A position. `last` is the last command (at first the measured position), `last_velocity` the speed of the
/// last commands where accelerations are limited, else anything.
inline Allowed allow_position(const LimiterSettings& s, const JointNow& now, double asked, double last,
                              double last_velocity, double dt) noexcept {
  if (!std::isfinite(asked)) return {last, Limit::not_a_number};
  Range range;
  // A joint beyond its limits may stay where it is and come back, not go further out.
  const double lower = std::min(s.lower, last), upper = std::max(s.upper, last);
  range.narrow(lower, upper, last < s.lower || last > s.upper ? Limit::out_of_range : Limit::position);
  if (s.soft) {
    const Range speeds = soft_speeds(s, last);
    range.narrow(std::min(s.soft_limits.lower, last), std::max(s.soft_limits.upper, last),
                 Limit::soft_position);
    if (speeds.low_cause == Limit::soft_position || speeds.high_cause == Limit::soft_position)
      range.narrow(last + speeds.low * dt, last + speeds.high * dt, Limit::soft_position);
  }
  if (s.velocity < kUnlimited) range.narrow(last - s.velocity * dt, last + s.velocity * dt, Limit::velocity);
  if (s.acceleration < kUnlimited && std::isfinite(last_velocity)) {
    const double slower = s.deceleration < kUnlimited ? s.deceleration : s.acceleration;
    const double down = last_velocity > 0 ? slower : s.acceleration,
                 up = last_velocity < 0 ? slower : s.acceleration;
    range.narrow(last + (last_velocity - down * dt) * dt, last + (last_velocity + up * dt) * dt,
                 Limit::acceleration);
  }
  (void)now;
  return range.apply(asked);
}

/// A velocity. `last` is the velocity commanded last.
inline Allowed allow_velocity(const LimiterSettings& s, const JointNow& now, double asked, double last,
                              double dt) noexcept {
  if (!std::isfinite(asked)) return {0, Limit::not_a_number};
  Range range = soft_speeds(s, now.position);
  if (s.acceleration < kUnlimited && std::isfinite(last)) {
    const double slower = s.deceleration < kUnlimited ? s.deceleration : s.acceleration;
    const double down = last > 0 ? slower : s.acceleration, up = last < 0 ? slower : s.acceleration;
    range.narrow(last - down * dt, last + up * dt, Limit::acceleration);
  }
  if (std::isfinite(now.position) && (s.lower > -kUnlimited || s.upper < kUnlimited)) {
    const double out = std::max(s.lower - now.position, now.position - s.upper);
    if (out > kExpectedBeyond)
      range.narrow(0, 0, Limit::out_of_range);
    else if (out > 0)  // inwards only
      now.position > s.upper ? range.narrow(-kUnlimited, 0, Limit::out_of_range)
                             : range.narrow(0, kUnlimited, Limit::out_of_range);
    else
      range.narrow((s.lower - now.position) / dt, (s.upper - now.position) / dt, Limit::position);
  }
  return range.apply(asked);
}

/// An acceleration: what slows down is limited by the deceleration where there is one, and only then.
inline Allowed allow_acceleration(const LimiterSettings& s, const JointNow& now, double asked, double last,
                                  double dt) noexcept {
  if (!std::isfinite(asked)) return {0, Limit::not_a_number};
  Range range;
  const bool slows = std::isfinite(now.velocity) && asked * now.velocity < 0;
  if (slows && s.deceleration < kUnlimited)
    range.narrow(-s.deceleration, s.deceleration, Limit::deceleration);
  else if (s.acceleration < kUnlimited)
    range.narrow(-s.acceleration, s.acceleration, Limit::acceleration);
  if (s.jerk < kUnlimited && std::isfinite(last))
    range.narrow(last - s.jerk * dt, last + s.jerk * dt, Limit::jerk);
  return range.apply(asked);
}

/// An effort: none that pushes a joint further out of its limits or makes one faster that is too fast.
inline Allowed allow_effort(const LimiterSettings& s, const JointNow& now, double asked) noexcept {
  if (!std::isfinite(asked)) return {0, Limit::not_a_number};
  Range range;
  range.narrow(-s.effort, s.effort, Limit::effort);
  if (s.soft && std::isfinite(s.soft_limits.k_velocity) && s.soft_limits.k_velocity > 0 &&
      s.effort < kUnlimited && std::isfinite(now.velocity)) {
    const Range speeds = soft_speeds(s, now.position);
    const double k = s.soft_limits.k_velocity;
    range.narrow(std::clamp(-k * (now.velocity - speeds.low), -s.effort, s.effort),
                 std::clamp(-k * (now.velocity - speeds.high), -s.effort, s.effort), Limit::soft_position);
  }
  if (std::isfinite(now.position) && std::isfinite(now.velocity)) {
    if (now.position <= s.lower && now.velocity <= 0) range.narrow(0, kUnlimited, Limit::position);
    if (now.position >= s.upper && now.velocity >= 0) range.narrow(-kUnlimited, 0, Limit::position);
  }
  if (std::isfinite(now.velocity)) {
    if (now.velocity < -s.velocity) range.narrow(0, kUnlimited, Limit::velocity);
    if (now.velocity > s.velocity) range.narrow(-kUnlimited, 0, Limit::velocity);
  }
  return range.apply(asked);
}

/// One point of a trajectory: position, velocity and acceleration after `dt` that keep the limits, coming
/// from `position` and `velocity`, on the way to `asked_velocity`.
struct LimitedPoint {
  double position, velocity, acceleration;
};
inline LimitedPoint limit_point(const LimiterSettings& s, double position, double velocity,
                                double asked_velocity, double dt) noexcept {
  const double wanted = std::clamp(asked_velocity, -s.velocity, s.velocity);
  double a = (wanted - velocity) / dt;
  const bool slows = a * velocity < 0;
  const double most = slows && s.deceleration < kUnlimited ? s.deceleration : s.acceleration;
  a = std::clamp(a, -most, most);
  const double p = std::clamp(position + velocity * dt + 0.5 * a * dt * dt, std::min(s.lower, position),
                              std::max(s.upper, position));
  return {p, velocity + a * dt, a};
}

}  // namespace polyarm::controllers
