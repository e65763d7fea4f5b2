#pragma once
#include "joint_limits/joint_limits.hpp"
#include "urdf/model.hpp"

namespace joint_limits {
/// Takes what the joint states; false if it states no limits.
inline bool getJointLimits(const urdf::JointConstSharedPtr& joint, JointLimits& out) {
  if (!joint || !joint->limits) return false;
  out.has_position_limits =
      joint->type == urdf::Joint::REVOLUTE || joint->type == urdf::Joint::PRISMATIC;
  if (out.has_position_limits) out.min_position = joint->limits->lower, out.max_position = joint->limits->upper;
  out.angle_wraparound = joint->type == urdf::Joint::CONTINUOUS;
  out.has_velocity_limits = out.has_effort_limits = true;
  out.max_velocity = joint->limits->velocity, out.max_effort = joint->limits->effort;
  return true;
}
inline bool getSoftJointLimits(const urdf::JointConstSharedPtr& joint, SoftJointLimits& out) {
  if (!joint || !joint->safety) return false;
  out.min_position = joint->safety->soft_lower_limit, out.max_position = joint->safety->soft_upper_limit;
  out.k_position = joint->safety->k_position, out.k_velocity = joint->safety->k_velocity;
  return true;
}
}  // namespace joint_limits
