#pragma once
#include <Eigen/Geometry>

#include "tf2_geometry_msgs/tf2_geometry_msgs.hpp"

namespace tf2 {
inline geometry_msgs::msg::TransformStamped eigenToTransform(const Eigen::Isometry3d& from) {
  geometry_msgs::msg::TransformStamped out;
  const Eigen::Quaterniond q(from.rotation());
  const Eigen::Vector3d p = from.translation();
  out.transform.translation.x = p.x(), out.transform.translation.y = p.y();
  out.transform.translation.z = p.z();
  out.transform.rotation.x = q.x(), out.transform.rotation.y = q.y();
  out.transform.rotation.z = q.z(), out.transform.rotation.w = q.w();
  return out;
}
inline geometry_msgs::msg::Pose toMsg(const Eigen::Isometry3d& from) {
  const auto t = eigenToTransform(from).transform;
  geometry_msgs::msg::Pose out;
  out.position.x = t.translation.x, out.position.y = t.translation.y, out.position.z = t.translation.z;
  out.orientation = t.rotation;
  return out;
}
inline geometry_msgs::msg::Quaternion toMsg(const Eigen::Quaterniond& q) {
  return toMsg(Quaternion(q.x(), q.y(), q.z(), q.w()));
}
inline void fromMsg(const geometry_msgs::msg::Pose& from, Eigen::Isometry3d& to) {
  const auto& q = from.orientation;
  to = Eigen::Translation3d(from.position.x, from.position.y, from.position.z) *
       Eigen::Quaterniond(q.w, q.x, q.y, q.z);
}
template <typename Message>
void fromMsg(const Message& from, Eigen::Vector3d& to) {
  to = {from.x, from.y, from.z};
}
}  // namespace tf2
