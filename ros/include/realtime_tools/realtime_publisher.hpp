#pragma once
/// A publisher for real-time code. What takes the messages never waits, so no thread stands between.
#include <memory>
#include <mutex>
#include <utility>

#include "polyarm_ros/standard.hpp"
#include "rclcpp/publisher.hpp"
#include "rclcpp/rclcpp.hpp"

namespace realtime_tools {

template <class Message>
class RealtimePublisher {
 public:
  using PublisherType = rclcpp::Publisher<Message>;
  using PublisherSharedPtr = std::shared_ptr<PublisherType>;
  using MessageType = Message;
  using SharedPtr = std::shared_ptr<RealtimePublisher<Message>>;
  using UniquePtr = std::unique_ptr<RealtimePublisher<Message>>;
  using ConstSharedPtr = std::shared_ptr<const RealtimePublisher<Message>>;
  RealtimePublisher() = default;
  explicit RealtimePublisher(PublisherSharedPtr publisher) : publisher_(std::move(publisher)) {}
  RealtimePublisher(PublisherSharedPtr publisher, const Message& first)
      : msg_(first), publisher_(std::move(publisher)) {}
  Message msg_;
  bool trylock() { return mutex_.try_lock(); }
  bool can_publish() const { return true; }
  bool tryPublish(const Message& message) { return try_publish(message); }
  bool try_publish(const Message& message) {
    if (publisher_) publisher_->publish(message);
    return true;
  }
  void unlockAndPublish() {
    if (publisher_) publisher_->publish(msg_);
    mutex_.unlock();
  }
  void lock() { mutex_.lock(); }
  void unlock() { mutex_.unlock(); }
  void stop() {}
  const Message& get_msg() const { return msg_; }
  std::mutex& get_mutex() { return mutex_; }

 private:
  std::mutex mutex_;
  PublisherSharedPtr publisher_;
};
template <class Message>
using RealtimePublisherSharedPtr = std::shared_ptr<RealtimePublisher<Message>>;

}  // namespace realtime_tools
