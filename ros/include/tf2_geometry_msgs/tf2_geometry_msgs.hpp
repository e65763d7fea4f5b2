#pragma once
/// Between tf2's types and messages, and transforms of messages.
#include "geometry_msgs/msg/point.hpp"
#include "geometry_msgs/msg/pose.hpp"
#include "geometry_msgs/msg/quaternion.hpp"
#include "geometry_msgs/msg/transform_stamped.hpp"
#include "geometry_msgs/msg/vector3.hpp"
#include "geometry_msgs/msg/wrench.hpp"
#include "geometry_msgs/msg/wrench_stamped.hpp"
#include "tf2/LinearMath/Matrix3x3.hpp"
#include "tf2/transform_datatypes.hpp"

namespace tf2 {
inline geometry_msgs::msg::Quaternion toMsg(const Quaternion& q) {
  geometry_msgs::msg::Quaternion out;
  out.x = q.x(), out.y = q.y(), out.z = q.z(), out.w = q.w();
  return out;
}
inline geometry_msgs::msg::Vector3 toMsg(const Vector3& v) {
  geometry_msgs::msg::Vector3 out;
  out.x = v.x(), out.y = v.y(), out.z = v.z();
  return out;
}
inline void fromMsg(const geometry_msgs::msg::Quaternion& from, Quaternion& to) {
  to.setValue(from.x, from.y, from.z, from.w);
}
template <typename Message>
void fromMsg(const Message& from, Vector3& to) {
  to.setValue(from.x, from.y, from.z);
}
template <typename Message>
void convert(const Message& from, Quaternion& to) {
  fromMsg(from, to);
}
inline void convert(const Quaternion& from, geometry_msgs::msg::Quaternion& to) {
  to = toMsg(from);
}
inline Vector3 rotated(const geometry_msgs::msg::Vector3& v, const geometry_msgs::msg::TransformStamped& t) {
  Quaternion q;
  fromMsg(t.transform.rotation, q);
  return quatRotate(q, {v.x, v.y, v.z});
}
inline void doTransform(const geometry_msgs::msg::Vector3& in, geometry_msgs::msg::Vector3& out,
                        const geometry_msgs::msg::TransformStamped& t) {
  out = toMsg(rotated(in, t));
}
/// A wrench as forces of a free vector: rotated, not moved.
inline void doTransform(const geometry_msgs::msg::Wrench& in, geometry_msgs::msg::Wrench& out,
                        const geometry_msgs::msg::TransformStamped& t) {
  out.force = toMsg(rotated(in.force, t));
  out.torque = toMsg(rotated(in.torque, t));
}
inline void doTransform(const geometry_msgs::msg::WrenchStamped& in, geometry_msgs::msg::WrenchStamped& out,
                        const geometry_msgs::msg::TransformStamped& t) {
  doTransform(in.wrench, out.wrench, t);
  out.header = t.header;
}
}  // namespace tf2
