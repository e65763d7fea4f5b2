#pragma once
#include "polyarm_ros/standard.hpp"
#include "rclcpp/macros.hpp"

namespace rclcpp {
enum class CallbackGroupType { MutuallyExclusive, Reentrant };
class CallbackGroup {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(CallbackGroup)
  explicit CallbackGroup(CallbackGroupType type) : type_(type) {}
  CallbackGroupType type() const { return type_; }

 private:
  CallbackGroupType type_;
};
}  // namespace rclcpp
