#pragma once
/// States and transitions of life cycles as lifecycle_msgs numbers them.
#include <string>

#include "polyarm/hardware/component.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

/// {id, label} of lifecycle_msgs/State.
Json state_json(const std::string& label);
/// The state that a lifecycle_msgs/State names, by its id or, where that is 0, by its label; "" where none.
std::string state_label(const Json& state);

/// get_state, change_state, get_available_states and get_available_transitions of a controller.
void offer_life_cycle(Bridge& bridge, const std::string& node, const std::string& controller);

}  // namespace polyarm::ros2
