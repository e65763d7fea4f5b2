#pragma once
/// What limiters exchange: the values of one joint, and ranges. SI units.
#include <limits>
#include <optional>
#include <string>

namespace joint_limits {

struct LimitRange {
  LimitRange(double lower, double upper) : lower_limit(lower), upper_limit(upper) {}
  double lower_limit, upper_limit;
};
struct PositionLimits : LimitRange {
  using LimitRange::LimitRange;
};
struct VelocityLimits : LimitRange {
  using LimitRange::LimitRange;
};
struct EffortLimits : LimitRange {
  using LimitRange::LimitRange;
};
struct AccelerationLimits : LimitRange {
  using LimitRange::LimitRange;
};

struct JointControlInterfacesData {
  std::string joint_name;
  std::optional<double> position, velocity, effort, acceleration, jerk;

  bool has_position() const { return position.has_value(); }
  bool has_velocity() const { return velocity.has_value(); }
  bool has_effort() const { return effort.has_value(); }
  bool has_acceleration() const { return acceleration.has_value(); }
  bool has_jerk() const { return jerk.has_value(); }
  bool has_data() const { return position || velocity || effort || acceleration || jerk; }
  std::string to_string() const {
    std::string out = "Joint: '" + joint_name + "'";
    const auto add = [&out](const char* name, const std::optional<double>& value) {
      if (value) out += std::string(", ") + name + ": " + std::to_string(*value);
    };
    add("position", position), add("velocity", velocity), add("effort", effort);
    add("acceleration", acceleration), add("jerk", jerk);
    return out;
  }
};

struct JointInterfacesCommandLimiterData {
  std::string joint_name;
  JointControlInterfacesData actual, command, prev_command, limited;

  bool has_actual_data() const { return actual.has_data(); }
  bool has_command_data() const { return command.has_data(); }
  bool has_limited_data() const { return limited.has_data(); }
  void set_joint_name(const std::string& name) {
    joint_name = name;
    for (JointControlInterfacesData* each : {&actual, &command, &prev_command, &limited})
      each->joint_name = name;
  }
  std::string to_string() const {
    return "Joint: '" + joint_name + "', (actual: [" + actual.to_string() + "], command: [" +
           command.to_string() + "], limited: [" + limited.to_string() + "])";
  }
};

}  // namespace joint_limits
