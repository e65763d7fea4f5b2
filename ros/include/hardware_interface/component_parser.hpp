#pragma once
/// The <ros2_control> blocks of a robot description: names, interfaces and parameters of their parts.
#include <stdexcept>
#include <string>
#include <vector>

#include "hardware_interface/hardware_info.hpp"
#include "urdf/model.hpp"

namespace hardware_interface {

namespace detail {
struct BlockReader {
  std::vector<HardwareInfo> out;
  ComponentInfo* component = nullptr;
  InterfaceInfo* interface = nullptr;
  std::string parameter;  ///< the <param> whose text comes next

  void begin(const urdf::detail::Tag& tag) {
    if (tag.name == "ros2_control") {
      out.emplace_back();
      out.back().name = tag.text("name"), out.back().type = tag.text("type");
    }
    if (out.empty()) return;
    for (auto* group : {&out.back().joints, &out.back().sensors, &out.back().gpios}) {
      const char* kind = group == &out.back().joints ? "joint" : group == &out.back().sensors ? "sensor" : "gpio";
      if (tag.name != kind) continue;
      component = &group->emplace_back();
      component->name = tag.text("name"), component->type = kind;
    }
    if (component && (tag.name == "state_interface" || tag.name == "command_interface")) {
      auto& all = tag.name[0] == 's' ? component->state_interfaces : component->command_interfaces;
      interface = &all.emplace_back();
      interface->name = tag.text("name");
      if (!tag.text("data_type").empty()) interface->data_type = tag.text("data_type");
    }
    parameter = tag.name == "param" ? tag.text("name") : "";
  }
  void end(const std::string& name) {
    if (name == "state_interface" || name == "command_interface") interface = nullptr;
    if (name == "joint" || name == "sensor" || name == "gpio" || name == "ros2_control") component = nullptr;
    parameter.clear();
  }
  void text(const std::string& value) {
    if (parameter.empty() || out.empty()) return;
    if (interface && parameter == "min") interface->min = value;
    if (interface && parameter == "max") interface->max = value;
    if (interface && parameter == "initial_value") interface->initial_value = value;
    auto& all = interface   ? interface->parameters
                : component ? component->parameters
                            : out.back().hardware_parameters;
    all[parameter] = value;
  }
};
}  // namespace detail

/// Throws std::runtime_error if there is no block.
inline std::vector<HardwareInfo> parse_control_resources_from_urdf(const std::string& urdf) {
  detail::BlockReader reader;
  std::size_t at = 0;
  bool inside = false;
  for (std::size_t before = 0; const auto tag = urdf::detail::next_tag(urdf, at); before = at) {
    const std::size_t begin = urdf.rfind('<', at - 1);
    if (tag->name == "ros2_control") inside = !tag->ends;
    if (!inside && tag->name != "ros2_control") continue;
    if (tag->ends) {
      if (begin > before) reader.text(urdf.substr(before, begin - before));
      reader.end(tag->name);
    } else {
      reader.begin(*tag);
      if (tag->empty) reader.end(tag->name);
    }
  }
  if (reader.out.empty()) throw std::runtime_error("the robot description has no <ros2_control>");
  return reader.out;
}

}  // namespace hardware_interface
