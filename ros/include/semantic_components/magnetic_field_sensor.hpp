#pragma once
#include "semantic_components/semantic_component_interface.hpp"
#include "sensor_msgs/msg/magnetic_field.hpp"

namespace semantic_components {

class MagneticFieldSensor : public SemanticComponentInterface<sensor_msgs::msg::MagneticField> {
 public:
  explicit MagneticFieldSensor(const std::string& name)
      : SemanticComponentInterface(
            name, named(name, {"magnetic_field.x", "magnetic_field.y", "magnetic_field.z"})) {}
  bool get_values_as_message(sensor_msgs::msg::MagneticField& out) {
    out.magnetic_field.x = value(0), out.magnetic_field.y = value(1), out.magnetic_field.z = value(2);
    return true;
  }
};

}  // namespace semantic_components
