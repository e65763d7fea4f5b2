#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "polyarm_ros/door.hpp"
#include "polyarm_ros/wires.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/qos.hpp"
#include "rclcpp/qos_event.hpp"

namespace rclcpp {

struct PublisherOptions {
  PublisherEventCallbacks event_callbacks;
  bool use_default_callbacks = true;
  IntraProcessSetting use_intra_process_comm = IntraProcessSetting::NodeDefault;
  CallbackGroup::SharedPtr callback_group;
  QosOverridingOptions qos_overriding_options;
};
template <typename Allocator>
using PublisherOptionsWithAllocator = PublisherOptions;

class PublisherBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(PublisherBase)
  explicit PublisherBase(std::shared_ptr<polyarm_ros::Speaker> speaker) : speaker_(std::move(speaker)) {}
  virtual ~PublisherBase() = default;
  const char* get_topic_name() const { return speaker_->topic.c_str(); }
  std::size_t get_subscription_count() const {
    return (speaker_->take ? 1u : 0u) + static_cast<std::size_t>(speaker_->on->listeners.load()) +
           (speaker_->port ? speaker_->port->peers.load() : 0u);
  }
  std::size_t get_intra_process_subscription_count() const { return 0; }
  bool assert_liveliness() const { return true; }

 protected:
  template <typename Message>
  void hand_on(const Message& message) const {
    if (speaker_->take) speaker_->take(&message);
    speaker_->on->send(message);
    if (speaker_->port) polyarm_ros::send_on(*speaker_->port, message);
  }

  void hand_on_bytes(const std::string& type, const polyarm_ros::Payload& payload) const {
    speaker_->on->send_bytes(type, payload);
    if (speaker_->port)
      polyarm_ros::fill_on(*speaker_->port, [&](polyarm_ros::Payload& out) { out = payload; });
  }

 private:
  std::shared_ptr<polyarm_ros::Speaker> speaker_;
};

template <typename Message>
class LoanedMessage {
 public:
  Message& get() { return message_; }
  bool is_valid() const { return true; }

 private:
  Message message_;
};

/// Publishes to the wrapper of a controller, to subscriptions of the same module and to the ROS 2 graph.
/// Without these it allocates nothing and waits for nothing.
template <typename Message, typename Allocator = std::allocator<void>>
class Publisher : public PublisherBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Publisher<Message, Allocator>)
  using PublisherBase::PublisherBase;
  using MessageType = Message;
  virtual void publish(const Message& message) { hand_on(message); }
  virtual void publish(std::unique_ptr<Message> message) { hand_on(*message); }
  virtual void publish(LoanedMessage<Message>&& message) { hand_on(message.get()); }
  LoanedMessage<Message> borrow_loaned_message() { return {}; }
  bool can_loan_messages() const { return false; }
  virtual void on_activate() {}
  virtual void on_deactivate() {}
  bool is_activated() const { return true; }
};

}  // namespace rclcpp
