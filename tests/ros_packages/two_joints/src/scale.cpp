#include "two_joints/scale.hpp"

#include "pluginlib/class_list_macros.hpp"

namespace two_joints {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;

CallbackReturn Scale::on_init() {
  try {
    listener_ = std::make_shared<ParamListener>(get_node());
  } catch (const std::exception& e) {
    RCLCPP_ERROR(get_node()->get_logger(), "%s", e.what());
    return CallbackReturn::ERROR;
  }
  return CallbackReturn::SUCCESS;
}

InterfaceConfiguration Scale::command_interface_configuration() const {
  InterfaceConfiguration out{interface_configuration_type::INDIVIDUAL, {}};
  for (const std::string& joint : params_.joints) out.names.push_back(joint + "/position");
  return out;
}
InterfaceConfiguration Scale::state_interface_configuration() const {
  return {interface_configuration_type::NONE, {}};
}

CallbackReturn Scale::on_configure(const rclcpp_lifecycle::State&) {
  params_ = listener_->get_params();
  subscription_ = get_node()->create_subscription<std_msgs::msg::Float64MultiArray>(
      "~/commands", rclcpp::SystemDefaultsQoS(),
      [this](const std::shared_ptr<std_msgs::msg::Float64MultiArray> message) {
        if (message->data.size() == params_.joints.size()) sent_.set(message->data);
      });
  RCLCPP_INFO(get_node()->get_logger(), "scales by %.2f", params_.gain);
  return CallbackReturn::SUCCESS;
}
CallbackReturn Scale::on_activate(const rclcpp_lifecycle::State&) {
  sent_.set(Sent());
  return CallbackReturn::SUCCESS;
}

controller_interface::return_type Scale::update(const rclcpp::Time&, const rclcpp::Duration&) {
  listener_->try_update_params(params_);
  sent_.try_get([this](const Sent& sent) {
    for (std::size_t i = 0; i < sent.size(); ++i) {
      const double value = params_.mode == "squared" ? sent[i] * sent[i] : sent[i];
      if (!command_interfaces_[i].set_value(params_.gain * value +
                                            params_.offsets.joints_map.at(params_.joints[i]).value))
        RCLCPP_WARN(get_node()->get_logger(), "no command");
    }
  });
  return controller_interface::return_type::OK;
}

}  // namespace two_joints

PLUGINLIB_EXPORT_CLASS(two_joints::Scale, controller_interface::ControllerInterface)
