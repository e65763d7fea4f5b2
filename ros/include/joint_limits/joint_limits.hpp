#pragma once
/// Limits of a joint: SI units; NaN where nothing is stated.
#include <limits>
#include <string>

namespace joint_limits {

struct JointLimits {
  double min_position = std::numeric_limits<double>::quiet_NaN(),
         max_position = std::numeric_limits<double>::quiet_NaN();
  double max_velocity = std::numeric_limits<double>::quiet_NaN(),
         max_acceleration = std::numeric_limits<double>::quiet_NaN();
  double max_deceleration = std::numeric_limits<double>::quiet_NaN(),
         max_jerk = std::numeric_limits<double>::quiet_NaN();
  double max_effort = std::numeric_limits<double>::quiet_NaN();
  bool has_position_limits = false, has_velocity_limits = false, has_acceleration_limits = false;
  bool has_deceleration_limits = false, has_jerk_limits = false, has_effort_limits = false;
  bool angle_wraparound = false;
};
struct SoftJointLimits {
  double min_position = std::numeric_limits<double>::quiet_NaN(),
         max_position = std::numeric_limits<double>::quiet_NaN();
  double k_position = std::numeric_limits<double>::quiet_NaN(),
         k_velocity = std::numeric_limits<double>::quiet_NaN();
  bool has_soft_limits() const { return min_position == min_position && max_position == max_position; }
};

}  // namespace joint_limits
