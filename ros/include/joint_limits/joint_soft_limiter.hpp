#pragma once
/// A limiter of one joint that slows it down before its limits: the largest velocity towards a soft limit is
/// k_position times the distance from it; the largest effort is k_velocity times what is left of that
/// velocity.
#include <algorithm>
#include <cmath>

#include "joint_limits/joint_saturation_limiter.hpp"

namespace joint_limits {

class JointSoftLimiter : public JointSaturationLimiter<JointControlInterfacesData> {
 public:
  bool has_soft_position_limits(const SoftJointLimits& soft) const {
    return std::isfinite(soft.min_position) && std::isfinite(soft.max_position) &&
           soft.max_position - soft.min_position > 1e-10;
  }
  bool has_soft_limits(const SoftJointLimits& soft) const {
    return has_soft_position_limits(soft) && std::isfinite(soft.k_position) &&
           std::fabs(soft.k_position) > 1e-10;
  }
  bool on_enforce(const JointControlInterfacesData& actual, JointControlInterfacesData& desired,
                  const rclcpp::Duration& dt) override {
    const std::lock_guard lock(mutex_);
    const double seconds = dt.seconds();
    if (!(seconds > 0)) return false;
    const JointLimits& hard = joint_limits_[0];
    const SoftJointLimits soft = soft_joint_limits_.empty() ? SoftJointLimits{} : soft_joint_limits_[0];
    detail::begin_with(actual, desired, prev_command_);
    const double previous = finite_or(prev_command_.position, actual.position);
    VelocityLimits speed =
        soft_velocities(hard, soft, finite_or(actual.position, prev_command_.position), previous);
    bool out = limit_position(hard, soft, actual, desired, speed, previous, seconds);
    out = limit_velocity(hard, actual, desired, speed, seconds) || out;
    out = limit_effort(hard, soft, actual, desired, speed, seconds) || out;
    out = detail::clamp_acceleration_and_jerk(hard, actual, desired) || out;
    update_prev_command(desired, prev_command_);
    return out;
  }

 private:
  static constexpr double kBackSpeed = 3.14159265358979323846 / 180;  ///< from outside of the soft limits

  static double finite_or(const std::optional<double>& first, const std::optional<double>& second) {
    if (first && std::isfinite(*first)) return *first;
    return second.value_or(internal::kInfinity);
  }
  VelocityLimits soft_velocities(const JointLimits& hard, const SoftJointLimits& soft, double position,
                                 double previous) const {
    if (!hard.has_velocity_limits) return {-internal::kInfinity, internal::kInfinity};
    const double most = hard.max_velocity;
    if (!hard.has_position_limits || !has_soft_limits(soft) || !std::isfinite(previous)) return {-most, most};
    VelocityLimits out(std::clamp(-soft.k_position * (previous - soft.min_position), -most, most),
                       std::clamp(-soft.k_position * (previous - soft.max_position), -most, most));
    if (std::isfinite(position) && internal::beyond(hard, position) > internal::POSITION_BOUNDS_TOLERANCE)
      return {0.0, 0.0};
    if (position < soft.min_position || position > soft.max_position)
      return {std::copysign(kBackSpeed, out.lower_limit), std::copysign(kBackSpeed, out.upper_limit)};
    return out;
  }
  bool limit_position(const JointLimits& hard, const SoftJointLimits& soft,
                      const JointControlInterfacesData& actual, JointControlInterfacesData& desired,
                      const VelocityLimits& speed, double previous, double dt) const {
    if (!internal::is_number(desired.position)) return false;
    const PositionLimits reach = compute_position_limits(joint_names_[0], hard, actual.velocity,
                                                         actual.position, prev_command_.position, dt);
    PositionLimits range(-internal::kInfinity, internal::kInfinity);
    if (has_soft_position_limits(soft)) range = PositionLimits(soft.min_position, soft.max_position);
    if (hard.has_velocity_limits && std::isfinite(previous)) {
      range.lower_limit = std::clamp(previous + speed.lower_limit * dt, range.lower_limit, range.upper_limit);
      range.upper_limit = std::clamp(previous + speed.upper_limit * dt, range.lower_limit, range.upper_limit);
    }
    const double lower = std::max(range.lower_limit, reach.lower_limit),
                 upper = std::min(range.upper_limit, reach.upper_limit);
    if (lower > upper)  // the joint is far outside its soft limits: these count
      return detail::clamp_command(desired.position, range.lower_limit, range.upper_limit);
    return detail::clamp_command(desired.position, lower, upper);
  }
  bool limit_velocity(const JointLimits& hard, const JointControlInterfacesData& actual,
                      JointControlInterfacesData& desired, VelocityLimits& speed, double dt) const {
    if (!internal::is_number(desired.velocity)) return false;
    const VelocityLimits range = compute_velocity_limits(joint_names_[0], hard, *desired.velocity,
                                                         actual.position, prev_command_.velocity, dt);
    if (hard.has_velocity_limits && hard.has_acceleration_limits && actual.velocity) {
      const double change = hard.max_acceleration * dt;
      speed.lower_limit = std::max(*actual.velocity - change, speed.lower_limit);
      speed.upper_limit = std::min(*actual.velocity + change, speed.upper_limit);
    }
    speed.lower_limit = std::max(speed.lower_limit, range.lower_limit);
    speed.upper_limit = std::min(speed.upper_limit, range.upper_limit);
    return detail::clamp_command(desired.velocity, speed.lower_limit, speed.upper_limit);
  }
  bool limit_effort(const JointLimits& hard, const SoftJointLimits& soft,
                    const JointControlInterfacesData& actual, JointControlInterfacesData& desired,
                    const VelocityLimits& speed, double dt) const {
    if (!internal::is_number(desired.effort)) return false;
    EffortLimits range = compute_effort_limits(hard, actual.position, actual.velocity, dt);
    if (hard.has_effort_limits && std::isfinite(soft.k_velocity) && actual.velocity) {
      const auto towards = [&](double limit) {
        return std::clamp(-soft.k_velocity * (*actual.velocity - limit), -hard.max_effort, hard.max_effort);
      };
      range.lower_limit = std::max(towards(speed.lower_limit), range.lower_limit);
      range.upper_limit = std::min(towards(speed.upper_limit), range.upper_limit);
    }
    return detail::clamp_command(desired.effort, range.lower_limit, range.upper_limit);
  }
};

}  // namespace joint_limits
