#pragma once
/// A limiter that clamps commands: of one joint's interfaces (JointControlInterfacesData), or of all joints'
/// positions, velocities and accelerations (a point of a trajectory). enforce allocates nothing.
#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "joint_limits/joint_limits_helpers.hpp"
#include "joint_limits/limiter_base.hpp"
#include "rclcpp/clock.hpp"
#include "rclcpp/duration.hpp"

namespace joint_limits {
namespace detail {

/// Clamps a command that is a number; true if that changes it.
inline bool clamp_command(std::optional<double>& value, double lower, double upper) {
  if (!internal::is_number(value)) return false;
  const bool limited = is_limited(*value, lower, upper);
  if (limited) value = *value < lower ? lower : upper;
  return limited;
}
/// A limiter's first command starts where the joint is; without a state, at the command itself.
inline void begin_with(const JointControlInterfacesData& actual, const JointControlInterfacesData& desired,
                       JointControlInterfacesData& previous) {
  if (previous.has_data()) return;
  const auto begin = [](const std::optional<double>& wanted, const std::optional<double>& state,
                        std::optional<double>& out) {
    if (!wanted) return;
    if (state)
      out = state;
    else if (!std::isnan(*wanted))
      out = wanted;
  };
  begin(desired.position, actual.position, previous.position);
  begin(desired.velocity, actual.velocity, previous.velocity);
  begin(desired.effort, actual.effort, previous.effort);
  begin(desired.acceleration, actual.acceleration, previous.acceleration);
  begin(desired.jerk, actual.jerk, previous.jerk);
}
inline bool clamp_acceleration_and_jerk(const JointLimits& limits, const JointControlInterfacesData& actual,
                                        JointControlInterfacesData& desired) {
  bool out = false;
  if (internal::is_number(desired.acceleration)) {
    const auto range = compute_acceleration_limits(limits, *desired.acceleration, actual.velocity);
    out = clamp_command(desired.acceleration, range.lower_limit, range.upper_limit);
  }
  return clamp_command(desired.jerk, -limits.max_jerk, limits.max_jerk) || out;
}

/// Each command of one joint by itself. `previous` is the last command.
inline bool saturate(const std::string& joint, const JointLimits& limits,
                     const JointControlInterfacesData& actual, JointControlInterfacesData& desired,
                     JointControlInterfacesData& previous, double dt) {
  begin_with(actual, desired, previous);
  bool out = false;
  if (internal::is_number(desired.position)) {
    const auto range =
        compute_position_limits(joint, limits, actual.velocity, actual.position, previous.position, dt);
    out = clamp_command(desired.position, range.lower_limit, range.upper_limit);
  }
  if (internal::is_number(desired.velocity)) {
    const auto range =
        compute_velocity_limits(joint, limits, *desired.velocity, actual.position, previous.velocity, dt);
    out = clamp_command(desired.velocity, range.lower_limit, range.upper_limit) || out;
  }
  if (internal::is_number(desired.effort)) {
    const auto range = compute_effort_limits(limits, actual.position, actual.velocity, dt);
    out = clamp_command(desired.effort, range.lower_limit, range.upper_limit) || out;
  }
  out = clamp_acceleration_and_jerk(limits, actual, desired) || out;
  update_prev_command(desired, previous);
  return out;
}

/// The next point of several joints. Position, velocity and acceleration of a joint stay consistent. If one
/// joint could not stop before its position limit, all joints brake.
class PointSaturation {
 public:
  void resize(std::size_t joints) { all_.resize(joints); }

  bool enforce(const std::vector<JointLimits>& limits, const JointLimitsStateDataType& current,
               JointLimitsStateDataType& desired, double dt) {
    const std::size_t n = all_.size();
    const bool positions = desired.positions.size() == n, velocities = desired.velocities.size() == n;
    const bool accelerations = desired.accelerations.size() == n;
    if (n == 0 || current.positions.size() != n || !(positions || velocities)) return false;
    bool limited = false, brake = false;
    for (std::size_t i = 0; i < n; ++i) {
      One& one = all_[i];
      one.at = current.positions[i];
      one.speed = current.velocities.size() == n ? current.velocities[i] : 0.0;
      one.position = positions ? desired.positions[i] : 0.0;
      one.velocity = velocities ? desired.velocities[i] : 0.0;
      one.acceleration = accelerations ? desired.accelerations[i] : 0.0;
      one.limited = false;
      if (positions) limit_position(limits[i], one, dt);
      limit_velocity(limits[i], one, positions, dt);
      limit_acceleration(limits[i], one, positions, dt);
      if (limits[i].has_position_limits) {
        if (velocities && !positions) stay_inside(limits[i], one, dt);
        if (!can_stop(limits[i], one, dt)) one.limited = brake = true;
      }
      limited = limited || one.limited;
    }
    for (std::size_t i = 0; i < n; ++i) {
      One& one = all_[i];
      if (brake) slow_down(limits[i], one, dt);
      if (positions) desired.positions[i] = one.position;
      if (velocities) desired.velocities[i] = one.velocity;
      if (accelerations) desired.accelerations[i] = one.acceleration;
    }
    return limited;
  }

 private:
  struct One {
    double at = 0, speed = 0, position = 0, velocity = 0, acceleration = 0;
    bool limited = false;
  };
  static bool none(double value) { return std::isnan(value) || std::fabs(value) <= 1e-10; }

  static void limit_position(const JointLimits& limits, One& one, double dt) {
    if (limits.has_position_limits && is_limited(one.position, limits.min_position, limits.max_position)) {
      one.position = one.position < limits.min_position ? limits.min_position : limits.max_position;
      one.limited = true;
    }
    if (none(one.velocity) && !none(one.position - one.at)) one.velocity = (one.position - one.at) / dt;
  }
  static void limit_velocity(const JointLimits& limits, One& one, bool positions, double dt) {
    if (!limits.has_velocity_limits) return;
    if (none(one.velocity) && positions) one.velocity = (one.position - one.at) / dt;
    if (!(std::fabs(one.velocity) > limits.max_velocity)) return;
    one.velocity = std::copysign(limits.max_velocity, one.velocity);
    if (positions) one.position = one.at + one.velocity * dt;
    one.acceleration = (one.velocity - one.speed) / dt;
    one.limited = true;
  }
  static void limit_acceleration(const JointLimits& limits, One& one, bool positions, double dt) {
    if (!limits.has_acceleration_limits && !limits.has_deceleration_limits) return;
    if (none(one.acceleration)) one.acceleration = (one.velocity - one.speed) / dt;
    const auto range = compute_acceleration_limits(limits, one.acceleration, one.speed);
    if (!is_limited(one.acceleration, range.lower_limit, range.upper_limit)) return;
    one.acceleration = std::copysign(range.upper_limit, one.acceleration);
    one.velocity = one.speed + one.acceleration * dt;
    if (positions) one.position = one.at + one.speed * dt + 0.5 * one.acceleration * dt * dt;
    one.limited = true;
  }
  static void stay_inside(const JointLimits& limits, One& one, double dt) {
    const double next = one.at + one.velocity * dt;
    if (!is_limited(next, limits.min_position, limits.max_position)) return;
    one.velocity = ((next < limits.min_position ? limits.min_position : limits.max_position) - one.at) / dt;
    one.limited = true;
  }
  /// Also if the joint begins to brake only after the time that braking takes.
  static bool can_stop(const JointLimits& limits, const One& one, double dt) {
    if (!(std::fabs(one.velocity) > 0)) return true;
    double braking = std::fabs(one.velocity / dt);
    if (limits.has_deceleration_limits)
      braking = limits.max_deceleration;
    else if (limits.has_acceleration_limits)
      braking = limits.max_acceleration;
    const double room = one.velocity > 0 ? limits.max_position - one.at : one.at - limits.min_position;
    return !(room < one.velocity * one.velocity / braking);
  }
  static void slow_down(const JointLimits& limits, One& one, double dt) {
    double most = std::fabs(one.speed / dt);
    if (limits.has_deceleration_limits)
      most = std::min(most, limits.max_deceleration);
    else if (limits.has_acceleration_limits)
      most = std::min(most, limits.max_acceleration);
    one.acceleration = std::copysign(most, -one.speed);
    one.velocity = one.speed + one.acceleration * dt;
    one.position = one.at + one.speed * dt + 0.5 * one.acceleration * dt * dt;
  }
  std::vector<One> all_;
};

}  // namespace detail

template <typename Kind>
class JointSaturationLimiter : public JointLimiterInterface<Kind> {
  static constexpr bool kOneJoint = std::is_same_v<Kind, JointControlInterfacesData>;

 public:
  using typename JointLimiterInterface<Kind>::Data;

  bool on_init() override {
    if constexpr (kOneJoint) {
      prev_command_ = {};
      if (this->number_of_joints_ == 1) {
        prev_command_.joint_name = this->joint_names_[0];  // room for the name in each command
        return true;
      }
      if (this->has_logging_interface())
        RCLCPP_ERROR(this->node_logging_itf_->get_logger(),
                     "a limiter of interfaces has exactly one joint, not %zu", this->number_of_joints_);
      return false;
    } else {
      points_.resize(this->number_of_joints_);
      return true;
    }
  }
  bool on_configure(const Data& current) override {
    prev_command_ = current;
    return true;
  }
  bool on_enforce(const Data& current, Data& desired, const rclcpp::Duration& dt) override {
    const std::lock_guard lock(mutex_);
    const double seconds = dt.seconds();
    if (!(seconds > 0)) return false;
    if constexpr (kOneJoint)
      return detail::saturate(this->joint_names_[0], this->joint_limits_[0], current, desired, prev_command_,
                              seconds);
    else
      return points_.enforce(this->joint_limits_, current, desired, seconds);
  }
  void reset_internals() override {
    const std::lock_guard lock(mutex_);
    if constexpr (kOneJoint) {
      std::string name = std::move(prev_command_.joint_name);
      prev_command_ = Data();
      prev_command_.joint_name = std::move(name);
    } else {
      prev_command_ = Data();
    }
  }

 protected:
  rclcpp::Clock::SharedPtr clock_ = std::make_shared<rclcpp::Clock>(RCL_ROS_TIME);
  Data prev_command_;
  std::mutex mutex_;

 private:
  detail::PointSaturation points_;
};

}  // namespace joint_limits
