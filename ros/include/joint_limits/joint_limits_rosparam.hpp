#pragma once
/// Limits of joints from parameters `joint_limits.JOINT.…` of a node.
#include <string>
#include <type_traits>
#include <vector>

#include "joint_limits/joint_limits.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/node.hpp"
#include "rclcpp/node_interfaces/node_interfaces.hpp"
#include "rclcpp_lifecycle/lifecycle_node.hpp"

namespace joint_limits {
using ParametersOfNode = rclcpp::node_interfaces::NodeParametersInterface::SharedPtr;
using LoggingOfNode = rclcpp::node_interfaces::NodeLoggingInterface::SharedPtr;

namespace detail {
/// Calls `visit(name, value)` for each parameter of limits.
template <typename Visit>
void each_limit(JointLimits& l, Visit&& visit) {
  visit("has_position_limits", l.has_position_limits), visit("min_position", l.min_position);
  visit("max_position", l.max_position), visit("has_velocity_limits", l.has_velocity_limits);
  visit("max_velocity", l.max_velocity), visit("has_acceleration_limits", l.has_acceleration_limits);
  visit("max_acceleration", l.max_acceleration), visit("has_deceleration_limits", l.has_deceleration_limits);
  visit("max_deceleration", l.max_deceleration), visit("has_jerk_limits", l.has_jerk_limits);
  visit("max_jerk", l.max_jerk), visit("has_effort_limits", l.has_effort_limits);
  visit("max_effort", l.max_effort), visit("angle_wraparound", l.angle_wraparound);
}
inline std::string prefix_of(const std::string& joint) {
  return "joint_limits." + joint + ".";
}
template <typename T>
void declare_once(rclcpp::node_interfaces::NodeCore& node, const std::string& name, const T& value) {
  if (!node.has_parameter(name)) node.declare_parameter(name, rclcpp::ParameterValue(value));
}
/// A limit counts only if it has a value.
inline void drop_without_value(JointLimits& limits) {
  const auto stated = [](double value) { return value == value; };
  limits.has_position_limits =
      limits.has_position_limits && stated(limits.min_position) && stated(limits.max_position);
  limits.has_velocity_limits = limits.has_velocity_limits && stated(limits.max_velocity);
  limits.has_acceleration_limits = limits.has_acceleration_limits && stated(limits.max_acceleration);
  limits.has_deceleration_limits = limits.has_deceleration_limits && stated(limits.max_deceleration);
  limits.has_jerk_limits = limits.has_jerk_limits && stated(limits.max_jerk);
  limits.has_effort_limits = limits.has_effort_limits && stated(limits.max_effort);
}
}  // namespace detail

/// False, with a line in the log, if a parameter has another type.
inline bool declare_parameters(const std::string& joint, const ParametersOfNode& parameters,
                               const LoggingOfNode& logging) {
  JointLimits limits;
  const std::string prefix = detail::prefix_of(joint);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  try {
    detail::each_limit(limits, [&](const char* name, const auto& value) {
      detail::declare_once(*parameters, prefix + name, value);
    });
    detail::declare_once(*parameters, prefix + "has_soft_limits", false);
    for (const char* name : {"k_position", "k_velocity", "soft_lower_limit", "soft_upper_limit"})
      detail::declare_once(*parameters, prefix + name, kNone);
  } catch (const std::exception& e) {
    RCLCPP_ERROR(logging->get_logger(), "%s", e.what());
    return false;
  }
  return true;
}
template <typename NodePointer>
auto declare_parameters(const std::string& joint, const NodePointer& node)
    -> decltype(node->get_node_parameters_interface(), bool()) {
  return declare_parameters(joint, node->get_node_parameters_interface(), node->get_node_logging_interface());
}

/// Takes what is declared. False if nothing of the joint is. A limit counts if its `has_…` is true and it has
/// a value.
inline bool get_joint_limits(const std::string& joint, const ParametersOfNode& parameters,
                             const LoggingOfNode& logging, JointLimits& limits) {
  const std::string prefix = detail::prefix_of(joint);
  bool any = false;
  detail::each_limit(limits, [&](const char* name, auto& value) {
    rclcpp::Parameter found;
    if (!parameters->get_parameter(prefix + name, found)) return;
    any = true;
    value = found.get_value<std::decay_t<decltype(value)>>();
  });
  if (!any)
    RCLCPP_ERROR(logging->get_logger(), "No joint limits specification found for joint '%s' (parameters %s…)",
                 joint.c_str(), prefix.c_str());
  detail::drop_without_value(limits);
  if (limits.has_position_limits) limits.angle_wraparound = false;
  return any;
}
template <typename NodePointer>
auto get_joint_limits(const std::string& joint, const NodePointer& node, JointLimits& limits)
    -> decltype(node->get_node_parameters_interface(), bool()) {
  return get_joint_limits(joint, node->get_node_parameters_interface(), node->get_node_logging_interface(),
                          limits);
}
/// Takes over changed parameters; true if limits changed. A limit whose value is missing stays off.
inline bool check_for_limits_update(const std::string& joint,
                                    const std::vector<rclcpp::Parameter>& parameters,
                                    const LoggingOfNode& logging, JointLimits& limits) {
  const std::string prefix = detail::prefix_of(joint);
  bool changed = false;
  detail::each_limit(limits, [&](const char* name, auto& value) {
    using Value = std::decay_t<decltype(value)>;
    for (const rclcpp::Parameter& each : parameters) {
      if (each.get_name() != prefix + name) continue;
      try {
        const Value next = each.get_value<Value>();
        changed = changed || value != next;
        value = next;
      } catch (const std::exception& e) {
        if (logging) RCLCPP_WARN(logging->get_logger(), "%s", e.what());
      }
    }
  });
  if (changed) detail::drop_without_value(limits);
  return changed;
}
inline bool check_for_limits_update(const std::string& joint,
                                    const std::vector<rclcpp::Parameter>& parameters,
                                    const LoggingOfNode& logging, SoftJointLimits& limits) {
  const std::string prefix = detail::prefix_of(joint);
  bool changed = false;
  try {
    for (const rclcpp::Parameter& each : parameters)
      if (each.get_name() == prefix + "has_soft_limits" && !each.as_bool()) return false;
    const auto take = [&](const rclcpp::Parameter& each, const char* name, double& value) {
      if (each.get_name() != prefix + name) return;
      const double next = each.get_value<double>();
      changed = changed || value != next;
      value = next;
    };
    for (const rclcpp::Parameter& each : parameters) {
      take(each, "k_position", limits.k_position), take(each, "k_velocity", limits.k_velocity);
      take(each, "soft_lower_limit", limits.min_position),
          take(each, "soft_upper_limit", limits.max_position);
    }
  } catch (const std::exception& e) {
    if (logging) RCLCPP_WARN(logging->get_logger(), "%s", e.what());
  }
  return changed;
}
/// Soft limits of the joint; false if it states none.
inline bool get_joint_limits(const std::string& joint, const ParametersOfNode& parameters,
                             const LoggingOfNode&, SoftJointLimits& limits) {
  const std::string prefix = detail::prefix_of(joint);
  rclcpp::Parameter found;
  if (!parameters->get_parameter(prefix + "has_soft_limits", found) || !found.as_bool()) return false;
  const auto take = [&](const char* name, double& value) {
    return parameters->get_parameter(prefix + name, found) && (value = found.get_value<double>(), true);
  };
  return take("k_position", limits.k_position) && take("k_velocity", limits.k_velocity) &&
         take("soft_lower_limit", limits.min_position) && take("soft_upper_limit", limits.max_position);
}
template <typename NodePointer>
auto get_joint_limits(const std::string& joint, const NodePointer& node, SoftJointLimits& limits)
    -> decltype(node->get_node_parameters_interface(), bool()) {
  return get_joint_limits(joint, node->get_node_parameters_interface(), node->get_node_logging_interface(),
                          limits);
}

}  // namespace joint_limits
