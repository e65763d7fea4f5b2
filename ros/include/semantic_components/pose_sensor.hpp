#pragma once
#include "geometry_msgs/msg/pose.hpp"
#include "semantic_components/semantic_component_interface.hpp"

namespace semantic_components {

class PoseSensor : public SemanticComponentInterface<geometry_msgs::msg::Pose> {
 public:
  explicit PoseSensor(const std::string& name)
      : SemanticComponentInterface(name,
                                   named(name, {"position.x", "position.y", "position.z", "orientation.x",
                                                "orientation.y", "orientation.z", "orientation.w"})) {}
  std::array<double, 3> get_position() const { return {value(0), value(1), value(2)}; }
  std::array<double, 4> get_orientation() const { return {value(3), value(4), value(5), value(6)}; }
  bool get_values_as_message(geometry_msgs::msg::Pose& out) const {
    out.position.x = value(0), out.position.y = value(1), out.position.z = value(2);
    out.orientation.x = value(3), out.orientation.y = value(4), out.orientation.z = value(5);
    out.orientation.w = value(6);
    return true;
  }
};

}  // namespace semantic_components
