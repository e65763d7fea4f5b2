#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "polyarm_ros/standard.hpp"

namespace rclcpp_action {
using GoalUUID = std::array<std::uint8_t, 16>;
enum class GoalResponse : std::int8_t { REJECT = 1, ACCEPT_AND_EXECUTE = 2, ACCEPT_AND_DEFER = 3 };
enum class CancelResponse : std::int8_t { REJECT = 1, ACCEPT = 2 };
inline std::string to_string(const GoalUUID& id) {
  static const char digits[] = "0123456789abcdef";
  std::string out;
  for (const std::uint8_t byte : id) out += digits[byte >> 4], out += digits[byte & 15];
  return out;
}
}  // namespace rclcpp_action
