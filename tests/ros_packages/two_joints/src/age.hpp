#pragma once
// As packages of ROS have it: headers of ROS bring others, and much of the standard library.
#include "realtime_tools/realtime_publisher.hpp"

namespace two_joints {
class Age {
 public:
  using Told = std::function<void(const std::array<double, 2>&)>;
  void reset(const rclcpp::Time& now) { begin_ = now; }
  rclcpp::Duration since(const rclcpp::Time& now) const { return now - begin_; }

 private:
  rclcpp::Time begin_{0, 0, RCL_ROS_TIME};
};
}  // namespace two_joints
