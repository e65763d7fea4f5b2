#include "two_joints/two_joints.hpp"

#include <cmath>
#include <limits>

#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "rclcpp/rclcpp.hpp"

namespace two_joints {

// In ROS the headers above bring this abs of doubles; the one of C makes an int of them.
static_assert(sizeof(abs(0.5)) == sizeof(double));

using hardware_interface::CallbackReturn;
using hardware_interface::return_type;

CallbackReturn TwoJoints::on_init(const hardware_interface::HardwareInfo& info) {
  if (hardware_interface::SystemInterface::on_init(info) != CallbackReturn::SUCCESS)
    return CallbackReturn::ERROR;
  for (const hardware_interface::ComponentInfo& joint : info_.joints)
    if (joint.command_interfaces.size() != 1 ||
        joint.command_interfaces[0].name != hardware_interface::HW_IF_POSITION) {
      RCLCPP_FATAL(rclcpp::get_logger("TwoJoints"), "joint '%s' needs one position command",
                   joint.name.c_str());
      return CallbackReturn::ERROR;
    }
  positions_.resize(info_.joints.size(), 0.0);
  commands_.resize(info_.joints.size(), std::numeric_limits<double>::quiet_NaN());
  wear_.turns.resize(info_.joints.size());
  if (info_.hardware_parameters.count("throw_at"))
    throw_at_ = std::stol(info_.hardware_parameters["throw_at"]);
  open_topics();
  return CallbackReturn::SUCCESS;
}

void TwoJoints::open_topics() {
  const rclcpp::Node::SharedPtr node = get_node();
  tells_wear_ = std::make_shared<realtime_tools::RealtimePublisher<two_joints::msg::Wear>>(
      node->create_publisher<two_joints::msg::Wear>("~/wear", rclcpp::SystemDefaultsQoS()));
  tells_last_ =
      node->create_publisher<std_msgs::msg::Float64>("/last_turns", rclcpp::QoS(1).transient_local());
  sets_turns_ = node->create_subscription<std_msgs::msg::Float64>(
      "~/set_turns", rclcpp::SensorDataQoS(), [this](const std_msgs::msg::Float64::SharedPtr message) {
        set_turns_ = message->data;
        tells_last_->publish(*message);
      });
  resets_ = node->create_service<std_srvs::srv::Trigger>(
      "~/reset", [this](const std::shared_ptr<std_srvs::srv::Trigger::Request>,
                        std::shared_ptr<std_srvs::srv::Trigger::Response> response) {
        set_turns_ = 0;
        response->success = true;
        response->message = "as new";
      });
}

std::vector<hardware_interface::StateInterface> TwoJoints::export_state_interfaces() {
  std::vector<hardware_interface::StateInterface> out;
  for (size_t i = 0; i < info_.joints.size(); i++)
    out.emplace_back(hardware_interface::StateInterface(info_.joints[i].name,
                                                        hardware_interface::HW_IF_POSITION, &positions_[i]));
  return out;
}

std::vector<hardware_interface::CommandInterface> TwoJoints::export_command_interfaces() {
  std::vector<hardware_interface::CommandInterface> out;
  for (size_t i = 0; i < info_.joints.size(); i++)
    out.emplace_back(info_.joints[i].name, hardware_interface::HW_IF_POSITION, &commands_[i]);
  return out;
}

CallbackReturn TwoJoints::on_activate(const rclcpp_lifecycle::State&) {
  commands_ = positions_;
  RCLCPP_INFO(rclcpp::get_logger("TwoJoints"), "two joints are active");
  return CallbackReturn::SUCCESS;
}

return_type TwoJoints::read(const rclcpp::Time&, const rclcpp::Duration&) {
  if (throw_at_ >= 0 && cycles_ > throw_at_) throw std::runtime_error("the cable of two joints is cut");
  for (size_t i = 0; i < positions_.size(); i++) {
    wear_.turns[i] += std::abs(commands_[i] - positions_[i]) / 2;
    positions_[i] += (commands_[i] - positions_[i]) / 2;
  }
  const double given = set_turns_.exchange(std::numeric_limits<double>::quiet_NaN());
  if (!std::isnan(given)) wear_.turns.assign(wear_.turns.size(), given);
  wear_.state = wear_.turns[0] > 1 ? two_joints::msg::Wear::WORN : two_joints::msg::Wear::NEW;
  tells_wear_->try_publish(wear_);
  return return_type::OK;
}

return_type TwoJoints::write(const rclcpp::Time&, const rclcpp::Duration&) {
  ++cycles_;
  return return_type::OK;
}

}  // namespace two_joints

#include "pluginlib/class_list_macros.hpp"

PLUGINLIB_EXPORT_CLASS(two_joints::TwoJoints, hardware_interface::SystemInterface)
