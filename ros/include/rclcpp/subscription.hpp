#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "polyarm_ros/door.hpp"
#include "polyarm_ros/wires.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/qos.hpp"
#include "rclcpp/qos_event.hpp"

namespace rclcpp {

class MessageInfo {};
struct SubscriptionOptions {
  SubscriptionEventCallbacks event_callbacks;
  bool use_default_callbacks = true, ignore_local_publications = false;
  CallbackGroup::SharedPtr callback_group;
  IntraProcessSetting use_intra_process_comm = IntraProcessSetting::NodeDefault;
  QosOverridingOptions qos_overriding_options;
};
template <typename Allocator>
using SubscriptionOptionsWithAllocator = SubscriptionOptions;

class SubscriptionBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(SubscriptionBase)
  explicit SubscriptionBase(std::shared_ptr<polyarm_ros::Listener> listener)
      : listener_(std::move(listener)) {}
  virtual ~SubscriptionBase() = default;
  const char* get_topic_name() const { return listener_->topic.c_str(); }
  /// True if a message waits for the executor or for take.
  bool has_message() const { return listener_->has_message(); }
  virtual std::shared_ptr<void> create_message() = 0;
  /// Takes the oldest message into one that create_message made.
  virtual bool take_type_erased(void* out, MessageInfo& info) = 0;
  /// Calls the callback with a message that was taken.
  void handle_message(std::shared_ptr<void>& message, const MessageInfo&) {
    listener_->deliver(polyarm_message(message.get()));
  }
  std::size_t get_publisher_count() const { return static_cast<std::size_t>(listener_->publishers()); }

 protected:
  /// What the listener's callback gets for a message of create_message.
  virtual const void* polyarm_message(void* message) const { return message; }
  std::shared_ptr<polyarm_ros::Listener> listener_;
};

/// Called by the wrapper of a controller, and with what nodes of the same module or of the ROS 2 graph
/// publish.
template <typename Message, typename Allocator = std::allocator<void>>
class Subscription : public SubscriptionBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Subscription<Message, Allocator>)
  using SubscriptionBase::SubscriptionBase;
  bool take(Message& out, MessageInfo&) {
    const auto message = this->listener_->next();
    if (message) out = *static_cast<const Message*>(message.get());
    return message != nullptr;
  }
  std::shared_ptr<void> create_message() override { return std::make_shared<Message>(); }
  bool take_type_erased(void* out, MessageInfo& info) override {
    return take(*static_cast<Message*>(out), info);
  }
};

/// Calls a subscription's callback in any of its forms with a copy of the message.
template <typename Message, typename Callback>
void call_with_message(Callback& callback, const Message& message) {
  const MessageInfo info;
  if constexpr (std::is_invocable_v<Callback&, const Message&>)
    callback(message);
  else if constexpr (std::is_invocable_v<Callback&, const Message&, const MessageInfo&>)
    callback(message, info);
  else if constexpr (std::is_invocable_v<Callback&, std::shared_ptr<Message>>)
    callback(std::make_shared<Message>(message));
  else if constexpr (std::is_invocable_v<Callback&, std::shared_ptr<Message>, const MessageInfo&>)
    callback(std::make_shared<Message>(message), info);
  else if constexpr (std::is_invocable_v<Callback&, std::unique_ptr<Message>>)
    callback(std::make_unique<Message>(message));
}

}  // namespace rclcpp
