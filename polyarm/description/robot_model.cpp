#include "polyarm/description/robot_model.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace polyarm::description {

const char* name(JointType type) {
  constexpr const char* kNames[] = {"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};
  return kNames[static_cast<std::size_t>(type)];
}

const std::vector<std::string>& data_types() {
  static const std::vector<std::string> kTypes{"double", "float32", "bool",   "uint8", "int8",
                                               "uint16", "int16",   "uint32", "int32"};
  return kTypes;
}

std::optional<double> default_value(std::string_view data_type) {
  if (data_type == "double" || data_type == "float32") return std::numeric_limits<double>::quiet_NaN();
  if (data_type == "bool") return 0;
  if (data_type == "uint8") return std::numeric_limits<std::uint8_t>::max();
  if (data_type == "int8") return std::numeric_limits<std::int8_t>::max();
  if (data_type == "uint16") return std::numeric_limits<std::uint16_t>::max();
  if (data_type == "int16") return std::numeric_limits<std::int16_t>::max();
  if (data_type == "uint32") return std::numeric_limits<std::uint32_t>::max();
  if (data_type == "int32") return std::numeric_limits<std::int32_t>::max();
  return std::nullopt;
}

int RobotModel::find_link(std::string_view link) const {
  for (std::size_t i = 0; i < links.size(); ++i)
    if (links[i].name == link) return static_cast<int>(i);
  return -1;
}

int RobotModel::find_joint(std::string_view joint) const {
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (joints[i].name == joint) return static_cast<int>(i);
  return -1;
}

std::vector<std::string> RobotModel::joint_names() const {
  std::vector<std::string> out;
  for (const int joint : actuated) out.push_back(joints[static_cast<std::size_t>(joint)].name);
  return out;
}

std::vector<double> RobotModel::displayed(std::span<const double> q) const {
  std::vector<double> out;
  for (std::size_t i = 0; i < controller_axes.size() && i < q.size(); ++i) {
    const ControllerAxis& axis = controller_axes[i];
    out.push_back(axis.sign * q[i] + axis.offset);
    for (const auto& [joint, factor] : axis.coupling)
      out.back() += factor * q[static_cast<std::size_t>(joint)];
  }
  return out;
}

}  // namespace polyarm::description
