#include "polyarm/description/ros2_control_reader.hpp"

#include <algorithm>
#include <utility>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace {

bool holds(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The range of an integer type; empty for other types.
std::optional<std::pair<double, double>> range_of(const std::string& type) {
  const bool is_unsigned = type.starts_with("uint");
  if (!is_unsigned && !type.starts_with("int")) return std::nullopt;
  const double most = default_value(type).value_or(0);
  return std::pair{is_unsigned ? 0 : -most - 1, most};
}

/// A value in the notation of its type; bools become 0 and 1.
std::optional<double> parse_value(const std::string& type, const std::string& text) {
  if (type == "bool") {
    const std::string word = lower(text);
    if (word == "true") return 1;
    if (word == "false") return 0;
  }
  const auto out = parse_number(text);
  if (!out) return std::nullopt;
  if (type == "bool") return *out == 0 || *out == 1 ? out : std::nullopt;
  const auto range = range_of(type);
  const bool fits = !range || (*out == std::floor(*out) && *out >= range->first && *out <= range->second);
  return fits ? out : std::nullopt;
}

}  // namespace

HardwareInfo Ros2ControlReader::hardware(const Element& e) {
  static const std::vector<std::string> kChildren{"hardware", "properties", "joint",
                                                  "sensor",   "gpio",       "transmission"};
  static const std::vector<std::string> kTypes{"system", "actuator", "sensor"};
  HardwareInfo out;
  out.where = at(e);
  out.name = optional_attribute(e, "name");  // check_hardware gives it a name
  out.type = attribute(e, "type", "system");
  if (const std::string small = lower(out.type); small != out.type && holds(kTypes, small)) {
    warning(e, "bad-type",
            "'" + out.type + "' is read as '" + small + "'; ros2_control knows only the latter",
            "write type=\"" + small + "\"");
    out.type = small;
  }
  if (!out.type.empty() && !holds(kTypes, out.type))
    error(e, "bad-type", "'" + out.type + "' is not a type of hardware" + did_you_mean(out.type, kTypes),
          out.type.find_first_of("/:") == std::string::npos
              ? "write system, actuator or sensor"
              : "write system, actuator or sensor; a plugin goes into <hardware><plugin>" + out.type +
                    "</plugin>");
  check_attributes(e, {"name", "type", "rw_rate", "is_async", "thread_priority"});
  out.rw_rate = whole(e, "rw_rate", 0).value_or(0);
  asynchronous(e, out);
  for (const Element* c = e.FirstChildElement(); c; c = c->NextSiblingElement()) {
    const std::string_view tag = c->Name();
    if (tag == "hardware") driver(*c, out);
    if (tag == "joint" || tag == "sensor" || tag == "gpio") out.components.push_back(component(*c));
    if (tag == "transmission") out.transmissions.push_back(transmission(*c));
    if (!holds(kChildren, tag))
      error(*c, "unknown-tag",
            "<" + std::string(tag) + "> is unknown in <ros2_control>" + did_you_mean(tag, kChildren),
            "known here: <hardware>, <properties>, <joint>, <sensor>, <gpio>, <transmission>");
  }
  if (out.plugin.empty())
    warning(e, "missing-tag",
            "the <ros2_control> '" + out.name + "' names no plugin; it is treated as an unknown one",
            "write <hardware><plugin>mock_components/GenericSystem</plugin></hardware>");
  return out;
}

void Ros2ControlReader::driver(const Element& e, HardwareInfo& out) {
  check_children(e, {"plugin", "group", "param", "properties"});
  out.plugin = text(e, "plugin");
  out.group = text(e, "group");
  out.parameters = parameters(e);
}

void Ros2ControlReader::asynchronous(const Element& e, HardwareInfo& out) {
  out.is_async = boolean(e, "is_async").value_or(false);
  if (const auto priority = whole(e, "thread_priority", 1)) {
    out.thread_priority = *priority;
    warning(e, "superseded", "thread_priority has moved out of <ros2_control>",
            "write <properties><async thread_priority=\"" + std::to_string(*priority) +
                "\"/></properties> inside it");
  }
  const Element* driver = e.FirstChildElement("hardware");
  for (const Element* parent : {&e, driver})
    if (const Element* p = parent ? parent->FirstChildElement("properties") : nullptr) {
      check_children(*p, {"async"});
      if (const Element* a = p->FirstChildElement("async")) async_properties(*a, out);
    }
}

void Ros2ControlReader::async_properties(const Element& e, HardwareInfo& out) {
  static const std::vector<std::string> kPolicies{"synchronized", "detached"};
  check_attributes(e, {"affinity", "scheduling_policy", "thread_priority", "print_warnings"});
  if (!out.is_async)
    warning(e, "no-effect", "<async> has no effect on '" + out.name + "', which is not asynchronous",
            "write is_async=\"true\" into its <ros2_control>");
  out.thread_priority = whole(e, "thread_priority", 1).value_or(out.thread_priority);
  out.print_warnings = boolean(e, "print_warnings").value_or(true);
  out.affinity = affinity(e);
  const std::string policy = optional_attribute(e, "scheduling_policy");
  if (policy.empty()) return;
  if (holds(kPolicies, policy))
    out.scheduling_policy = policy;
  else
    error(e, "bad-value", "'" + policy + "' is not a scheduling policy" + did_you_mean(policy, kPolicies),
          "write synchronized or detached");
}

std::vector<int> Ros2ControlReader::affinity(const Element& e) {
  std::vector<int> out;
  const std::string list = optional_attribute(e, "affinity");
  for (const std::string& word : split_words(list, " \t\r\n,[]")) {
    const auto value = parse_number(word);
    if (value && *value >= 0 && *value < 65536 && *value == std::floor(*value)) {
      out.push_back(static_cast<int>(*value));
      continue;
    }
    error(e, "bad-number", "affinity=\"" + list + "\" is not a list of processor numbers",
          "write affinity=\"[2,4]\"");
    return {};
  }
  return out;
}

bool Ros2ControlReader::limits_enabled(const Element& e) {
  const Element* l = e.FirstChildElement("limits");
  if (!l) return true;
  check_attributes(*l, {"enable"});
  if (attribute(*l, "enable", "false").empty()) return true;
  return boolean(*l, "enable").value_or(true);
}

ComponentInfo Ros2ControlReader::component(const Element& e) {
  ComponentInfo out;
  out.kind = e.Name();
  out.where = at(e);
  out.name = attribute(e, "name", out.kind == "joint" ? "joint_1" : out.kind + "_1");
  check_attributes(e, {"name", "mimic"});
  check_children(e, {"command_interface", "state_interface", "param", "limits"});
  out.mimic = boolean(e, "mimic");
  if (out.kind == "gpio" && e.FirstChildElement("limits"))
    warning(*e.FirstChildElement("limits"), "no-effect", "<limits> has no effect on the whole of a <gpio>",
            "write it into its interfaces");
  else
    out.limits_enabled = limits_enabled(e);
  out.parameters = parameters(e);
  for (const auto& [tag, list] : {std::pair{"command_interface", &out.command_interfaces},
                                  {"state_interface", &out.state_interfaces}}) {
    std::vector<std::string> names;
    for (const Element* i = e.FirstChildElement(tag); i; i = i->NextSiblingElement(tag)) {
      InterfaceInfo read = interface(*i, out.limits_enabled);
      if (!read.name.empty() && holds(names, read.name)) {
        warning(*i, "duplicate-name",
                "'" + out.name + "' has two of <" + std::string(tag) + " name=\"" + read.name +
                    "\">; the first counts",
                "remove one of them");
        continue;
      }
      names.push_back(read.name);
      list->push_back(std::move(read));
    }
  }
  return out;
}

InterfaceInfo Ros2ControlReader::interface(const Element& e, bool enabled) {
  InterfaceInfo out;
  out.where = at(e);
  out.name = attribute(e, "name", "position");
  check_attributes(e, {"name", "data_type", "size", "initial_value"});
  check_children(e, {"param", "limits"});
  if (const std::string type = optional_attribute(e, "data_type"); !type.empty()) {
    if (holds(data_types(), type))
      out.data_type = type;
    else
      error(e, "bad-type", "'" + type + "' is not a data type" + did_you_mean(type, data_types()),
            "write one of " + join(data_types(), ", "));
  }
  if (const char* size = e.Attribute("size")) {
    const std::string digits(trim(size));
    if (digits.empty() || digits.size() > 6 || digits[0] == '0' ||
        digits.find_first_not_of("0123456789") != std::string::npos)
      error(e, "bad-value", "size=\"" + std::string(size) + "\" is not a count from 1 to 999999",
            "write size=\"1\", or leave it out");
    else
      out.size = std::stoi(digits);
  }
  out.limits_enabled = limits_enabled(e) && enabled;
  out.parameters = parameters(e);
  if (const char* initial = e.Attribute("initial_value")) out.parameters["initial_value"] = initial;
  range(e, out);
  return out;
}

void Ros2ControlReader::range(const Element& e, InterfaceInfo& info) {
  value(e, info, "min", info.min);
  value(e, info, "max", info.max);
  value(e, info, "initial_value", info.initial_value);
  if (!info.min || !info.max || *info.min <= *info.max) return;
  warning(e, "bad-limit",
          "the min " + format_number(*info.min) + " of '" + info.name + "' is above its max " +
              format_number(*info.max) + "; they are taken the other way round",
          "exchange them");
  std::swap(info.min, info.max);
}

void Ros2ControlReader::value(const Element& e, const InterfaceInfo& info, const char* name,
                              std::optional<double>& out) {
  const auto found = info.parameters.find(name);
  if (found == info.parameters.end()) return;
  out = parse_value(info.data_type, found->second);
  if (!out && !found->second.empty())
    warning(e, "bad-number",
            std::string(name) + " of '" + info.name + "' is '" + found->second + "', which is not a " +
                (info.data_type == "double" ? "number" : info.data_type) + "; it is ignored");
}

TransmissionInfo Ros2ControlReader::transmission(const Element& e) {
  TransmissionInfo out;
  out.where = at(e);
  out.name = attribute(e, "name", "transmission_1");
  check_attributes(e, {"name"});
  check_children(e, {"plugin", "joint", "actuator", "param"});
  out.plugin = text(e, "plugin");
  if (out.plugin.empty())
    error(e, "missing-tag", "the transmission '" + out.name + "' names no plugin",
          "write <plugin>transmission_interface/SimpleTransmission</plugin>");
  for (const auto& [tag, list] : {std::pair{"joint", &out.joints}, {"actuator", &out.actuators}}) {
    const Element* first = e.FirstChildElement(tag);
    const bool several = first && first->NextSiblingElement(tag);
    for (const Element* end = first; end; end = end->NextSiblingElement(tag))
      list->push_back(transmission_end(*end, several));
  }
  if (out.joints.empty())
    error(e, "missing-tag", "the transmission '" + out.name + "' has no <joint>",
          "write <joint name=\"joint_1\" role=\"joint1\"/>");
  out.parameters = parameters(e);
  return out;
}

TransmissionEnd Ros2ControlReader::transmission_end(const Element& e, bool role_needed) {
  TransmissionEnd out;
  const std::string tag = e.Name();
  out.name = attribute(e, "name", tag + "_1");
  out.role = role_needed ? attribute(e, "role", tag + "1") : optional_attribute(e, "role");
  check_attributes(e, {"name", "role", "read_only"});
  check_children(e, {"mechanical_reduction", "offset", "mechanicalReduction"});
  out.read_only = boolean(e, "read_only").value_or(false);
  const Element* reduction = e.FirstChildElement("mechanical_reduction");
  if (const Element* old = e.FirstChildElement("mechanicalReduction")) {
    warning(
        *old, "superseded",
        "<mechanicalReduction> is how ROS 1 writes <mechanical_reduction>; ros2_control passes it over, here "
        "it counts",
        "write <mechanical_reduction>");
    if (!reduction) reduction = old;
  }
  if (reduction) out.reduction = number_inside(*reduction).value_or(1);
  if (out.reduction == 0)
    error(e, "bad-value", "the mechanical_reduction of '" + out.name + "' is 0",
          "write the turns of the actuator for one turn of the joint; 1 leaves it as it is");
  if (const Element* o = e.FirstChildElement("offset")) out.offset = number_inside(*o).value_or(0);
  return out;
}

TransmissionInfo Ros2ControlReader::robot_transmission(const Element& e) {
  TransmissionInfo out;
  out.where = at(e);
  out.name = optional_attribute(e, "name");
  out.plugin = text(e, "type");
  if (out.plugin.empty()) out.plugin = optional_attribute(e, "type");
  if (out.plugin.empty())
    warning(e, "missing-tag", "the transmission '" + out.name + "' has no type",
            "write <type>transmission_interface/SimpleTransmission</type>");
  for (const auto& [tag, list] : {std::pair{"joint", &out.joints}, {"actuator", &out.actuators}})
    for (const Element* end = e.FirstChildElement(tag); end; end = end->NextSiblingElement(tag))
      list->push_back(robot_transmission_end(*end, e));
  out.parameters = parameters(e);
  return out;
}

/// A reduction outside the ends, as in the oldest files, belongs to the first actuator.
TransmissionEnd Ros2ControlReader::robot_transmission_end(const Element& e, const Element& transmission) {
  TransmissionEnd out;
  out.name = optional_attribute(e, "name");
  out.role = text(e, "role");
  const Element* r = e.FirstChildElement("mechanicalReduction");
  const bool first_actuator = &e == transmission.FirstChildElement("actuator");
  if (!r && first_actuator) r = transmission.FirstChildElement("mechanicalReduction");
  const auto value = [&](const Element* source, double fallback) {
    if (!source || text(source).empty()) return fallback;
    const auto stated = parse_number(text(source));
    if (!stated)
      warning(*source, "bad-number",
              std::string("<") + source->Name() + "> is '" + text(source) +
                  "', which is not a number; it is taken as " + format_number(fallback));
    return stated.value_or(fallback);
  };
  out.reduction = value(r, 1);
  out.offset = value(e.FirstChildElement("offset"), 0);
  for (const Element* i = e.FirstChildElement("hardwareInterface"); i;
       i = i->NextSiblingElement("hardwareInterface"))
    out.interfaces.push_back(text(i));
  return out;
}

}  // namespace polyarm::description
