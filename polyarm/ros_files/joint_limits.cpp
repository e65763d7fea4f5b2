#include "polyarm/ros_files/joint_limits.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_files {

namespace {

using controllers::JointFacts;

/// Narrows a symmetric limit by a range: uses the smaller side.
void narrow(double& limit, const std::optional<double>& low, const std::optional<double>& high) {
  for (const auto& side : {low, high})
    if (side && std::isfinite(*side) && *side != 0) limit = std::min(limit, std::abs(*side));
}

std::string range(double lower, double upper) {
  const auto side = [](double value) {
    return std::isfinite(value) ? format_number(value) : std::string("no limit");
  };
  return side(lower) + " to " + side(upper);
}

/// Keeps the old range if the new one would be empty.
void positions_by_interface(const description::InterfaceInfo& interface, JointFacts& facts,
                            Problems& problems) {
  const double lowest = interface.min.value_or(facts.lower), highest = interface.max.value_or(facts.upper);
  const double lower = std::max(facts.lower, lowest), upper = std::min(facts.upper, highest);
  if (lower > upper) {
    problems.error(
        "bad-limit", interface.where,
        "no position of '" + facts.name + "' is left: the command interface 'position' allows " +
            range(lowest, highest) + ", the joint " + range(facts.lower, facts.upper),
        "correct min and max here, or the joint's <limit>; <limits enable=\"false\"/> ignores min and max");
    return;
  }
  facts.lower = lower;
  facts.upper = upper;
}

void by_interface(const description::InterfaceInfo& interface, JointFacts& facts, Problems& problems) {
  if (interface.name == "position") {
    positions_by_interface(interface, facts, problems);
  } else if (interface.name == "velocity") {
    narrow(facts.velocity, interface.min, interface.max);
  } else if (interface.name == "effort") {
    narrow(facts.effort, interface.min, interface.max);
  } else if (interface.name == "acceleration" && (interface.min || interface.max)) {
    const std::optional<double> up = interface.max ? interface.max : interface.min;
    const std::optional<double> down = interface.min ? interface.min : interface.max;
    facts.acceleration =
        facts.states_acceleration ? std::min(facts.acceleration, std::abs(*up)) : std::abs(*up);
    facts.deceleration = std::abs(*down);
    facts.states_acceleration = true;
  } else if (interface.name == "jerk" && interface.max) {
    facts.jerk = facts.states_jerk ? std::min(facts.jerk, *interface.max) : *interface.max;
    facts.states_jerk = true;
  }
}

const std::vector<std::string> kKeys = {"has_position_limits",
                                        "min_position",
                                        "max_position",
                                        "has_velocity_limits",
                                        "max_velocity",
                                        "min_velocity",
                                        "has_acceleration_limits",
                                        "max_acceleration",
                                        "has_deceleration_limits",
                                        "max_deceleration",
                                        "has_jerk_limits",
                                        "max_jerk",
                                        "has_effort_limits",
                                        "max_effort",
                                        "has_soft_limits",
                                        "k_position",
                                        "k_velocity",
                                        "soft_lower_limit",
                                        "soft_upper_limit",
                                        "angle_wraparound"};

/// Reads the map of one joint.
class JointReader {
 public:
  JointReader(const Yaml& yaml, JointFacts& facts, Problems& problems)
      : yaml_(yaml), facts_(facts), problems_(problems) {}

  void read() {
    yaml_.check_keys(kKeys, problems_);
    if (has("has_position_limits", {"min_position", "max_position"})) {
      positions(number("min_position").value_or(facts_.lower), number("max_position").value_or(facts_.upper));
    }
    if (positive("has_velocity_limits", "max_velocity", facts_.velocity)) facts_.states_velocity = true;
    if (positive("has_acceleration_limits", "max_acceleration", facts_.acceleration,
                 facts_.states_acceleration))
      facts_.states_acceleration = true;
    positive("has_deceleration_limits", "max_deceleration", facts_.deceleration);
    if (positive("has_jerk_limits", "max_jerk", facts_.jerk, facts_.states_jerk)) facts_.states_jerk = true;
    positive("has_effort_limits", "max_effort", facts_.effort);
    soft();
  }

 private:
  /// Keeps the old range if the new one would be empty.
  void positions(double lowest, double highest) {
    const double lower = std::max(facts_.lower, lowest), upper = std::min(facts_.upper, highest);
    if (lower > upper)
      return problems_.error("bad-limit", yaml_.where(),
                             "no position of '" + facts_.name + "' is left: this file allows " +
                                 range(lowest, highest) + ", the description " +
                                 range(facts_.lower, facts_.upper),
                             "compare them");
    facts_.lower = lower;
    facts_.upper = upper;
  }

  std::optional<double> number(const char* key) {
    std::optional<double> out;
    collect(problems_, [&] {
      if (yaml_.has(key)) out = yaml_[key].number();
    });
    return out;
  }

  /// True if this group of limits applies: as its flag says; without a flag, if one of its keys is present.
  bool has(const char* flag, std::initializer_list<const char*> keys) {
    bool out = false;
    if (yaml_.has(flag))
      collect(problems_, [&] { out = yaml_[flag].boolean(); });
    else
      for (const char* key : keys) out = out || yaml_.has(key);
    return out;
  }

  bool positive(const char* flag, const char* key, double& limit, bool stated = true) {
    if (!has(flag, {key})) return false;
    const auto value = number(key);
    if (!value) {
      if (yaml_.has(flag) && !yaml_.has(key))
        problems_.error("missing-key", yaml_.where(), std::string(flag) + " is true, and there is no " + key,
                        std::string("add ") + key);
      return false;
    }
    if (!(*value > 0)) {
      problems_.warning("bad-limit", yaml_[key].where(),
                        std::string(key) + " of '" + facts_.name + "' is " + format_number(*value) +
                            ", which would freeze the joint; it is ignored",
                        std::string("write ") + flag + ": false if there is no limit");
      return false;
    }
    limit = stated ? std::min(limit, *value) : *value;
    return true;
  }

  void soft() {
    if (!has("has_soft_limits", {"k_position", "soft_lower_limit", "soft_upper_limit"})) return;
    controllers::SoftLimits out;
    out.lower = std::max(number("soft_lower_limit").value_or(facts_.lower), facts_.lower);
    out.upper = std::min(number("soft_upper_limit").value_or(facts_.upper), facts_.upper);
    out.k_position = number("k_position").value_or(0);
    out.k_velocity = number("k_velocity").value_or(0);
    if (out.k_position > 0) {
      facts_.soft = out;
      return;
    }
    facts_.soft.reset();
    problems_.warning("bad-limit", yaml_.where(),
                      "the soft limits of '" + facts_.name + "' have no k_position above zero and no effect",
                      "write k_position: the velocity allowed for each rad (m) to the soft limit, 1/s");
  }

  const Yaml& yaml_;
  JointFacts& facts_;
  Problems& problems_;
};

}  // namespace

void narrow_by_hardware(const description::RobotModel& model, const std::string& joint, JointFacts& facts,
                        Problems& problems) {
  for (const description::HardwareInfo& hardware : model.hardware)
    for (const description::ComponentInfo& component : hardware.components)
      if (component.kind == "joint" && component.name == joint)
        for (const description::InterfaceInfo& interface : component.command_interfaces)
          if (component.limits_enabled && interface.limits_enabled) by_interface(interface, facts, problems);
}

void narrow_by_file(const JointLimitsSource& source, std::vector<JointFacts*>& joints, Problems& problems) {
  const std::string text = source.text ? *source.text : read_file(source.file);
  Yaml yaml = Yaml::parse(text, source.file.string());
  for (const std::string& key : source.keys) {
    const Yaml inner = yaml[key];
    yaml = inner;
  }
  std::vector<std::string> known;
  for (const JointFacts* joint : joints) known.push_back(joint->name.substr(joint->name.find('/') + 1));
  for (const std::string& name : yaml.keys()) {
    bool found = false;
    for (JointFacts* joint : joints) {
      if (joint->name != name && joint->name.substr(joint->name.find('/') + 1) != name) continue;
      found = true;
      const Yaml map = yaml[name];
      JointReader(map, *joint, problems).read();
    }
    if (!found)
      problems.warning(
          "unknown-joint", yaml.key_location(name),
          "joint_limits names the joint '" + name + "', which no robot has" + did_you_mean(name, known),
          "its limits have no effect");
  }
}

}  // namespace polyarm::ros_files
