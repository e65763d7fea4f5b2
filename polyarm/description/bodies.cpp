#include "polyarm/description/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"

namespace polyarm::description {

namespace {

constexpr double kLevel = 0.2;  // sine of the largest angle at which an axis counts as horizontal
constexpr double kSteep = 0.98;  // and of the smallest one at which it counts as vertical
constexpr std::size_t kFewest = 2;

const Joint* joint_above(const RobotModel& model, std::size_t link) {
  const int joint = model.links[link].parent_joint;
  return joint < 0 ? nullptr : &model.joints[static_cast<std::size_t>(joint)];
}

/// T_root_link with all joints at zero.
Pose pose_of(const RobotModel& model, std::size_t link) {
  Pose out;
  for (const Joint* joint = joint_above(model, link); joint;
       joint = joint_above(model, static_cast<std::size_t>(joint->parent_link)))
    out = joint->origin * out;
  return out;
}

bool carries_joints(const RobotModel& model, std::size_t link) {
  return std::any_of(model.joints.begin(), model.joints.end(), [&](const Joint& joint) {
    return joint.parent_link == static_cast<int>(link) && joint.moves();
  });
}

/// Sine of the angle between the axis of the joint above the link and the horizontal, at zero.
double steepness(const RobotModel& model, std::size_t link) {
  return std::abs((pose_of(model, link).rotation * joint_above(model, link)->axis).z);
}

/// It is at the end of a continuous joint with a horizontal axis.
bool turns_as_a_wheel(const RobotModel& model, std::size_t link) {
  const Joint* joint = joint_above(model, link);
  return joint && joint->type == JointType::continuous && !carries_joints(model, link) &&
         steepness(model, link) <= kLevel;
}

bool looks_like_a_wheel(const RobotModel& model, std::size_t link) {
  if (!turns_as_a_wheel(model, link)) return false;
  const std::vector<Shape>& shapes = model.links[link].collisions;
  return std::any_of(shapes.begin(), shapes.end(), [](const Shape& shape) {
    return shape.kind == ShapeKind::cylinder || shape.kind == ShapeKind::sphere;
  });
}

/// True if hardware describes its joints, and this one takes no command.
bool is_passive(const RobotModel& model, const std::string& joint) {
  bool any = false;
  for (const HardwareInfo& block : model.hardware)
    for (const ComponentInfo& component : block.components) {
      if (component.kind != "joint") continue;
      any = true;
      if (component.name == joint && !component.command_interfaces.empty()) return false;
    }
  return any;
}

bool is_behind(const RobotModel& model, std::size_t link, const std::vector<int>& joints) {
  for (const Joint* joint = joint_above(model, link); joint; joint = joint_above(model, link)) {
    const int index = model.links[link].parent_joint;
    if (std::find(joints.begin(), joints.end(), index) != joints.end()) return true;
    link = static_cast<std::size_t>(joint->parent_link);
  }
  return false;
}

/// The height of the highest wheel behind these joints, with what casters may be higher, m.
double caster_height(const RobotModel& model, const std::vector<int>& joints) {
  constexpr double kHigher = 0.05;
  double out = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (is_behind(model, i, joints) && turns_as_a_wheel(model, i))
      out = std::max(out, pose_of(model, i).position.z + kHigher);
  return out;
}

/// A wheel that nobody commands, on the floor of the others: an arm that no hardware lists is higher.
bool is_caster(const RobotModel& model, std::size_t link, double highest) {
  if (!turns_as_a_wheel(model, link) || pose_of(model, link).position.z > highest) return false;
  for (const Joint* joint = joint_above(model, link);;) {
    link = static_cast<std::size_t>(joint->parent_link);
    joint = joint_above(model, link);
    if (!joint) return true;
    const bool swivels = joint->type == JointType::continuous && steepness(model, link) >= kSteep;
    if (joint->moves() && !swivels && !is_passive(model, joint->name)) return false;
  }
}

/// Marks the link and those that carry it, up to the root.
void mark_up(const RobotModel& model, std::size_t link, std::vector<char>& out) {
  out[link] = 1;
  for (const Joint* joint = joint_above(model, link); joint;
       joint = joint_above(model, static_cast<std::size_t>(joint->parent_link)))
    out[static_cast<std::size_t>(joint->parent_link)] = 1;
}

bool rigid_with_root(const RobotModel& model, std::size_t link) {
  const Joint* joint = joint_above(model, link);
  for (; joint && !joint->moves(); joint = joint_above(model, static_cast<std::size_t>(joint->parent_link))) {
  }
  return !joint;
}

/// "a, b, c and 4 more"
std::string some(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 5;
  if (names.size() <= kShown) return join(names, ", ");
  const std::vector<std::string> first(names.begin(), names.begin() + kShown);
  return fmt::format("{} and {} more", join(first, ", "), names.size() - kShown);
}

bool is_identity(const Inertial& inertial) {
  return inertial.inertia == std::array<double, 6>{1, 0, 0, 1, 0, 1};
}

/// True for efforts that no real robot has in all its joints.
bool is_placeholder_effort(double effort) {
  return effort == 1 || effort == 1000 || effort >= 9999;
}

}  // namespace

bool has_body(const std::vector<Shape>& shapes) {
  return std::any_of(shapes.begin(), shapes.end(),
                     [](const Shape& shape) { return shape.kind != ShapeKind::mesh || !shape.pieces.empty(); });
}

std::vector<std::string> links_without_body(const RobotModel& model) {
  std::vector<std::string> out;
  for (const Link& link : model.links)
    if (!has_body(link.collisions) && !(link.collisions.empty() && link.visuals.empty()))
      out.push_back(link.name);
  return out;
}

std::vector<char> links_on_the_floor(const RobotModel& model, bool is_freestanding,
                                     const std::vector<int>& wheel_joints) {
  const bool is_said = !wheel_joints.empty();
  const double highest = caster_height(model, wheel_joints);
  std::vector<std::size_t> wheels;
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (is_said ? is_behind(model, i, wheel_joints) || is_caster(model, i, highest)
                : looks_like_a_wheel(model, i))
      wheels.push_back(i);
  if (!is_said && wheels.size() < kFewest)
    return std::vector<char>(model.links.size(), is_freestanding ? 1 : 0);
  std::vector<char> out(model.links.size(), 0);
  for (std::size_t i = 0; i < model.links.size(); ++i) out[i] = rigid_with_root(model, i) ? 1 : 0;
  for (const std::size_t wheel : wheels) mark_up(model, wheel, out);
  return out;
}

std::vector<std::string> placeholders(const RobotModel& model) {
  std::vector<std::string> out, identities, ones;
  std::vector<double> efforts;
  std::size_t masses = 0;
  for (const int index : model.actuated)
    if (const auto& effort = model.joints[static_cast<std::size_t>(index)].limits.effort)
      efforts.push_back(*effort);
  if (efforts.size() >= kFewest && is_placeholder_effort(efforts.front()) &&
      std::all_of(efforts.begin(), efforts.end(), [&](double e) { return e == efforts.front(); }))
    out.push_back(
        fmt::format("the effort limit of all {} joints is {:g}, which looks like a placeholder: forces and "
                    "payload will be wrong",
                    efforts.size(), efforts.front()));
  for (const Link& link : model.links) {
    if (!link.inertial) continue;
    ++masses;
    if (is_identity(*link.inertial)) identities.push_back(link.name);
    if (link.inertial->mass == 1) ones.push_back(link.name);
  }
  if (!identities.empty())
    out.push_back(
        fmt::format("the inertia of {} is the identity (1 kg m²), which looks like a placeholder: its motion "
                    "in physics will be wrong",
                    some(identities)));
  if (masses > kFewest && ones.size() == masses)
    out.push_back(
        fmt::format("the mass of all {} links is 1 kg, which looks like a placeholder: its motion in physics "
                    "will be wrong",
                    masses));
  return out;
}

}  // namespace polyarm::description
