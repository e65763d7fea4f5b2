#pragma once
/// For tests of controllers: a transition of the controller's life cycle. True if it succeeded, false if the
/// controller refused it; throws std::runtime_error if it ended in an error. Tests of ros2_controllers
/// compare its words, so these are ROS's.
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "lifecycle_msgs/msg/state.hpp"
#include "rclcpp_lifecycle/node_interfaces/lifecycle_node_interface.hpp"
#include "rclcpp_lifecycle/state.hpp"

namespace controller_interface {

namespace detail {
inline bool reached(const char* function, std::uint8_t before, std::uint8_t after, std::uint8_t wanted) {
  if (after == wanted) return true;
  if (after == before) return false;
  throw std::runtime_error(std::string("Unexpected controller state in ") + function + ": " +
                           std::to_string(after));
}
}  // namespace detail

template <typename T>
bool configure_succeeds(const std::unique_ptr<T>& controller) {
  using State = lifecycle_msgs::msg::State;
  return detail::reached("configure_succeeds", State::PRIMARY_STATE_UNCONFIGURED,
                         controller->configure().id(), State::PRIMARY_STATE_INACTIVE);
}
#define POLYARM_ROS_SUCCEEDS_(TRANSITION, BEFORE, AFTER)                                             \
  template <typename T>                                                                              \
  bool TRANSITION##_succeeds(const std::unique_ptr<T>& controller) {                                 \
    using State = lifecycle_msgs::msg::State;                                                        \
    return detail::reached(#TRANSITION "_succeeds", State::PRIMARY_STATE_##BEFORE,                   \
                           controller->get_node()->TRANSITION().id(), State::PRIMARY_STATE_##AFTER); \
  }
POLYARM_ROS_SUCCEEDS_(activate, INACTIVE, ACTIVE)
POLYARM_ROS_SUCCEEDS_(deactivate, ACTIVE, INACTIVE)
POLYARM_ROS_SUCCEEDS_(cleanup, INACTIVE, UNCONFIGURED)
#undef POLYARM_ROS_SUCCEEDS_
template <typename T>
bool shutdown_succeeds(const std::unique_ptr<T>& controller) {
  const std::uint8_t before = controller->get_node()->get_current_state().id();
  return detail::reached("shutdown_succeeds", before, controller->get_node()->shutdown().id(),
                         lifecycle_msgs::msg::State::PRIMARY_STATE_FINALIZED);
}

}  // namespace controller_interface
