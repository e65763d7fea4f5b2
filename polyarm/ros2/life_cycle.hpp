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

/// The five services and `transition_event` of a controller, as nodes with a life cycle have them.
class LifeCycle {
 public:
  LifeCycle(Bridge& bridge, std::string node, std::string controller);
  /// What it is in now: a change is told.
  void look(const std::string& state);

 private:
  void tell(Json event);

  Bridge& bridge_;
  std::string node_, controller_;
  Wire::Id events_ = 0;
  std::string state_;
};

}  // namespace polyarm::ros2
