#pragma once
/// The force/torque sensors that physics measures. Standard types only.
#include <algorithm>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::hardware {

/// The link at whose joint physics measures this `<sensor>` of a <ros2_control>: it has the state `force.x`
/// and names the link, which is not the root, as `frame_id`. -1: physics does not measure it.
inline int force_sensor_link(const description::RobotModel& model,
                             const description::ComponentInfo& component) {
  const auto frame = component.parameters.find("frame_id");
  const bool measures = std::any_of(component.state_interfaces.begin(), component.state_interfaces.end(),
                                    [](const auto& state) { return state.name == "force.x"; });
  if (component.kind != "sensor" || !measures || frame == component.parameters.end()) return -1;
  const int link = model.find_link(frame->second);
  return link == model.root ? -1 : link;
}

}  // namespace polyarm::hardware
