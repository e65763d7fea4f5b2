#pragma once
#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "rclcpp/node.hpp"
#include "rclcpp/rclcpp.hpp"
#include "tf2/convert.hpp"
#include "tf2/time.hpp"
#include "tf2_msgs/msg/tf_message.hpp"
#include "tf2_ros/buffer.hpp"

namespace tf2_ros {

/// Publishes on a topic of the node, which may be a node, a pointer to one, or one of its views. A view has
/// no topics: then it sends to nobody.
class TransformSender {
 public:
  using Message = tf2_msgs::msg::TFMessage;
  using Transform = geometry_msgs::msg::TransformStamped;

  template <typename Node>
  TransformSender(Node&& node, const char* topic, const rclcpp::QoS& qos) {
    if constexpr (MakesPublishers<std::remove_reference_t<Node>*>::value)
      publisher_ = make(node, topic, qos);
    else if constexpr (MakesPublishers<std::remove_reference_t<Node>>::value)
      publisher_ = make(*node, topic, qos);
  }
  void send(const Message& message) const {
    if (publisher_) publisher_->publish(message);
  }

 private:
  template <typename Pointer, typename = void>
  struct MakesPublishers : std::false_type {};
  template <typename Pointer>
  struct MakesPublishers<Pointer,
                         std::void_t<decltype(std::declval<Pointer>()->template create_publisher<Message>(
                             std::declval<const char*>(), std::declval<const rclcpp::QoS&>()))>>
      : std::true_type {};
  template <typename Node>
  static typename rclcpp::Publisher<Message>::SharedPtr make(Node& node, const char* topic,
                                                             const rclcpp::QoS& qos) {
    return node.template create_publisher<Message>(topic, qos);
  }
  rclcpp::Publisher<Message>::SharedPtr publisher_;
};

class TransformBroadcaster {
 public:
  template <typename Node, typename... Rest>
  explicit TransformBroadcaster(Node&& node, Rest&&...)
      : sender_(std::forward<Node>(node), "/tf", rclcpp::QoS(100)) {}
  void sendTransform(const TransformSender::Transform& transform) {
    sendTransform(std::vector<TransformSender::Transform>{transform});
  }
  void sendTransform(const std::vector<TransformSender::Transform>& transforms) {
    TransformSender::Message message;
    message.transforms = transforms;
    sender_.send(message);
  }

 private:
  TransformSender sender_;
};

/// Sends all that it has, so that those who come later have them too.
class StaticTransformBroadcaster {
 public:
  template <typename Node, typename... Rest>
  explicit StaticTransformBroadcaster(Node&& node, Rest&&...)
      : sender_(std::forward<Node>(node), "/tf_static", rclcpp::QoS(1).transient_local()) {}
  void sendTransform(const TransformSender::Transform& transform) {
    sendTransform(std::vector<TransformSender::Transform>{transform});
  }
  void sendTransform(const std::vector<TransformSender::Transform>& transforms) {
    for (const auto& given : transforms) {
      auto& all = message_.transforms;
      const auto known = std::find_if(all.begin(), all.end(), [&](const TransformSender::Transform& each) {
        return each.child_frame_id == given.child_frame_id;
      });
      if (known == all.end())
        all.push_back(given);
      else
        *known = given;
    }
    sender_.send(message_);
  }

 private:
  TransformSender sender_;
  TransformSender::Message message_;
};

}  // namespace tf2_ros
