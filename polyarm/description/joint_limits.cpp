#include "polyarm/description/joint_limits.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace {

void tighten(std::optional<double>& limit, const std::optional<double>& other) {
  if (other) limit = std::min(limit.value_or(*other), *other);
}

/// Soft limits belong within the hard ones; where nothing of their range is, there are none.
void clip_soft(JointLimitSet& limits, const std::string& joint, const Location& where, Problems& problems) {
  if (!limits.soft) return;
  SoftLimits& soft = *limits.soft;
  const bool above = soft.lower && limits.upper && *soft.lower >= *limits.upper;
  const bool below = soft.upper && limits.lower && *soft.upper <= *limits.lower;
  if (above || below) {
    problems.warning(
        "bad-limit", where,
        "the soft limits of '" + joint + "' lie wholly outside its hard ones; they are passed over",
        "write soft limits between the hard ones");
    limits.soft.reset();
    return;
  }
  if (soft.lower && limits.lower) soft.lower = std::max(*soft.lower, *limits.lower);
  if (soft.upper && limits.upper) soft.upper = std::min(*soft.upper, *limits.upper);
}

JointLimitSet of_urdf(const Joint& joint) {
  const JointLimits& l = joint.limits;
  JointLimitSet out;
  out.lower = l.lower;
  out.upper = l.upper;
  out.velocity = l.velocity;
  out.effort = l.effort;
  out.acceleration = l.acceleration;
  out.deceleration = l.deceleration ? l.deceleration : l.acceleration;
  out.jerk = l.jerk;
  out.soft = joint.soft_limits;
  return out;
}

/// Adds one `<joint>` of `<ros2_control>` to what is known of it.
class Merge {
 public:
  Merge(JointLimitSet& limits, const std::string& joint, Problems& problems)
      : limits_(limits), joint_(joint), problems_(problems) {}

  void add(const ComponentInfo& component) {
    if (!component.limits_enabled) limits_.disabled = {true, true, true, true, true, true, true};
    for (const InterfaceInfo& i : component.command_interfaces) {
      if (i.name == "position") position(i);
      if (i.name == "velocity") symmetric(i, limits_.velocity, limits_.disabled.velocity);
      if (i.name == "effort") symmetric(i, limits_.effort, limits_.disabled.effort);
      if (i.name == "acceleration") acceleration(i);
      if (i.name == "jerk") {
        tighten(limits_.jerk, above_zero(i, i.max));
        limits_.disabled.jerk |= !i.limits_enabled;
      }
    }
  }

 private:
  void position(const InterfaceInfo& i) {
    limits_.disabled.position |= !i.limits_enabled;
    const auto lower = i.min && limits_.lower ? std::max(*i.min, *limits_.lower)
                       : i.min                ? i.min
                                              : limits_.lower;
    const auto upper = i.max && limits_.upper ? std::min(*i.max, *limits_.upper)
                       : i.max                ? i.max
                                              : limits_.upper;
    if (lower && upper && !(*lower < *upper))
      return problems_.error("bad-limit", i.where,
                             "nothing is left of the range of '" + joint_ + "': from " +
                                 format_number(*lower) + " to " + format_number(*upper) +
                                 ", with the limits of the robot's joint",
                             "write a min and max that meet the lower and upper of its <limit>");
    limits_.lower = lower;
    limits_.upper = upper;
  }

  void symmetric(const InterfaceInfo& i, std::optional<double>& limit, bool& disabled) {
    disabled |= !i.limits_enabled;
    std::optional<double> both = i.max;
    if (i.min) both = std::min(std::abs(*i.min), i.max.value_or(std::abs(*i.min)));
    tighten(limit, above_zero(i, both));
  }

  void acceleration(const InterfaceInfo& i) {
    limits_.disabled.acceleration |= !i.limits_enabled;
    limits_.disabled.deceleration |= !i.limits_enabled;
    const std::optional<double> down = i.min ? std::optional(std::abs(*i.min)) : i.max;
    const std::optional<double> up = i.max ? i.max : down;
    tighten(limits_.acceleration, above_zero(i, up));
    tighten(limits_.deceleration, above_zero(i, down));
  }

  std::optional<double> above_zero(const InterfaceInfo& i, const std::optional<double>& value) {
    if (!value || *value > 0) return value;
    if (i.limits_enabled)
      problems_.warning("bad-limit", i.where,
                        "a limit of " + format_number(*value) + " for the " + i.name + " of '" + joint_ +
                            "' would never let it move; it is passed over",
                        "write one above zero, or <limits enable=\"false\"/>");
    return std::nullopt;
  }

  JointLimitSet& limits_;
  const std::string& joint_;
  Problems& problems_;
};

void drop_disabled(JointLimitSet& limits) {
  const JointLimitSet::Disabled& off = limits.disabled;
  if (off.position) limits.lower = limits.upper = std::nullopt;
  if (off.velocity) limits.velocity.reset();
  if (off.effort) limits.effort.reset();
  if (off.acceleration) limits.acceleration.reset();
  if (off.deceleration) limits.deceleration.reset();
  if (off.jerk) limits.jerk.reset();
  if (off.soft) limits.soft.reset();
}

/// What `stated` says, a value or that there is none, replaces what was there.
void replace(std::optional<double>& limit, bool& disabled, const std::optional<double>& stated, bool off) {
  if (!stated && !off) return;
  limit = stated;
  disabled = off;
}

void replace(JointLimitSet& limits, const JointLimitSet& stated) {
  JointLimitSet::Disabled& off = limits.disabled;
  if (stated.lower || stated.disabled.position) {
    limits.lower = stated.lower;
    limits.upper = stated.upper;
    off.position = stated.disabled.position;
  }
  replace(limits.velocity, off.velocity, stated.velocity, stated.disabled.velocity);
  replace(limits.effort, off.effort, stated.effort, stated.disabled.effort);
  replace(limits.acceleration, off.acceleration, stated.acceleration, stated.disabled.acceleration);
  const bool says = stated.deceleration || stated.disabled.deceleration;  // else it follows the acceleration
  replace(limits.deceleration, off.deceleration, says ? stated.deceleration : stated.acceleration,
          says ? stated.disabled.deceleration : stated.disabled.acceleration);
  replace(limits.jerk, off.jerk, stated.jerk, stated.disabled.jerk);
  if (stated.soft || stated.disabled.soft) {
    limits.soft = stated.soft;
    off.soft = stated.disabled.soft;
  }
  if (stated.angle_wraparound) limits.angle_wraparound = stated.angle_wraparound;
}

}  // namespace

std::vector<JointLimitSet> merge_limits(const RobotModel& model, Problems& problems) {
  std::vector<JointLimitSet> out;
  for (const Joint& joint : model.joints) out.push_back(of_urdf(joint));
  std::vector<Location> places(out.size());
  for (const HardwareInfo& hardware : model.hardware)
    for (const ComponentInfo& component : hardware.components) {
      const int joint = component.kind == "joint" ? model.find_joint(component.name) : -1;
      if (joint < 0) continue;
      places[static_cast<std::size_t>(joint)] = component.where;
      Merge(out[static_cast<std::size_t>(joint)], component.name, problems).add(component);
    }
  for (std::size_t j = 0; j < out.size(); ++j) {
    drop_disabled(out[j]);
    clip_soft(out[j], model.joints[j].name, places[j], problems);
  }
  return out;
}

void override_limits(const JointLimitsFile& file, const RobotModel& model, std::vector<JointLimitSet>& limits,
                     Problems& problems) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints) names.push_back(joint.name);
  for (const auto& [name, entry] : file.joints) {
    const int found = model.find_joint(name);
    if (found < 0) {
      problems.warning("unknown-joint", entry.where,
                       "the robot has no joint '" + name + "'" + did_you_mean(name, names));
      continue;
    }
    const auto joint = static_cast<std::size_t>(found);
    if (joint >= limits.size()) continue;
    replace(limits[joint], entry.limits);
    clip_soft(limits[joint], name, entry.where, problems);
  }
}

void take_over(const std::vector<JointLimitSet>& limits, RobotModel& model) {
  for (std::size_t j = 0; j < std::min(limits.size(), model.joints.size()); ++j) {
    Joint& joint = model.joints[j];
    const JointLimitSet& set = limits[j];
    joint.limits.lower = set.lower;
    joint.limits.upper = set.upper;
    if (joint.type == JointType::continuous) joint.limits.lower = joint.limits.upper = std::nullopt;
    joint.limits.velocity = set.velocity;
    joint.limits.effort = set.effort;
    joint.limits.acceleration = set.acceleration;
    joint.limits.deceleration = set.deceleration;
    joint.limits.jerk = set.jerk;
    joint.soft_limits = set.soft;
  }
}

}  // namespace polyarm::description
