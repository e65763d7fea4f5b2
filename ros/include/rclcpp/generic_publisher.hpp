#pragma once
#include <memory>
#include <string>
#include <utility>

#include "rclcpp/publisher.hpp"
#include "rclcpp/serialized_message.hpp"

namespace rclcpp {
/// Publishes payloads of a type that it knows by its name only.
class GenericPublisher : public PublisherBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(GenericPublisher)
  GenericPublisher(std::shared_ptr<polyarm_ros::Speaker> speaker, std::string type)
      : PublisherBase(std::move(speaker)), type_(std::move(type)) {}
  void publish(const SerializedMessage& message) const { hand_on_bytes(type_, message.polyarm_payload()); }
  void publish_as_loaned_msg(const SerializedMessage& message) const { publish(message); }

 private:
  const std::string type_;
};
}  // namespace rclcpp
