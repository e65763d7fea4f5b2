#include <algorithm>
#include <map>
#include <set>

#include "polyarm/base/text.hpp"
#include "polyarm/description/ros2_control_reader.hpp"
#include "polyarm/description/suggestions.hpp"

namespace polyarm::description {

namespace {

/// Checks the hardware of a robot. A fault that some release of ROS 2 accepts is repaired with a warning, so
/// that the rest of the robot works. Any other fault is a problem.
class HardwareCheck {
 public:
  HardwareCheck(const RobotModel& model, Problems& problems, Problems& warnings)
      : model_(model), problems_(problems), warnings_(warnings) {
    for (const Joint& joint : model.joints)
      if (joint.moves()) joints_.push_back(joint.name);
  }

  void block(HardwareInfo& hardware) {
    name(hardware);
    std::erase_if(hardware.components, [&](const ComponentInfo& component) {
      return component.kind == "joint" && !component.name.empty() && !can_be_driven(hardware, component);
    });
    for (ComponentInfo& component : hardware.components)
      if (component.kind == "joint") mimic(component);
    join_twice(hardware);
    for (ComponentInfo& component : hardware.components) {
      once(component, component.state_interfaces, "state", states_);
      once(component, component.command_interfaces, "command", commands_);
    }
    shape(hardware);
    for (const TransmissionInfo& t : hardware.transmissions) transmission(hardware, t);
  }

  /// A component that is named twice is one with the interfaces and parameters of both, as in Humble, which
  /// accepts it. What both have counts as the first says.
  void join_twice(HardwareInfo& hardware) {
    std::vector<ComponentInfo> out;
    for (ComponentInfo& component : hardware.components) {
      const auto first = std::find_if(out.begin(), out.end(), [&](const ComponentInfo& other) {
        return !component.name.empty() && other.kind == component.kind && other.name == component.name;
      });
      if (first == out.end()) {
        out.push_back(std::move(component));
        continue;
      }
      warnings_.warning("duplicate-name", component.where,
                        "'" + hardware.name + "' has two of <" + component.kind + " name=\"" +
                            component.name + "\">; they are taken as one",
                        "put their interfaces into one");
      add_new(component.command_interfaces, first->command_interfaces);
      add_new(component.state_interfaces, first->state_interfaces);
      first->parameters.insert(component.parameters.begin(), component.parameters.end());
    }
    hardware.components = std::move(out);
  }
  static void add_new(const std::vector<InterfaceInfo>& from, std::vector<InterfaceInfo>& to) {
    for (const InterfaceInfo& interface : from)
      if (std::none_of(to.begin(), to.end(),
                       [&](const InterfaceInfo& other) { return other.name == interface.name; }))
        to.push_back(interface);
  }

  void transmission_of_robot(const TransmissionInfo& t) {
    for (const TransmissionEnd& end : t.joints)
      if (model_.find_joint(end.name) < 0)
        warnings_.warning("unknown-joint", t.where,
                          "the transmission '" + t.name + "' names the joint '" + end.name +
                              "', which the robot does not have" + suggest_(end.name, joints_));
  }

 private:
  using Owners = std::map<std::string, std::string>;

  /// Ensures that every interface exists once. If a <sensor> and a <gpio> with the same name, or two blocks,
  /// name the same interface, the first one counts.
  void once(const ComponentInfo& component, std::vector<InterfaceInfo>& interfaces, const std::string& kind,
            Owners& owners) {
    std::erase_if(interfaces, [&](const InterfaceInfo& interface) {
      if (component.name.empty() || interface.name.empty()) return false;
      const std::string name = component.name + "/" + interface.name;
      const std::string owner =
          "the <" + component.kind + "> of line " + std::to_string(component.where.line);
      const auto [first, is_new] = owners.emplace(name, owner);
      if (is_new) return false;
      warnings_.warning("duplicate-name", interface.where,
                        "the " + kind + " interface '" + name + "' of this <" + component.kind +
                            "> exists already in " + first->second + "; the first counts",
                        "remove one of them, or rename the <" + component.kind + ">");
      return true;
    });
  }

  /// Ensures that every block has a unique name.
  void name(HardwareInfo& hardware) {
    const std::string given = hardware.name;
    std::string wanted = !given.empty() ? given : model_.name.empty() ? "hardware" : model_.name;
    const std::string base = wanted;
    for (int& next = next_name_.try_emplace(base, 2).first->second; !blocks_.insert(wanted).second; ++next)
      wanted = base + "_" + std::to_string(next);
    hardware.name = wanted;
    if (given.empty())
      warnings_.warning("missing-attribute", hardware.where,
                        "a <ros2_control> has no name; it is called '" + wanted + "'",
                        "write name=\"" + wanted + "\"");
    else if (wanted != given)
      warnings_.warning(
          "duplicate-name", hardware.where,
          "two <ros2_control> are called '" + given + "'; the second is called '" + wanted + "' here",
          "rename one of them");
  }

  bool can_be_driven(const HardwareInfo& hardware, const ComponentInfo& component) {
    const int found = model_.find_joint(component.name);
    const std::string names =
        "<ros2_control> '" + hardware.name + "' names the joint '" + component.name + "'";
    if (found < 0)
      warnings_.warning("unknown-joint", component.where,
                        names + ", which the robot does not have" + suggest_(component.name, joints_) +
                            "; it is left out",
                        "write the name of a <joint> of the robot");
    else if (!model_.joints[static_cast<std::size_t>(found)].moves())
      warnings_.warning("fixed-joint", component.where,
                        names + ", which is fixed and has nothing to read or command; it is left out",
                        "remove it here, or give the robot's joint another type");
    else
      return true;
    return false;
  }

  void mimic(ComponentInfo& component) {
    const int found = model_.find_joint(component.name);
    if (found < 0) return;  // it has no name, which is reported elsewhere
    const Joint& joint = model_.joints[static_cast<std::size_t>(found)];
    if (component.mimic.value_or(false) && !joint.mimic) {
      warnings_.warning(
          "no-mimic", component.where,
          "'" + component.name +
              "' has mimic=\"true\", but the robot's joint follows no other joint; this is ignored",
          "write <mimic joint=\"…\"/> into the robot's <joint>, or remove the attribute");
      component.mimic.reset();
    }
    if (joint.mimic && component.mimic.value_or(true) && !component.command_interfaces.empty()) {
      warnings_.warning("mimic-commanded", component.command_interfaces.front().where,
                        "'" + component.name + "' follows another joint; its command interfaces are ignored",
                        "remove them, or write mimic=\"false\" to command it on its own");
      component.command_interfaces.clear();
    }
    if (component.parameters.contains("mimic") && !joint.mimic)
      warnings_.warning(
          "superseded", component.where,
          "the parameter 'mimic' of '" + component.name + "' has no effect any more",
          "write <mimic joint=\"" + component.parameters.at("mimic") + "\"/> into the robot's <joint>");
  }

  void shape(const HardwareInfo& hardware) {
    const auto joints = std::count_if(hardware.components.begin(), hardware.components.end(),
                                      [](const ComponentInfo& c) { return c.kind == "joint"; });
    if (hardware.type == "actuator" && (joints > 1 || hardware.components.empty()))
      warnings_.warning("bad-type", hardware.where,
                        "the actuator '" + hardware.name + "' has " + std::to_string(joints) +
                            " joints, an actuator moves one; it is read as a system",
                        "write type=\"system\", or one <ros2_control> for each joint");
    if (hardware.type != "sensor") return;
    for (const ComponentInfo& c : hardware.components)
      if (!c.command_interfaces.empty())
        warnings_.warning(
            "no-effect", c.command_interfaces.front().where,
            "'" + hardware.name + "' is a sensor: the commands to '" + c.name + "' reach nothing",
            "write type=\"system\" to command it");
  }

  void transmission(const HardwareInfo& hardware, const TransmissionInfo& t) {
    std::vector<std::string> names;
    for (const ComponentInfo& c : hardware.components)
      if (c.kind == "joint") names.push_back(c.name);
    for (const TransmissionEnd& end : t.joints)
      if (std::find(names.begin(), names.end(), end.name) == names.end())
        problems_.error("unknown-joint", t.where,
                        "the transmission '" + t.name + "' moves the joint '" + end.name +
                            "', which its <ros2_control> '" + hardware.name + "' does not have" +
                            suggest_(end.name, names),
                        "add <joint name=\"" + end.name + "\"> to the same <ros2_control>");
  }

  const RobotModel& model_;
  Problems& problems_;
  Problems& warnings_;
  std::vector<std::string> joints_;  ///< names to suggest for unknown joints
  Suggestions suggest_;
  std::map<std::string, int> next_name_;  ///< for each repeated name: the number that makes the next one
                                          ///< unique
  std::set<std::string> blocks_;
  Owners states_, commands_;  ///< "joint/position" and the element that declares it
};

}  // namespace

void check_hardware(RobotModel& model, Problems& problems, Problems& warnings) {
  HardwareCheck check(model, problems, warnings);
  for (HardwareInfo& hardware : model.hardware) check.block(hardware);
  for (const TransmissionInfo& t : model.transmissions) check.transmission_of_robot(t);
}

}  // namespace polyarm::description
