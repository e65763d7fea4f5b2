#pragma once
#include <string>

#include "rclcpp/node_interfaces/node_interfaces.hpp"
#include "rclcpp/qos.hpp"

namespace rclcpp {
enum class EndpointType { Invalid, Publisher, Subscription };

/// A publisher or subscription of a topic.
class TopicEndpointInfo {
 public:
  explicit TopicEndpointInfo(EndpointType type) : endpoint_type_(type) {}
  EndpointType endpoint_type() const { return endpoint_type_; }
  const std::string& node_name() const { return node_name_; }
  const std::string& node_namespace() const { return node_namespace_; }
  const std::string& topic_type() const { return topic_type_; }
  const QoS& qos_profile() const { return qos_; }

 private:
  EndpointType endpoint_type_;
  std::string node_name_, node_namespace_, topic_type_;
  QoS qos_{10};
};
}  // namespace rclcpp
