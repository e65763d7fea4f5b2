#pragma once
/// Life cycles of controllers for ROS 2: states and transitions with the numbers of lifecycle_msgs.
#include <string>

#include "polyarm/hardware/component.hpp"
#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

/// {id, label} of a lifecycle_msgs/State.
Json state_json(const std::string& label);
/// The label of a lifecycle_msgs/State, from its id or, if that is 0, its label; "" if unknown.
std::string state_label(const Json& state);

/// The five services and `transition_event` of a controller, as lifecycle nodes have them.
class LifeCycle {
 public:
  LifeCycle(Bridge& bridge, std::string node, std::string controller);
  /// Updates the current state; publishes an event if it changed.
  void look(const std::string& state);

 private:
  void tell(Json event);

  Bridge& bridge_;
  std::string node_, controller_;
  Wire::Id events_ = 0;
  std::string state_;
};

}  // namespace polyarm::ros2
