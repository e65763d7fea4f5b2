#pragma once
#include "semantic_components/semantic_component_command_interface.hpp"
#include "std_msgs/msg/color_rgba.hpp"

namespace semantic_components {

class LedRgbDevice : public SemanticComponentCommandInterface<std_msgs::msg::ColorRGBA> {
 public:
  LedRgbDevice(const std::string& name, const std::string& r, const std::string& g, const std::string& b)
      : SemanticComponentCommandInterface(name, {name + "/" + r, name + "/" + g, name + "/" + b}) {}
  bool set_values_from_message(const std_msgs::msg::ColorRGBA& message) override {
    const float all[] = {message.r, message.g, message.b};
    for (const float each : all)
      if (each < 0 || each > 1) return false;
    for (std::size_t i = 0; i < 3; ++i)
      command_interfaces_[i].get().set_value(static_cast<double>(all[i]));
    return true;
  }
};

}  // namespace semantic_components
