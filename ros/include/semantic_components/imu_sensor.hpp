#pragma once
#include "semantic_components/semantic_component_interface.hpp"
#include "sensor_msgs/msg/imu.hpp"

namespace semantic_components {

class IMUSensor : public SemanticComponentInterface<sensor_msgs::msg::Imu> {
 public:
  explicit IMUSensor(const std::string& name)
      : SemanticComponentInterface(
            name, named(name, {"orientation.x", "orientation.y", "orientation.z", "orientation.w",
                               "angular_velocity.x", "angular_velocity.y", "angular_velocity.z",
                               "linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"})) {}
  std::array<double, 4> get_orientation() const { return {value(0), value(1), value(2), value(3)}; }
  std::array<double, 3> get_angular_velocity() const { return {value(4), value(5), value(6)}; }
  std::array<double, 3> get_linear_acceleration() const { return {value(7), value(8), value(9)}; }
  bool get_values_as_message(sensor_msgs::msg::Imu& out) const {
    out.orientation.x = value(0), out.orientation.y = value(1), out.orientation.z = value(2);
    out.orientation.w = value(3);
    out.angular_velocity.x = value(4), out.angular_velocity.y = value(5), out.angular_velocity.z = value(6);
    out.linear_acceleration.x = value(7), out.linear_acceleration.y = value(8);
    out.linear_acceleration.z = value(9);
    return true;
  }
};

}  // namespace semantic_components
