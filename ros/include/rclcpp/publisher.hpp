#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "polyarm_ros/door.hpp"
#include "rclcpp/callback_group.hpp"
#include "rclcpp/qos.hpp"

namespace rclcpp {

struct PublisherOptions {
  CallbackGroup::SharedPtr callback_group;
  bool use_default_callbacks = true;
};
template <typename Allocator>
using PublisherOptionsWithAllocator = PublisherOptions;

class PublisherBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(PublisherBase)
  PublisherBase(std::string node, std::string topic) : topic_(std::move(topic)) {
    polyarm_ros::say_closed(node, "topic", topic_);
  }
  virtual ~PublisherBase() = default;
  const char* get_topic_name() const { return topic_.c_str(); }
  std::size_t get_subscription_count() const { return 0; }
  std::size_t get_intra_process_subscription_count() const { return 0; }
  bool assert_liveliness() const { return true; }

 private:
  std::string topic_;
};

template <typename Message>
class LoanedMessage {
 public:
  Message& get() { return message_; }
  bool is_valid() const { return true; }

 private:
  Message message_;
};

/// Publishes to nobody. Allocates nothing and waits for nothing.
template <typename Message, typename Allocator = std::allocator<void>>
class Publisher : public PublisherBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Publisher<Message, Allocator>)
  using PublisherBase::PublisherBase;
  using MessageType = Message;
  virtual void publish(const Message&) {}
  virtual void publish(std::unique_ptr<Message>) {}
  virtual void publish(LoanedMessage<Message>&&) {}
  LoanedMessage<Message> borrow_loaned_message() { return {}; }
  bool can_loan_messages() const { return false; }
  virtual void on_activate() {}
  virtual void on_deactivate() {}
  bool is_activated() const { return true; }
};

}  // namespace rclcpp
