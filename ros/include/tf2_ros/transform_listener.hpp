#pragma once
#include <atomic>
#include <memory>
#include <thread>

#include "rclcpp/executors.hpp"
#include "rclcpp/rclcpp.hpp"
#include "tf2/convert.hpp"
#include "tf2/time.hpp"
#include "tf2_msgs/msg/tf_message.hpp"
#include "tf2_ros/buffer.hpp"

namespace tf2_ros {

/// Fills a buffer from /tf and /tf_static, by a node and a thread of its own. So a callback of the plugin may
/// wait for a transform.
class TransformListener {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(TransformListener)
  template <typename... Rest>
  explicit TransformListener(tf2::BufferCore& buffer, Rest&&...)
      : node_(std::make_shared<rclcpp::Node>("transform_listener")), buffer_(buffer) {
    moving_ = node_->create_subscription<Message>("/tf", rclcpp::QoS(100),
                                                  [this](const Message& message) { take(message, false); });
    fixed_ = node_->create_subscription<Message>("/tf_static", rclcpp::QoS(100).transient_local(),
                                                 [this](const Message& message) { take(message, true); });
    executor_.add_node(node_);
    thread_ = std::thread([this] {
      while (!ended_) executor_.spin_once(std::chrono::milliseconds(20));
    });
  }
  virtual ~TransformListener() {
    ended_ = true;
    thread_.join();
  }
  TransformListener(const TransformListener&) = delete;
  TransformListener& operator=(const TransformListener&) = delete;

 private:
  using Message = tf2_msgs::msg::TFMessage;
  void take(const Message& message, bool is_static) {
    for (const auto& each : message.transforms) buffer_.setTransform(each, "", is_static);
  }

  std::shared_ptr<rclcpp::Node> node_;
  tf2::BufferCore& buffer_;
  rclcpp::Subscription<Message>::SharedPtr moving_, fixed_;
  rclcpp::executors::SingleThreadedExecutor executor_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};
}  // namespace tf2_ros
