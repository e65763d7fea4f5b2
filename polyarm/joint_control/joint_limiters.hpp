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
  held,          ///< the loop is held or at fault: nothing moves, whatever is commanded
};
inline constexpr int kLimits = 11;
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

/// What may be commanded, and why not more; `cause` is the limit nearest to what was asked. `fault`: the
/// joint is measured further beyond its limits than kFaultBeyond, which no command explains; ros2_control
/// throws there. A time step that is not above 0 leaves every command as it is.
struct Allowed {
  double value;
  Limit cause = Limit::none;
  bool fault = false;
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

/// Whether the joint is measured so far beyond its limits that something must be wrong with it.
inline bool far_outside(const LimiterSettings& s, const JointNow& now) noexcept {
  return now.position > s.upper + kFaultBeyond || now.position < s.lower - kFaultBeyond;
}

/// What slows a joint down is limited by the deceleration, or by the acceleration where there is none.
inline double braking(const LimiterSettings& s) noexcept {
  return s.deceleration > 0 && s.deceleration < kUnlimited ? s.deceleration : s.acceleration;
}
inline bool limits_changes(const LimiterSettings& s) noexcept {
  return s.acceleration < kUnlimited || braking(s) < kUnlimited;
}

/// The lowest speed that can be reached from `speed` in `dt`: slowing down as far as rest, then backwards.
/// (The highest one is -lowest_speed(s, -speed, dt).)
inline double lowest_speed(const LimiterSettings& s, double speed, double dt) noexcept {
  if (!(speed > 0)) return speed - s.acceleration * dt;
  const double brake = braking(s);
  if (speed >= brake * dt) return speed - brake * dt;
  return -s.acceleration * (dt - speed / brake);
}

/// The highest mean speed over the next `dt` after which a joint with `room` before it still stops in time,
/// when its speed falls by braking * dt in each step after it. With w for the speed at that step's end, the
/// room is (w + braking * dt)^2 / (2 braking).
inline double highest_speed_before_stop(double braking, double room, double dt) noexcept {
  if (room <= 0.5 * braking * dt * dt) return room / dt;
  return std::sqrt(2 * braking * room) - 0.5 * braking * dt;
}

/// The positions from which a joint inside its limits still stops before the one that it goes for. Far from
/// it, that is every position it can reach.
inline void narrow_before_stop(Range& range, const LimiterSettings& s, bool upwards, double last,
                               double last_velocity, double dt) noexcept {
  const double room = upwards ? s.upper - last : last - s.lower;
  const double brake = braking(s), speed = upwards ? last_velocity : -last_velocity;
  const double fastest = std::max(speed, 0.0) + (std::max(s.acceleration, brake) + 0.5 * brake) * dt;
  if (!(room > 0) || fastest * fastest <= 2 * brake * room) return;
  const double step = highest_speed_before_stop(brake, room, dt) * dt;
  if (upwards)
    range.narrow(-kUnlimited, last + step, Limit::position);
  else
    range.narrow(last - step, kUnlimited, Limit::position);
}

/// The speeds that the acceleration leaves after `last`, each end with its own limit.
inline void narrow_by_acceleration(Range& range, const LimiterSettings& s, double last, double offset,
                                   double scale, double dt) noexcept {
  const Limit slows = s.deceleration < kUnlimited ? Limit::deceleration : Limit::acceleration;
  range.narrow(offset + lowest_speed(s, last, dt) * scale, kUnlimited,
               last > 0 ? slows : Limit::acceleration);
  range.narrow(-kUnlimited, offset - lowest_speed(s, -last, dt) * scale,
               last < 0 ? slows : Limit::acceleration);
}

/// Speeds that the soft limits leave, between -velocity and velocity. Without a k_position nothing is slowed
/// down before the edge (ros2_control would allow no motion at all).
inline Range soft_speeds(const LimiterSettings& s, double position) noexcept {
  Range out;
  out.narrow(-s.velocity, s.velocity, Limit::velocity);
  if (!s.soft || !std::isfinite(position)) return out;
  const SoftLimits& soft = s.soft_limits;
  const auto within = [&](double v) { return std::clamp(v, -s.velocity, s.velocity); };
  const double k = soft.k_position;
  double low = k > 0 ? within(k * (soft.lower - position)) : position < soft.lower ? s.velocity : -s.velocity;
  double high = k > 0                   ? within(k * (soft.upper - position))
                : position > soft.upper ? -s.velocity
                                        : s.velocity;
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
/// last commands where accelerations are limited, else anything. Where an acceleration is limited, a joint
/// slows down in time for its position limits; where the limits contradict each other, the position's hold.
inline Allowed allow_position(const LimiterSettings& s, const JointNow& now, double asked, double last,
                              double last_velocity, double dt) noexcept {
  if (!std::isfinite(asked)) return {last, Limit::not_a_number};
  if (!(dt > 0)) return {asked};
  Range range;
  if (s.soft) {
    const Range speeds = soft_speeds(s, last);
    range.narrow(std::min(s.soft_limits.lower, last), std::max(s.soft_limits.upper, last),
                 Limit::soft_position);
    if (speeds.low_cause == Limit::soft_position || speeds.high_cause == Limit::soft_position)
      range.narrow(last + speeds.low * dt, last + speeds.high * dt, Limit::soft_position);
  }
  if (s.velocity < kUnlimited) range.narrow(last - s.velocity * dt, last + s.velocity * dt, Limit::velocity);
  if (limits_changes(s) && std::isfinite(last_velocity)) {
    narrow_before_stop(range, s, asked >= last, last, last_velocity, dt);
    narrow_by_acceleration(range, s, last_velocity, last, dt, dt);
  }
  // A joint beyond its limits may stay where it is and come back, not go further out.
  range.narrow(std::min(s.lower, last), std::max(s.upper, last),
               last < s.lower || last > s.upper ? Limit::out_of_range : Limit::position);
  Allowed out = range.apply(asked);
  out.fault = far_outside(s, now);
  return out;
}

/// What the limits of position leave of the speeds. Beyond its limits by a little a joint may come back; by
/// more it stands.
inline void narrow_by_position(Range& range, const LimiterSettings& s, double position, double dt) noexcept {
  const double out = std::max(s.lower - position, position - s.upper);
  if (out > kExpectedBeyond)
    range.narrow(0, 0, Limit::out_of_range);
  else if (position > s.upper)
    range.narrow(-kUnlimited, 0, Limit::out_of_range);
  else if (position < s.lower)
    range.narrow(0, kUnlimited, Limit::out_of_range);
  else
    range.narrow((s.lower - position) / dt, (s.upper - position) / dt, Limit::position);
}

/// A velocity. `last` is the velocity commanded last.
inline Allowed allow_velocity(const LimiterSettings& s, const JointNow& now, double asked, double last,
                              double dt) noexcept {
  if (!std::isfinite(asked)) return {0, Limit::not_a_number};
  if (!(dt > 0)) return {asked};
  Range range = soft_speeds(s, now.position);
  if (limits_changes(s) && std::isfinite(last)) narrow_by_acceleration(range, s, last, 0, 1, dt);
  const SoftLimits& soft = s.soft_limits;
  if (s.soft && now.position >= soft.lower && now.position <= soft.upper)
    range.narrow((soft.lower - now.position) / dt, (soft.upper - now.position) / dt, Limit::soft_position);
  if (std::isfinite(now.position)) narrow_by_position(range, s, now.position, dt);
  Allowed out = range.apply(asked);
  out.fault = far_outside(s, now);
  return out;
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
  if (s.jerk < kUnlimited && std::isfinite(last) && dt > 0)
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

/// One point of a trajectory. NaN in what is asked: not stated.
struct RequestedPoint {
  double position = std::numeric_limits<double>::quiet_NaN();
  double velocity = std::numeric_limits<double>::quiet_NaN();
};
struct LimitedPoint {
  double position, velocity, acceleration;
  Limit cause = Limit::none;  ///< the last limit that took hold
};

/// The point that follows `position` and `velocity` when their rate changes by `acceleration` for `dt`.
inline LimitedPoint point_after(const LimiterSettings& s, double position, double velocity,
                                double acceleration, double dt, Limit cause) noexcept {
  const double p = position + velocity * dt + 0.5 * acceleration * dt * dt;
  const double inside = std::clamp(p, std::min(s.lower, position), std::max(s.upper, position));
  return {inside, velocity + acceleration * dt, acceleration, inside != p ? Limit::position : cause};
}

/// Whether a joint that goes on from here can still stop before its limits of position.
inline bool stops_in_time(const LimiterSettings& s, const LimitedPoint& point) noexcept {
  const double room = point.velocity > 0 ? s.upper - point.position : point.position - s.lower;
  return point.velocity == 0 || !(point.velocity * point.velocity / (2 * braking(s)) > room);
}

/// The point `dt` after (`position`, `velocity`), as near to what is asked as the limits allow; a velocity
/// that is not stated, or 0 with a position elsewhere, is the one that leads to the position. Who could not
/// stop before a limit of position slows down instead. Without a dt above 0: the present point.
inline LimitedPoint limit_point(const LimiterSettings& s, double position, double velocity,
                                const RequestedPoint& asked, double dt) noexcept {
  if (!(dt > 0)) return {position, velocity, 0};
  const bool placed = std::isfinite(asked.position);
  const double target = placed ? std::clamp(asked.position, s.lower, s.upper) : position;
  const double step = s.velocity * dt;
  Limit cause = placed && target != asked.position ? Limit::position : Limit::none;
  double wanted = asked.velocity;
  if (!std::isfinite(wanted) || (placed && wanted == 0)) wanted = (target - position) / dt;
  if (!placed && !std::isfinite(asked.velocity)) cause = Limit::not_a_number;
  const double speed = std::clamp(wanted, -s.velocity, s.velocity);
  if (speed != wanted || std::abs(target - position) > step) cause = Limit::velocity;
  const double a = (speed - velocity) / dt;
  const bool slows = a * velocity < 0 && s.deceleration < kUnlimited;
  const double most = slows ? s.deceleration : s.acceleration;
  LimitedPoint out{placed ? std::clamp(target, position - step, position + step) : position, speed, a, cause};
  if (std::abs(a) > most)
    out = point_after(s, position, velocity, std::copysign(most, a), dt,
                      slows ? Limit::deceleration : Limit::acceleration);
  else if (!placed)
    out = point_after(s, position, velocity, a, dt, cause);
  if (stops_in_time(s, out)) return out;
  const double stop = std::min(std::abs(velocity) / dt, braking(s));
  return point_after(s, position, velocity, -std::copysign(stop, velocity), dt, Limit::position);
}
inline LimitedPoint limit_point(const LimiterSettings& s, double position, double velocity,
                                double asked_velocity, double dt) noexcept {
  return limit_point(s, position, velocity, {.velocity = asked_velocity}, dt);
}

}  // namespace polyarm::controllers
