#pragma once
/// Arms that are in no catalogue, made of those that are: what their makers and users do to them.
#include <cmath>
#include <numbers>
#include <string>

#include "polyarm/description/robot_model.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_states.hpp"

namespace polyarm::test {

/// Joints of `model` that move and follow no other, from the base to `tip`.
inline std::vector<int> moving_joints(const description::RobotModel& model, int tip) {
  std::vector<int> out;
  for (int link = tip; model.links[static_cast<std::size_t>(link)].parent_joint >= 0;) {
    const int j = model.links[static_cast<std::size_t>(link)].parent_joint;
    const auto& joint = model.joints[static_cast<std::size_t>(j)];
    if (joint.moves() && !joint.mimic) out.insert(out.begin(), j);
    link = joint.parent_link;
  }
  return out;
}

/// The same arm, its joint counted the other way.
inline void turn_round(description::RobotModel& model, int j) {
  description::Joint& joint = model.joints[static_cast<std::size_t>(j)];
  joint.axis = -joint.axis;
  const auto lower = joint.limits.lower;
  joint.limits.lower = joint.limits.upper;
  joint.limits.upper = lower;
  if (joint.limits.lower) joint.limits.lower = -*joint.limits.lower;
  if (joint.limits.upper) joint.limits.upper = -*joint.limits.upper;
  for (description::Joint& other : model.joints)
    if (other.mimic && other.mimic->joint == j) other.mimic->multiplier = -other.mimic->multiplier;
}

/// The same arm, with a fixed joint more before joint `j`.
inline void split_before(description::RobotModel& model, int j, const Pose& there) {
  const int link = static_cast<int>(model.links.size()), added = static_cast<int>(model.joints.size());
  description::Joint fixed;
  fixed.name = "added_" + std::to_string(added);
  fixed.type = description::JointType::fixed;
  fixed.parent_link = model.joints[static_cast<std::size_t>(j)].parent_link;
  fixed.child_link = link;
  fixed.origin = there;
  model.links.push_back({fixed.name, {}, {}, {}, added});
  model.joints.push_back(fixed);
  description::Joint& joint = model.joints[static_cast<std::size_t>(j)];
  joint.parent_link = link;
  joint.origin = inverse(there) * joint.origin;
}

/// An arm on a slide more: a joint before joint `j` that slides along `direction`.
inline void slide_before(description::RobotModel& model, int j, const Vec3& direction) {
  split_before(model, j, {});
  description::Joint& joint = model.joints.back();
  joint.type = description::JointType::prismatic;
  joint.axis = direction;
  joint.limits.lower = -0.4, joint.limits.upper = 0.5;
  model.actuated.push_back(static_cast<int>(model.joints.size()) - 1);
}

/// Joint `j` follows joint `other`, as linkages and belts make it.
inline void follow(description::RobotModel& model, int j, int other, double multiplier, double offset) {
  model.joints[static_cast<std::size_t>(j)].mimic = {other, multiplier, offset};
  std::erase(model.actuated, j);
}

/// Joint `j` where it stands at `value`, for good.
inline void hold(description::RobotModel& model, int j, double value) {
  description::Joint& joint = model.joints[static_cast<std::size_t>(j)];
  joint.origin = joint.origin * (joint.type == description::JointType::prismatic
                                     ? Pose{value * joint.axis, {}}
                                     : Pose{{}, from_axis_angle(joint.axis, value)});
  joint.type = description::JointType::fixed;
  joint.limits = {};
  std::erase(model.actuated, j);
}

/// Every joint's place and direction off by up to `size`, m and rad.
inline void spoil(description::RobotModel& model, double size, kinematics::Random& random) {
  for (description::Joint& joint : model.joints) {
    joint.origin.position = joint.origin.position + random_vector(random, size);
    joint.origin.rotation =
        joint.origin.rotation * from_axis_angle(random_direction(random), random.between(-size, size));
  }
}

/// Limits of one turning joint as descriptions have them: none, turns, far from zero, or hardly any.
inline void limit_oddly(description::Joint& joint, kinematics::Random& random) {
  if (joint.type == description::JointType::prismatic) return;
  const double kind = random.unit();
  joint.type = description::JointType::revolute;
  if (kind < 0.25) {
    joint.type = description::JointType::continuous;
    joint.limits.lower.reset();
    joint.limits.upper.reset();
  } else if (kind < 0.5) {
    joint.limits.lower = -random.between(4, 20), joint.limits.upper = random.between(4, 20);
  } else if (kind < 0.75) {
    joint.limits.lower = random.between(-9, 5),
    joint.limits.upper = *joint.limits.lower + random.between(2, 9);
  } else {
    joint.limits.lower = random.between(-3, 2), joint.limits.upper = *joint.limits.lower + 0.5;
  }
}

}  // namespace polyarm::test
