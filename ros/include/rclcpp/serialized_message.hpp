#pragma once
/// A message as a payload (CDR).
#include <cstddef>
#include <cstdint>
#include <utility>

#include "polyarm_ros/cdr.hpp"
#include "rclcpp/macros.hpp"

struct rcl_serialized_message_t {
  std::uint8_t* buffer = nullptr;
  std::size_t buffer_length = 0, buffer_capacity = 0;
};
using rmw_serialized_message_t = rcl_serialized_message_t;

namespace rclcpp {
class SerializedMessage {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(SerializedMessage)
  SerializedMessage() = default;
  explicit SerializedMessage(std::size_t capacity) { payload_.reserve(capacity); }
  std::size_t size() const { return payload_.size(); }
  std::size_t capacity() const { return payload_.capacity(); }
  void reserve(std::size_t capacity) { payload_.reserve(capacity); }
  /// The bytes, to read or to overwrite; valid until the message changes.
  rcl_serialized_message_t& get_rcl_serialized_message() {
    return view_ = {payload_.data(), payload_.size(), payload_.capacity()}, view_;
  }
  const rcl_serialized_message_t& get_rcl_serialized_message() const {
    return const_cast<SerializedMessage*>(this)->get_rcl_serialized_message();
  }
  polyarm_ros::Payload& polyarm_payload() { return payload_; }
  const polyarm_ros::Payload& polyarm_payload() const { return payload_; }

 private:
  polyarm_ros::Payload payload_;
  rcl_serialized_message_t view_;
};
}  // namespace rclcpp
