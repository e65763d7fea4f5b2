#pragma once
#include "rclcpp/publisher.hpp"

namespace rclcpp_lifecycle {
template <typename Message, typename Allocator = std::allocator<void>>
class LifecyclePublisher : public rclcpp::Publisher<Message, Allocator> {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(LifecyclePublisher<Message, Allocator>)
  using rclcpp::Publisher<Message, Allocator>::Publisher;
};
}  // namespace rclcpp_lifecycle
