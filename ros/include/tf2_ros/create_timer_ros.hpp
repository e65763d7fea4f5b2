#pragma once
/// A buffer waits by itself here: what gives it timers in ROS does nothing.
#include "tf2_ros/buffer.hpp"

namespace tf2_ros {
class CreateTimerInterface {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(CreateTimerInterface)
};
class CreateTimerROS : public CreateTimerInterface {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(CreateTimerROS)
  template <typename... Interfaces>
  explicit CreateTimerROS(const Interfaces&...) {}
};
}  // namespace tf2_ros
