#pragma once
/// The range of each command of one joint in the next `dt` seconds, from its limits and its state.
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "joint_limits/data_structures.hpp"
#include "joint_limits/joint_limits.hpp"

namespace joint_limits {
namespace internal {
constexpr double POSITION_BOUNDS_TOLERANCE = 0.002;
constexpr double OUT_OF_BOUNDS_EXCEPTION_TOLERANCE = 0.0087;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Limits>
Limits ordered(Limits range) {
  if (range.lower_limit > range.upper_limit) std::swap(range.lower_limit, range.upper_limit);
  return range;
}
inline bool is_number(const std::optional<double>& value) {
  return value && !std::isnan(*value);
}
/// By how much a position lies outside its limits.
inline double beyond(const JointLimits& limits, double position) {
  return std::max({0.0, position - limits.max_position, limits.min_position - position});
}
}  // namespace internal

inline bool is_limited(double value, double min, double max) {
  return value < min || value > max;
}

/// Takes over what `desired` has; NaN changes nothing.
inline void update_prev_command(const JointControlInterfacesData& desired,
                                JointControlInterfacesData& prev_command) {
  const auto take = [](const std::optional<double>& from, std::optional<double>& to) {
    if (internal::is_number(from)) to = from;
  };
  take(desired.position, prev_command.position), take(desired.velocity, prev_command.velocity);
  take(desired.effort, prev_command.effort), take(desired.acceleration, prev_command.acceleration);
  take(desired.jerk, prev_command.jerk);
  prev_command.joint_name = desired.joint_name;
}

/// What can be reached from the last command (without one: from the position), within the limits. Throws
/// std::runtime_error if the joint is more than 0.5° (or 8.7 mm) outside its limits.
inline PositionLimits compute_position_limits(const std::string& joint_name, const JointLimits& limits,
                                              const std::optional<double>& act_vel,
                                              const std::optional<double>& act_pos,
                                              const std::optional<double>& prev_command_pos, double dt) {
  if (limits.has_position_limits && act_pos &&
      internal::beyond(limits, *act_pos) > internal::OUT_OF_BOUNDS_EXCEPTION_TOLERANCE)
    throw std::runtime_error("Joint position is out of bounds for the joint : '" + joint_name +
                             "' actual position: " + std::to_string(*act_pos) + " limits: [" +
                             std::to_string(limits.min_position) + ", " +
                             std::to_string(limits.max_position) + "]");
  PositionLimits out(limits.min_position, limits.max_position);
  const std::optional<double>& from = prev_command_pos ? prev_command_pos : act_pos;
  if (limits.has_velocity_limits && from) {
    double speed = limits.max_velocity;
    if (limits.has_acceleration_limits)
      speed = std::min(speed, std::fabs(act_vel.value_or(0.0)) + limits.max_acceleration * dt);
    // The comparisons keep the other limit where a limit is NaN.
    out.lower_limit = std::max(std::min(*from - speed * dt, out.upper_limit), out.lower_limit);
    out.upper_limit = std::min(std::max(*from + speed * dt, out.lower_limit), out.upper_limit);
  }
  return internal::ordered(out);
}

/// 0 to 0 for a joint that is outside its position limits, unless it is hardly outside and moves back.
inline VelocityLimits compute_velocity_limits(const std::string&, const JointLimits& limits,
                                              const double& desired_vel, const std::optional<double>& act_pos,
                                              const std::optional<double>& prev_command_vel, double dt) {
  if (!limits.has_velocity_limits) return {-internal::kInfinity, internal::kInfinity};
  VelocityLimits out(-limits.max_velocity, limits.max_velocity);
  if (limits.has_position_limits && act_pos) {
    out.lower_limit = std::max((limits.min_position - *act_pos) / dt, out.lower_limit);
    out.upper_limit = std::min((limits.max_position - *act_pos) / dt, out.upper_limit);
    const double beyond = internal::beyond(limits, *act_pos);
    const bool outwards = *act_pos > limits.max_position ? desired_vel >= 0.0 : desired_vel <= 0.0;
    if (beyond > internal::POSITION_BOUNDS_TOLERANCE ||
        (beyond > 0 && beyond < internal::POSITION_BOUNDS_TOLERANCE && outwards))
      out = VelocityLimits(0.0, 0.0);
  }
  if (limits.has_acceleration_limits && prev_command_vel) {
    const double change = limits.max_acceleration * dt;
    out.lower_limit = std::max(*prev_command_vel - change, out.lower_limit);
    out.upper_limit = std::min(*prev_command_vel + change, out.upper_limit);
  }
  return internal::ordered(out);
}

/// No effort pushes a joint further beyond its position or velocity limits.
inline EffortLimits compute_effort_limits(const JointLimits& limits, const std::optional<double>& act_pos,
                                          const std::optional<double>& act_vel, double) {
  if (!limits.has_effort_limits) return {-internal::kInfinity, internal::kInfinity};
  EffortLimits out(-limits.max_effort, limits.max_effort);
  if (limits.has_position_limits && act_pos && act_vel) {
    if (*act_pos <= limits.min_position && *act_vel <= 0.0)
      out.lower_limit = 0.0;
    else if (*act_pos >= limits.max_position && *act_vel >= 0.0)
      out.upper_limit = 0.0;
  }
  if (limits.has_velocity_limits && act_vel) {
    if (*act_vel < -limits.max_velocity)
      out.lower_limit = 0.0;
    else if (*act_vel > limits.max_velocity)
      out.upper_limit = 0.0;
  }
  return internal::ordered(out);
}

/// The limit of deceleration if the joint gets slower and has one, else that of acceleration.
inline AccelerationLimits compute_acceleration_limits(const JointLimits& limits, double desired_acceleration,
                                                      std::optional<double> actual_velocity) {
  const bool slower = actual_velocity && desired_acceleration * *actual_velocity < 0;
  double most = internal::kInfinity;
  if (limits.has_deceleration_limits && slower)
    most = limits.max_deceleration;
  else if (limits.has_acceleration_limits)
    most = limits.max_acceleration;
  return internal::ordered(AccelerationLimits(-most, most));
}

}  // namespace joint_limits
