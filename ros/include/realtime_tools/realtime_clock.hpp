#pragma once
#include "polyarm_ros/standard.hpp"
#include "rclcpp/clock.hpp"
namespace realtime_tools {
class RealtimeClock {
 public:
  explicit RealtimeClock(rclcpp::Clock::SharedPtr clock = nullptr) : clock_(std::move(clock)) {}
  rclcpp::Time now(const rclcpp::Time& otherwise) { return clock_ ? clock_->now() : otherwise; }

 private:
  rclcpp::Clock::SharedPtr clock_;
};
}  // namespace realtime_tools
