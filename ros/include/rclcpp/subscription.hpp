#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "polyarm_ros/door.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/qos.hpp"

namespace rclcpp {

class MessageInfo {};
struct SubscriptionOptions {
  CallbackGroup::SharedPtr callback_group;
  bool use_default_callbacks = true, ignore_local_publications = false;
};

class SubscriptionBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(SubscriptionBase)
  SubscriptionBase(std::string node, std::string topic) : topic_(std::move(topic)) {
    polyarm_ros::say_closed(node, "topic", topic_);
  }
  virtual ~SubscriptionBase() = default;
  const char* get_topic_name() const { return topic_.c_str(); }
  std::size_t get_publisher_count() const { return 0; }

 private:
  std::string topic_;
};

/// Never called.
template <typename Message, typename Allocator = std::allocator<void>>
class Subscription : public SubscriptionBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Subscription<Message, Allocator>)
  using SubscriptionBase::SubscriptionBase;
  bool take(Message&, MessageInfo&) { return false; }
};

}  // namespace rclcpp
