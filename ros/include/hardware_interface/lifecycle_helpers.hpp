#pragma once
#include "lifecycle_msgs/msg/state.hpp"

namespace hardware_interface {
/// In these states read and write have nothing to do.
constexpr bool lifecycleStateThatRequiresNoAction(unsigned char state) {
  using State = lifecycle_msgs::msg::State;
  return state == State::PRIMARY_STATE_UNKNOWN || state == State::PRIMARY_STATE_UNCONFIGURED ||
         state == State::PRIMARY_STATE_FINALIZED;
}
}  // namespace hardware_interface
