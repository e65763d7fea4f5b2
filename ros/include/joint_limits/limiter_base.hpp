#pragma once
/// The base of limiters. Limits come from parameters of a node or from the caller. `init` and `configure` are
/// not for the control loop; `enforce` is.
#include <atomic>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "joint_limits/data_structures.hpp"
#include "joint_limits/joint_limits.hpp"
#include "joint_limits/joint_limits_rosparam.hpp"
#include "realtime_tools/realtime_buffer.hpp"
#include "trajectory_msgs/msg/joint_trajectory_point.hpp"

namespace joint_limits {
/// ROS 2 Iron names the kind of limits as the template's argument; its data is a point of a trajectory.
using JointLimitsStateDataType = trajectory_msgs::msg::JointTrajectoryPoint;
namespace detail {
template <typename T>
using LimiterData = std::conditional_t<std::is_same_v<T, JointLimits>, JointLimitsStateDataType, T>;
}  // namespace detail

template <typename Kind>
class JointLimiterInterface {
 public:
  using Data = detail::LimiterData<Kind>;
  JointLimiterInterface() = default;
  virtual ~JointLimiterInterface() = default;
  JointLimiterInterface(const JointLimiterInterface&) = delete;
  JointLimiterInterface& operator=(const JointLimiterInterface&) = delete;

  /// Limits from the node's parameters, which may change while it runs.
  virtual bool init(const std::vector<std::string>& joint_names, const ParametersOfNode& parameters,
                    const LoggingOfNode& logging, const std::string& = "/robot_description") {
    take(joint_names, parameters, logging);
    joint_limits_.assign(number_of_joints_, {});
    if (parameters) {
      for (std::size_t i = 0; i < number_of_joints_; ++i)
        if (!declare_parameters(joint_names[i], parameters, logging) ||
            !get_joint_limits(joint_names[i], parameters, logging, joint_limits_[i]))
          return false;
      follow_parameters();
    }
    updated_limits_.writeFromNonRT(joint_limits_);
    return on_init();
  }
  virtual bool init(const std::vector<std::string>& joint_names, const std::vector<JointLimits>& limits,
                    const std::vector<SoftJointLimits>& soft_limits, const ParametersOfNode& parameters,
                    const LoggingOfNode& logging) {
    take(joint_names, parameters, logging);
    joint_limits_ = limits;
    soft_joint_limits_ = soft_limits;
    updated_limits_.writeFromNonRT(joint_limits_);
    if (limits.size() == joint_names.size()) return on_init();
    if (logging)
      RCLCPP_ERROR(logging->get_logger(), "%zu joints, but limits of %zu", joint_names.size(), limits.size());
    return false;
  }
  template <typename NodePointer>
  auto init(const std::vector<std::string>& joint_names, const NodePointer& node,
            const std::string& topic = "/robot_description")
      -> decltype(node->get_node_parameters_interface(), bool()) {
    return init(joint_names, node->get_node_parameters_interface(), node->get_node_logging_interface(),
                topic);
  }
  virtual bool configure(const Data& current) { return on_configure(current); }
  /// Changes `desired` to what the limits allow in the next `dt`; true if it changed something.
  virtual bool enforce(const Data& current, Data& desired, const rclcpp::Duration& dt) {
    joint_limits_ = *updated_limits_.readFromRT();
    return on_enforce(current, desired, dt);
  }
  virtual void reset_internals() {}

 protected:
  virtual bool on_init() { return true; }
  virtual bool on_configure(const Data&) { return true; }
  virtual bool on_enforce(const Data& current, Data& desired, const rclcpp::Duration& dt) = 0;
  bool has_logging_interface() const { return node_logging_itf_ != nullptr; }
  bool has_parameter_interface() const { return node_param_itf_ != nullptr; }

  std::size_t number_of_joints_ = 0;
  std::vector<std::string> joint_names_;
  std::vector<JointLimits> joint_limits_;
  std::vector<SoftJointLimits> soft_joint_limits_;
  ParametersOfNode node_param_itf_;
  LoggingOfNode node_logging_itf_;

 private:
  void take(const std::vector<std::string>& names, const ParametersOfNode& parameters,
            const LoggingOfNode& logging) {
    number_of_joints_ = names.size();
    joint_names_ = names;
    node_param_itf_ = parameters;
    node_logging_itf_ = logging;
  }
  void follow_parameters() {
    on_change_ = node_param_itf_->add_on_set_parameters_callback(
        [this, known = joint_limits_](const std::vector<rclcpp::Parameter>& changes) mutable {
          bool changed = false;
          for (std::size_t i = 0; i < number_of_joints_; ++i)
            changed =
                check_for_limits_update(joint_names_[i], changes, node_logging_itf_, known[i]) || changed;
          if (changed) updated_limits_.writeFromNonRT(known);
          rcl_interfaces::msg::SetParametersResult out;
          out.successful = true;
          return out;
        });
  }
  std::shared_ptr<rclcpp::node_interfaces::OnSetParametersCallbackHandle> on_change_;
  realtime_tools::RealtimeBuffer<std::vector<JointLimits>> updated_limits_;
};

}  // namespace joint_limits
