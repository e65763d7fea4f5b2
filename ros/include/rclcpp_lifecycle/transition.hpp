#pragma once
#include <cstdint>
#include <string>
#include <utility>

#include "rclcpp_lifecycle/state.hpp"

namespace rclcpp_lifecycle {
class Transition {
 public:
  Transition(std::uint8_t id, std::string label = "")
      : id_(id), label_(std::move(label)) {}  // NOLINT: as in ROS
  std::uint8_t id() const { return id_; }
  std::string label() const { return label_; }

 private:
  std::uint8_t id_;
  std::string label_;
};
}  // namespace rclcpp_lifecycle
