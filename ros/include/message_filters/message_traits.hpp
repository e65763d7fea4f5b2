#pragma once
#include <cstdint>
#include <string>
#include <utility>

#include "rclcpp/rclcpp.hpp"
#include "rclcpp/time.hpp"

namespace message_filters::message_traits {

template <typename M, typename = void>
struct HasHeader : std::false_type {};
template <typename M>
struct HasHeader<M, std::void_t<decltype(std::declval<M&>().header)>> : std::true_type {};

/// The stamp of a message's header. Specialize it for messages that have their time elsewhere.
template <typename M, typename = void>
struct TimeStamp {
  static rclcpp::Time value(const M& message) { return rclcpp::Time(message.header.stamp, RCL_ROS_TIME); }
};
template <typename M>
struct FrameId {
  static std::string value(const M& message) { return message.header.frame_id; }
};

}  // namespace message_filters::message_traits
