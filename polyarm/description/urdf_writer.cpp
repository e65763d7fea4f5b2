#include <tinyxml2.h>

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::description {

namespace {

std::string text_of(const Vec3& v) {
  return format_number(v.x) + " " + format_number(v.y) + " " + format_number(v.z);
}

class UrdfWriter {
 public:
  std::string write(const RobotModel& model) {
    xml_.PushHeader(false, true);
    open("robot", {{"name", model.name}});
    for (const Link& link : model.links) write_link(link);
    for (const Joint& joint : model.joints) write_joint(model, joint);
    for (const Link& link : model.links) write_contact(link);
    for (const TransmissionInfo& transmission : model.transmissions) write_robot_transmission(transmission);
    for (const HardwareInfo& hardware : model.hardware) write_hardware(hardware);
    write_facts(model);
    xml_.CloseElement();
    return xml_.CStr();
  }

 private:
  using Attributes = std::vector<std::pair<const char*, std::string>>;
  void open(const char* tag, const Attributes& attributes = {}) {
    xml_.OpenElement(tag);
    for (const auto& [name, value] : attributes) xml_.PushAttribute(name, value.c_str());
  }
  void leaf(const char* tag, const Attributes& attributes) {
    open(tag, attributes);
    xml_.CloseElement();
  }
  void origin(const Pose& pose) {
    if (pose == Pose{}) return;
    leaf("origin", {{"xyz", text_of(pose.position)}, {"rpy", text_of(to_rpy(pose.rotation))}});
  }
  void write_shape(const char* tag, const Shape& s) {
    open(tag);
    origin(s.pose);
    open("geometry");
    switch (s.kind) {
      case ShapeKind::box:
        leaf("box", {{"size", text_of(s.size)}});
        break;
      case ShapeKind::sphere:
        leaf("sphere", {{"radius", format_number(s.radius)}});
        break;
      case ShapeKind::mesh:
        leaf("mesh", {{"filename", s.mesh}, {"scale", text_of(s.scale)}});
        break;
      case ShapeKind::cylinder:
      case ShapeKind::capsule:
        leaf(s.kind == ShapeKind::cylinder ? "cylinder" : "capsule",
             {{"radius", format_number(s.radius)}, {"length", format_number(s.length)}});
    }
    xml_.CloseElement();
    xml_.CloseElement();
  }
  void write_link(const Link& link) {
    open("link", {{"name", link.name}});
    if (link.inertial) {
      const Inertial& i = *link.inertial;
      open("inertial");
      origin({i.center, {}});
      leaf("mass", {{"value", format_number(i.mass)}});
      Attributes tensor;
      std::size_t k = 0;
      for (const char* name : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"})
        tensor.emplace_back(name, format_number(i.inertia[k++]));
      leaf("inertia", tensor);
      xml_.CloseElement();
    }
    for (const Shape& shape : link.visuals) write_shape("visual", shape);
    for (const Shape& shape : link.collisions) write_shape("collision", shape);
    xml_.CloseElement();
  }
  void write_joint(const RobotModel& model, const Joint& joint) {
    open("joint", {{"name", joint.name}, {"type", name(joint.type)}});
    leaf("parent", {{"link", model.links[static_cast<std::size_t>(joint.parent_link)].name}});
    leaf("child", {{"link", model.links[static_cast<std::size_t>(joint.child_link)].name}});
    origin(joint.origin);
    if (joint.moves()) leaf("axis", {{"xyz", text_of(joint.axis)}});
    Attributes limit;
    const JointLimits& l = joint.limits;
    for (const auto& [name, value] : {std::pair{"lower", l.lower},
                                      {"upper", l.upper},
                                      {"velocity", l.velocity},
                                      {"effort", l.effort},
                                      {"acceleration", l.acceleration},
                                      {"deceleration", l.deceleration},
                                      {"jerk", l.jerk}})
      if (value) limit.emplace_back(name, format_number(*value));
    if (!limit.empty()) leaf("limit", limit);
    if (joint.soft_limits) write_soft(*joint.soft_limits);
    if (joint.damping != 0 || joint.friction != 0)
      leaf("dynamics",
           {{"damping", format_number(joint.damping)}, {"friction", format_number(joint.friction)}});
    if (joint.mimic)
      leaf("mimic", {{"joint", model.joints[static_cast<std::size_t>(joint.mimic->joint)].name},
                     {"multiplier", format_number(joint.mimic->multiplier)},
                     {"offset", format_number(joint.mimic->offset)}});
    xml_.CloseElement();
  }
  void write_soft(const SoftLimits& soft) {
    Attributes out;
    if (soft.lower) out.emplace_back("soft_lower_limit", format_number(*soft.lower));
    if (soft.upper) out.emplace_back("soft_upper_limit", format_number(*soft.upper));
    out.emplace_back("k_position", format_number(soft.k_position));
    out.emplace_back("k_velocity", format_number(soft.k_velocity));
    leaf("safety_controller", out);
  }
  void write_contact(const Link& link) {
    const Contact& c = link.contact;
    if (!c.mu1 && !c.mu2 && !c.self_collide) return;
    open("gazebo", {{"reference", link.name}});
    if (c.mu1) write_text("mu1", format_number(*c.mu1));
    if (c.mu2) write_text("mu2", format_number(*c.mu2));
    if (c.self_collide) write_text("selfCollide", *c.self_collide ? "true" : "false");
    xml_.CloseElement();
  }
  void write_parameters(const std::map<std::string, std::string>& parameters) {
    for (const auto& [name, value] : parameters) {
      open("param", {{"name", name}});
      xml_.PushText(value.c_str());
      xml_.CloseElement();
    }
  }
  void write_text(const char* tag, const std::string& text) {
    if (text.empty()) return;
    open(tag);
    xml_.PushText(text.c_str());
    xml_.CloseElement();
  }
  void write_limits(bool enabled) {
    if (!enabled) leaf("limits", {{"enable", "false"}});
  }
  void write_interfaces(const char* tag, const ComponentInfo& component,
                        const std::vector<InterfaceInfo>& interfaces) {
    for (const InterfaceInfo& i : interfaces) {
      open(tag, {{"name", i.name}, {"data_type", i.data_type}});
      if (i.size != 1) xml_.PushAttribute("size", i.size);
      if (component.limits_enabled) write_limits(i.limits_enabled);
      write_parameters(i.parameters);
      xml_.CloseElement();
    }
  }
  void write_component(const ComponentInfo& component) {
    open(component.kind.c_str(), {{"name", component.name}});
    if (component.mimic) xml_.PushAttribute("mimic", *component.mimic);
    write_limits(component.limits_enabled);
    write_parameters(component.parameters);
    write_interfaces("command_interface", component, component.command_interfaces);
    write_interfaces("state_interface", component, component.state_interfaces);
    xml_.CloseElement();
  }
  void write_async(const HardwareInfo& async) {
    std::string list;
    for (const int processor : async.affinity) list += (list.empty() ? "" : ",") + std::to_string(processor);
    open("properties");
    open("async", {{"scheduling_policy", async.scheduling_policy}});
    if (async.thread_priority > 0) xml_.PushAttribute("thread_priority", async.thread_priority);
    xml_.PushAttribute("print_warnings", async.print_warnings);
    if (!list.empty()) xml_.PushAttribute("affinity", ("[" + list + "]").c_str());
    xml_.CloseElement();
    xml_.CloseElement();
  }
  void write_hardware(const HardwareInfo& hardware) {
    open("ros2_control", {{"name", hardware.name}, {"type", hardware.type}});
    if (hardware.rw_rate > 0) xml_.PushAttribute("rw_rate", hardware.rw_rate);
    if (hardware.is_async) xml_.PushAttribute("is_async", true);
    open("hardware");
    write_text("plugin", hardware.plugin);
    write_text("group", hardware.group);
    write_parameters(hardware.parameters);
    xml_.CloseElement();
    if (hardware.is_async) write_async(hardware);
    for (const ComponentInfo& component : hardware.components) write_component(component);
    for (const TransmissionInfo& transmission : hardware.transmissions) write_transmission(transmission);
    xml_.CloseElement();
  }
  void write_transmission(const TransmissionInfo& transmission) {
    open("transmission", {{"name", transmission.name}});
    write_text("plugin", transmission.plugin);
    for (const auto& [tag, ends] :
         {std::pair{"joint", &transmission.joints}, {"actuator", &transmission.actuators}})
      for (const TransmissionEnd& end : *ends) {
        open(tag, {{"name", end.name}, {"role", end.role}});
        if (end.read_only) xml_.PushAttribute("read_only", true);
        write_text("mechanical_reduction", format_number(end.reduction));
        write_text("offset", format_number(end.offset));
        xml_.CloseElement();
      }
    write_parameters(transmission.parameters);
    xml_.CloseElement();
  }
  /// Writes a transmission in the form of ROS 1.
  void write_robot_transmission(const TransmissionInfo& transmission) {
    open("transmission", {{"name", transmission.name}});
    write_text("type", transmission.plugin);
    for (const auto& [tag, ends] :
         {std::pair{"joint", &transmission.joints}, {"actuator", &transmission.actuators}})
      for (const TransmissionEnd& end : *ends) {
        open(tag, {{"name", end.name}});
        write_text("role", end.role);
        for (const std::string& interface : end.interfaces) write_text("hardwareInterface", interface);
        if (end.reduction != 1) write_text("mechanicalReduction", format_number(end.reduction));
        if (end.offset != 0) write_text("offset", format_number(end.offset));
        xml_.CloseElement();
      }
    write_parameters(transmission.parameters);
    xml_.CloseElement();
  }

  /// Writes facts that URDF cannot express, in an element that other readers ignore.
  void write_facts(const RobotModel& model) {
    const Provenance& p = model.provenance;
    Attributes attributes{{"version", "1"}};
    for (const auto& [name, text] :
         {std::pair{"maker", p.maker}, {"model", p.model}, {"source", p.source}, {"licence", p.licence}})
      if (!text.empty()) attributes.emplace_back(name, text);
    if (p.payload_kg) attributes.emplace_back("payload", format_number(*p.payload_kg));
    if (p.reach_m) attributes.emplace_back("reach", format_number(*p.reach_m));
    if (model.tip >= 0) attributes.emplace_back("tip", model.links[static_cast<std::size_t>(model.tip)].name);
    if (!model.controller_axes.empty()) attributes.emplace_back("controller_axes", p.controller_axes);
    open("polyarm", attributes);
    for (std::size_t i = 0; i < model.controller_axes.size(); ++i) write_controller_axis(model, i);
    for (const std::string& note : p.notes) write_text("note", note);
    for (const auto& [name, values] : model.named_states) write_state(model, name, values);
    for (const auto& [first, second] : model.allowed_collisions)
      leaf("allowed_collision", {{"link1", model.links[static_cast<std::size_t>(first)].name},
                                 {"link2", model.links[static_cast<std::size_t>(second)].name}});
    for (const GroupInfo& group : model.groups) write_group(model, group);
    for (const EndEffectorInfo& e : model.end_effectors)
      leaf("end_effector", {{"name", e.name},
                            {"group", e.group},
                            {"parent_link", model.links[static_cast<std::size_t>(e.parent_link)].name},
                            {"parent_group", e.parent_group}});
    for (const Link& link : model.links)
      if (link.inertial && link.inertial->estimated) leaf("estimated", {{"link", link.name}});
    xml_.CloseElement();
  }
  void write_controller_axis(const RobotModel& model, std::size_t at) {
    const std::vector<std::string> joints = model.joint_names();
    const ControllerAxis& axis = model.controller_axes[at];
    open("controller_axis",
         {{"joint", joints[at]}, {"sign", format_number(axis.sign)}, {"offset", format_number(axis.offset)}});
    for (const auto& [joint, factor] : axis.coupling)
      leaf("coupling",
           {{"joint", joints[static_cast<std::size_t>(joint)]}, {"factor", format_number(factor)}});
    xml_.CloseElement();
  }
  void write_group(const RobotModel& model, const GroupInfo& group) {
    open("group", {{"name", group.name}});
    for (const int joint : group.joints)
      leaf("joint", {{"name", model.joints[static_cast<std::size_t>(joint)].name}});
    for (const int link : group.links)
      leaf("link", {{"name", model.links[static_cast<std::size_t>(link)].name}});
    xml_.CloseElement();
  }
  void write_state(const RobotModel& model, const std::string& name, const std::vector<double>& values) {
    const std::vector<std::string> joints = model.joint_names();
    open("state", {{"name", name}});
    for (std::size_t i = 0; i < joints.size() && i < values.size(); ++i)
      leaf("joint", {{"name", joints[i]}, {"value", format_number(values[i])}});
    xml_.CloseElement();
  }

  tinyxml2::XMLPrinter xml_;
};

}  // namespace

std::string write_urdf(const RobotModel& model) {
  return UrdfWriter().write(model);
}

bool is_launch_file(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  // Any Python file, including view.launch.py, view_launch.py and launch.py: descriptions and cells are never
  // Python.
  return name.ends_with(".launch") || name.ends_with(".py") || name.ends_with(".launch.xml") || name.ends_with(".launch.yaml");
}

LaunchHints find_in_launch_file(std::string_view text) {
  LaunchHints out;
  const auto add = [](std::vector<std::string>& list, const std::string& name) {
    if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
  };
  for (std::string word : split_words(text, " \t\r\n\"'<>=,()[]{}")) {
    if (const auto close = word.rfind(')'); close != std::string::npos) word.erase(0, close + 1);
    if (word.starts_with('.') && word.find('/') == std::string::npos) continue;  // the end of a computed name
    if (word.ends_with(".urdf") || word.ends_with(".xacro")) add(out.descriptions, word);
    if (word.ends_with(".yaml") || word.ends_with(".yml")) add(out.controllers, word);
  }
  return out;
}

std::string LaunchHints::line(const std::string& verb) const {
  std::string out =
      "polyarm " + verb + " --description " + (descriptions.empty() ? std::string("FILE.urdf") : descriptions.front());
  if (!controllers.empty()) out += " --controllers " + controllers.front();
  return out;
}

}  // namespace polyarm::description
