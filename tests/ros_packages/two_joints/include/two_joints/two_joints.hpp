#pragma once
#include <vector>

#include "hardware_interface/system_interface.hpp"
#include "two_joints/msg/wear.hpp"

namespace two_joints {

class TwoJoints : public hardware_interface::SystemInterface {
 public:
  RCLCPP_SHARED_PTR_DEFINITIONS(TwoJoints)

  hardware_interface::CallbackReturn on_init(const hardware_interface::HardwareInfo& info) override;
  std::vector<hardware_interface::StateInterface> export_state_interfaces() override;
  std::vector<hardware_interface::CommandInterface> export_command_interfaces() override;
  hardware_interface::CallbackReturn on_activate(const rclcpp_lifecycle::State& previous) override;
  hardware_interface::return_type read(const rclcpp::Time& time, const rclcpp::Duration& period) override;
  hardware_interface::return_type write(const rclcpp::Time& time, const rclcpp::Duration& period) override;

 private:
  std::vector<double> positions_, commands_;
  long cycles_ = 0, throw_at_ = -1;
  two_joints::msg::Wear wear_;
};

}  // namespace two_joints
