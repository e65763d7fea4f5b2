#pragma once
/// The base of limiters, and the limiters under the names that a class loader knows.
#include <string>

#include "joint_limits/joint_saturation_limiter.hpp"
#include "joint_limits/joint_soft_limiter.hpp"
#include "joint_limits/limiter_base.hpp"
#include "pluginlib/class_loader.hpp"

namespace joint_limits {
template <typename Limiter, typename Kind>
void describe(const std::string& name, const char* base) {
  polyarm_ros::described_types().try_emplace(name, name);
  polyarm_ros::exported_classes().try_emplace(
      name, polyarm_ros::ExportedClass{
                base, []() -> void* { return static_cast<JointLimiterInterface<Kind>*>(new Limiter); }});
}
inline bool describe_limiters() {
  using Point = trajectory_msgs::msg::JointTrajectoryPoint;
  using OneJoint = JointControlInterfacesData;
  constexpr const char* kOfOne =
      "joint_limits::JointLimiterInterface<joint_limits::JointControlInterfacesData>";
  describe<JointSaturationLimiter<Point>, Point>(
      "joint_limits/JointTrajectoryPointSaturationLimiter",
      "joint_limits::JointLimiterInterface<trajectory_msgs::msg::JointTrajectoryPoint>");
  describe<JointSaturationLimiter<JointLimits>, JointLimits>(
      "joint_limits/JointSaturationLimiter",
      "joint_limits::JointLimiterInterface<joint_limits::JointLimits>");
  describe<JointSaturationLimiter<OneJoint>, OneJoint>("joint_limits/JointInterfacesSaturationLimiter",
                                                       kOfOne);
  describe<JointSoftLimiter, OneJoint>("joint_limits/JointInterfacesSoftLimiter", kOfOne);
  return true;
}
inline const bool limiters_are_described = describe_limiters();
}  // namespace joint_limits
