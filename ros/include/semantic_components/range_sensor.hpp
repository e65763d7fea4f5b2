#pragma once
#include "semantic_components/semantic_component_interface.hpp"
#include "sensor_msgs/msg/range.hpp"

namespace semantic_components {

class RangeSensor : public SemanticComponentInterface<sensor_msgs::msg::Range> {
 public:
  explicit RangeSensor(const std::string& name) : SemanticComponentInterface(name, named(name, {"range"})) {}
  float get_range() const { return static_cast<float>(value(0)); }
  bool get_values_as_message(sensor_msgs::msg::Range& out) const { return out.range = get_range(), true; }
};

}  // namespace semantic_components
