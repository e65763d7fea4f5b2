#pragma once
#include <memory>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "realtime_tools/realtime_thread_safe_box.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"
#include "two_joints/scale_parameters.hpp"

namespace two_joints {

/// Commands positions: gain times what was sent, plus an offset for each joint.
class Scale : public controller_interface::ControllerInterface {
 public:
  controller_interface::CallbackReturn on_init() override;
  controller_interface::InterfaceConfiguration command_interface_configuration() const override;
  controller_interface::InterfaceConfiguration state_interface_configuration() const override;
  controller_interface::CallbackReturn on_configure(const rclcpp_lifecycle::State&) override;
  controller_interface::CallbackReturn on_activate(const rclcpp_lifecycle::State&) override;
  controller_interface::return_type update(const rclcpp::Time&, const rclcpp::Duration&) override;

 private:
  using Sent = std::vector<double>;
  std::shared_ptr<ParamListener> listener_;
  Params params_;
  realtime_tools::RealtimeThreadSafeBox<Sent> sent_;
  rclcpp::Subscription<std_msgs::msg::Float64MultiArray>::SharedPtr subscription_;
};

}  // namespace two_joints
