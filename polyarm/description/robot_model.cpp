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

namespace {
/// Initial positions that the hardware of a robot declares, by joint.
std::map<std::string, double> declared_start(const RobotModel& model) {
  std::map<std::string, double> out;
  for (const HardwareInfo& hardware : model.hardware)
    for (const ComponentInfo& component : hardware.components)
      for (const InterfaceInfo& state : component.state_interfaces)
        if (state.name == "position" && state.initial_value) out[component.name] = *state.initial_value;
  return out;
}
}  // namespace

std::vector<double> RobotModel::start() const {
  if (const auto home = named_states.find("home"); home != named_states.end()) return home->second;
  const std::map<std::string, double> declared = declared_start(*this);
  std::vector<double> out;
  for (const int index : actuated) {
    const Joint& joint = joints[static_cast<std::size_t>(index)];
    const auto found = declared.find(joint.name);
    double value = found == declared.end() ? 0.0 : found->second;
    if (joint.limits.upper) value = std::min(value, *joint.limits.upper);
    if (joint.limits.lower) value = std::max(value, *joint.limits.lower);
    out.push_back(value);
  }
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
