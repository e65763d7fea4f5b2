#pragma once
#include <atomic>
#include <limits>
#include <memory>
#include <vector>

#include "hardware_interface/system_interface.hpp"
#include "rclcpp/rclcpp.hpp"
#include "realtime_tools/realtime_publisher.hpp"
#include "std_msgs/msg/float64.hpp"
#include "std_srvs/srv/trigger.hpp"
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
  void open_topics();

  std::vector<double> positions_, commands_;
  long cycles_ = 0, throw_at_ = -1;
  two_joints::msg::Wear wear_;
  std::atomic<double> set_turns_{std::numeric_limits<double>::quiet_NaN()};
  std::shared_ptr<realtime_tools::RealtimePublisher<two_joints::msg::Wear>> tells_wear_;
  rclcpp::Publisher<std_msgs::msg::Float64>::SharedPtr tells_last_;
  rclcpp::Subscription<std_msgs::msg::Float64>::SharedPtr sets_turns_;
  rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr resets_;
};

}  // namespace two_joints
