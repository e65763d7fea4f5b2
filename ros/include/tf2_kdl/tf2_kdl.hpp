#pragma once
/// Between KDL's types and messages. KDL is the system's.
#include <kdl/frames.hpp>

#include "geometry_msgs/msg/pose.hpp"
#include "geometry_msgs/msg/transform_stamped.hpp"
#include "tf2_geometry_msgs/tf2_geometry_msgs.hpp"

namespace tf2 {

inline KDL::Frame transformToKDL(const geometry_msgs::msg::TransformStamped& from) {
  const auto& t = from.transform;
  return {KDL::Rotation::Quaternion(t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w),
          KDL::Vector(t.translation.x, t.translation.y, t.translation.z)};
}
inline geometry_msgs::msg::TransformStamped kdlToTransform(const KDL::Frame& from) {
  geometry_msgs::msg::TransformStamped out;
  auto& t = out.transform;
  t.translation.x = from.p.x(), t.translation.y = from.p.y(), t.translation.z = from.p.z();
  from.M.GetQuaternion(t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w);
  return out;
}
inline geometry_msgs::msg::Pose toMsg(const KDL::Frame& from) {
  const auto t = kdlToTransform(from).transform;
  geometry_msgs::msg::Pose out;
  out.position.x = t.translation.x, out.position.y = t.translation.y, out.position.z = t.translation.z;
  out.orientation = t.rotation;
  return out;
}
inline void fromMsg(const geometry_msgs::msg::Pose& from, KDL::Frame& to) {
  const auto& p = from.position;
  const auto& q = from.orientation;
  to = KDL::Frame(KDL::Rotation::Quaternion(q.x, q.y, q.z, q.w), KDL::Vector(p.x, p.y, p.z));
}

}  // namespace tf2

#include "tf2_ros/buffer_interface.hpp"
