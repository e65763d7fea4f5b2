#pragma once
/// What Polyarm knows of a <ros2_control> block, in the structs that plugins read.
#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include "hardware_interface/hardware_info.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm_ros/robot_text.hpp"

namespace polyarm_ros {

namespace ros = ::hardware_interface;
namespace own = ::polyarm::description;

inline std::string parameter(const std::map<std::string, std::string>& all, const char* name) {
  const auto found = all.find(name);
  return found == all.end() ? std::string() : found->second;
}

inline ros::InterfaceInfo interface_info(const own::InterfaceInfo& from) {
  ros::InterfaceInfo out;
  out.name = from.name;
  out.min = parameter(from.parameters, "min");
  out.max = parameter(from.parameters, "max");
  out.initial_value = parameter(from.parameters, "initial_value");
  out.data_type = from.data_type;
  out.size = from.size;
  out.enable_limits = from.limits_enabled;
  out.parameters.insert(from.parameters.begin(), from.parameters.end());
  return out;
}

inline ros::ComponentInfo component_info(const own::ComponentInfo& from, const own::RobotModel& model) {
  ros::ComponentInfo out;
  out.name = from.name;
  out.type = from.kind;
  if (from.mimic) out.is_mimic = *from.mimic ? ros::MimicAttribute::TRUE : ros::MimicAttribute::FALSE;
  const int joint = from.kind == "joint" ? model.find_joint(from.name) : -1;
  if (!from.mimic && joint >= 0 && model.joints[static_cast<std::size_t>(joint)].mimic)
    out.is_mimic = ros::MimicAttribute::TRUE;
  for (const own::InterfaceInfo& i : from.command_interfaces)
    out.command_interfaces.push_back(interface_info(i));
  for (const own::InterfaceInfo& i : from.state_interfaces) out.state_interfaces.push_back(interface_info(i));
  out.parameters.insert(from.parameters.begin(), from.parameters.end());
  return out;
}

inline ros::TransmissionInfo transmission_info(const own::TransmissionInfo& from) {
  const auto take_end = [](const own::TransmissionEnd& e, auto& out) {
    out.name = e.name;
    out.role = e.role;
    out.mechanical_reduction = e.reduction;
    out.offset = e.offset;
  };
  ros::TransmissionInfo out;
  out.name = from.name;
  out.type = from.plugin;
  for (const own::TransmissionEnd& e : from.joints) take_end(e, out.joints.emplace_back());
  for (const own::TransmissionEnd& e : from.actuators) take_end(e, out.actuators.emplace_back());
  out.parameters.insert(from.parameters.begin(), from.parameters.end());
  return out;
}

inline joint_limits::JointLimits limits_of(const own::Joint& joint) {
  joint_limits::JointLimits out;
  const auto take = [](const std::optional<double>& value, double& to, bool& has) {
    if (value) to = *value, has = true;
  };
  if (joint.limits.lower && joint.limits.upper && joint.type != own::JointType::continuous) {
    out.min_position = *joint.limits.lower, out.max_position = *joint.limits.upper;
    out.has_position_limits = true;
  }
  take(joint.limits.velocity, out.max_velocity, out.has_velocity_limits);
  take(joint.limits.acceleration, out.max_acceleration, out.has_acceleration_limits);
  take(joint.limits.deceleration, out.max_deceleration, out.has_deceleration_limits);
  take(joint.limits.jerk, out.max_jerk, out.has_jerk_limits);
  take(joint.limits.effort, out.max_effort, out.has_effort_limits);
  out.angle_wraparound = joint.type == own::JointType::continuous;
  return out;
}

/// Interfaces of joints and actuators of transmissions are those of the joint in the block.
inline void fill_transmission_interfaces(ros::HardwareInfo& info) {
  for (ros::TransmissionInfo& transmission : info.transmissions)
    for (ros::JointInfo& end : transmission.joints)
      for (const ros::ComponentInfo& joint : info.joints) {
        if (joint.name != end.name) continue;
        for (const auto& i : joint.state_interfaces) end.state_interfaces.push_back(i.name);
        for (const auto& i : joint.command_interfaces) end.command_interfaces.push_back(i.name);
        for (ros::ActuatorInfo& actuator : transmission.actuators)
          if (transmission.actuators.size() == 1) {
            actuator.state_interfaces = end.state_interfaces;
            actuator.command_interfaces = end.command_interfaces;
          }
      }
}

inline void fill_mimic_joints(const own::RobotModel& model, ros::HardwareInfo& info) {
  for (std::size_t i = 0; i < info.joints.size(); ++i) {
    const int joint = model.find_joint(info.joints[i].name);
    if (joint < 0 || info.joints[i].is_mimic != ros::MimicAttribute::TRUE) continue;
    const auto& mimic = model.joints[static_cast<std::size_t>(joint)].mimic;
    if (!mimic) continue;
    for (std::size_t k = 0; k < info.joints.size(); ++k)
      if (info.joints[k].name == model.joints[static_cast<std::size_t>(mimic->joint)].name)
        info.mimic_joints.push_back({i, k, mimic->multiplier, mimic->offset});
  }
}

/// The block as <ros2_control> has it.
inline std::string block_text(const own::HardwareInfo& block) {
  std::ostringstream out;
  const auto parameters = [&](const std::map<std::string, std::string>& all) {
    for (const auto& [name, value] : all)
      out << "<param name=\"" << xml_text(name) << "\">" << xml_text(value) << "</param>";
  };
  const auto interfaces = [&](const char* tag, const std::vector<own::InterfaceInfo>& all) {
    for (const own::InterfaceInfo& i : all) {
      out << "<" << tag << " name=\"" << xml_text(i.name) << "\">";
      parameters(i.parameters);
      out << "</" << tag << ">";
    }
  };
  out << "<ros2_control name=\"" << xml_text(block.name) << "\" type=\"" << xml_text(block.type)
      << "\"><hardware><plugin>" << xml_text(block.plugin) << "</plugin>";
  parameters(block.parameters);
  out << "</hardware>";
  for (const own::ComponentInfo& component : block.components) {
    out << "<" << component.kind << " name=\"" << xml_text(component.name) << "\">";
    interfaces("command_interface", component.command_interfaces);
    interfaces("state_interface", component.state_interfaces);
    parameters(component.parameters);
    out << "</" << component.kind << ">";
  }
  out << "</ros2_control>";
  return out.str();
}

/// `parameters` are those of the cell, over those of the block.
inline ros::HardwareInfo hardware_info(const own::HardwareInfo& from, const own::RobotModel& model,
                                       const std::map<std::string, std::string>& parameters) {
  ros::HardwareInfo out;
  out.name = from.name;
  out.type = from.type;
  out.group = from.group;
  out.rw_rate = static_cast<unsigned>(from.rw_rate);
  out.is_async = from.is_async;
  if (from.thread_priority > 0) out.thread_priority = out.async_params.thread_priority = from.thread_priority;
  out.async_params.scheduling_policy = from.scheduling_policy;
  out.async_params.cpu_affinity_cores = from.affinity;
  out.async_params.print_warnings = from.print_warnings;
  out.original_xml = robot_text(model, block_text(from));
  out.hardware_plugin_name = out.hardware_class_type = from.plugin;
  out.hardware_parameters.insert(from.parameters.begin(), from.parameters.end());
  for (const auto& [name, value] : parameters) out.hardware_parameters[name] = value;
  for (const own::ComponentInfo& component : from.components) {
    auto& group = component.kind == "joint"    ? out.joints
                  : component.kind == "sensor" ? out.sensors
                                               : out.gpios;
    group.push_back(component_info(component, model));
    const int joint = component.kind == "joint" ? model.find_joint(component.name) : -1;
    if (joint >= 0) out.limits[component.name] = limits_of(model.joints[static_cast<std::size_t>(joint)]);
  }
  for (const own::TransmissionInfo& each : from.transmissions)
    out.transmissions.push_back(transmission_info(each));
  fill_transmission_interfaces(out);
  fill_mimic_joints(model, out);
  return out;
}

}  // namespace polyarm_ros
