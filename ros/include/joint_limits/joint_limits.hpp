#pragma once
/// Limits of a joint: SI units; NaN where nothing is stated.
#include <limits>
#include <string>

#include "polyarm_ros/standard.hpp"

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

  std::string to_string() const {
    const auto text = [](const char* name, bool has, double value) {
      return std::string("  ") + name + ": " + (has ? std::to_string(value) : "none") + "\n";
    };
    return text("min position", has_position_limits, min_position) +
           text("max position", has_position_limits, max_position) +
           text("max velocity", has_velocity_limits, max_velocity) +
           text("max acceleration", has_acceleration_limits, max_acceleration) +
           text("max deceleration", has_deceleration_limits, max_deceleration) +
           text("max jerk", has_jerk_limits, max_jerk) + text("max effort", has_effort_limits, max_effort) +
           "  angle wraparound: " + (angle_wraparound ? "true" : "false");
  }
  void disable_all_limits() {
    has_position_limits = has_velocity_limits = has_acceleration_limits = false;
    has_deceleration_limits = has_jerk_limits = has_effort_limits = angle_wraparound = false;
  }
};
struct SoftJointLimits {
  double min_position = std::numeric_limits<double>::quiet_NaN(),
         max_position = std::numeric_limits<double>::quiet_NaN();
  double k_position = std::numeric_limits<double>::quiet_NaN(),
         k_velocity = std::numeric_limits<double>::quiet_NaN();
  bool has_soft_limits() const { return min_position == min_position && max_position == max_position; }
};

}  // namespace joint_limits
