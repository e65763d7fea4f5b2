#pragma once
#include <stdexcept>

#include "rclcpp/serialized_message.hpp"

namespace rclcpp {
/// For messages that were made from a definition.
template <typename Message>
class Serialization {
 public:
  void serialize_message(const void* from, SerializedMessage* to) const {
    to->polyarm_payload().clear();
    polyarm_ros::encode(*static_cast<const Message*>(from), to->polyarm_payload());
  }
  void deserialize_message(const SerializedMessage* from, void* to) const {
    if (!polyarm_ros::decode(from->polyarm_payload(), *static_cast<Message*>(to)))
      throw std::runtime_error("failed to deserialize ROS message: the payload is not of this type");
  }
};
}  // namespace rclcpp
