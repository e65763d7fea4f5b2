#pragma once
/// Between KDL's types and messages. KDL is the system's.
#include <kdl/frames.hpp>

#include "geometry_msgs/msg/pose.hpp"
#include "geometry_msgs/msg/transform_stamped.hpp"
#include "geometry_msgs/msg/twist_stamped.hpp"
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
/// Between a vector and a Point or a Vector3.
template <typename Message>
void convert(const KDL::Vector& from, Message& to) {
  to.x = from.x(), to.y = from.y(), to.z = from.z();
}
template <typename Message>
void fromMsg(const Message& from, KDL::Vector& to) {
  to = KDL::Vector(from.x, from.y, from.z);
}
inline void convert(const KDL::Twist& from, geometry_msgs::msg::Twist& to) {
  convert(from.vel, to.linear), convert(from.rot, to.angular);
}
inline void fromMsg(const geometry_msgs::msg::Twist& from, KDL::Twist& to) {
  fromMsg(from.linear, to.vel), fromMsg(from.angular, to.rot);
}
inline void convert(const KDL::Wrench& from, geometry_msgs::msg::Wrench& to) {
  convert(from.force, to.force), convert(from.torque, to.torque);
}
inline void fromMsg(const geometry_msgs::msg::Wrench& from, KDL::Wrench& to) {
  fromMsg(from.force, to.force), fromMsg(from.torque, to.torque);
}
inline void convert(const KDL::Frame& from, geometry_msgs::msg::Pose& to) {
  to = toMsg(from);
}
#define POLYARM_ROS_KDL(TYPE, MESSAGE, FIELD)                                                         \
  POLYARM_ROS_STAMPED_MESSAGE(TYPE, MESSAGE, FIELD)                                                   \
  inline void doTransform(const TYPE& in, TYPE& out, const geometry_msgs::msg::TransformStamped& t) { \
    out = transformToKDL(t) * in;                                                                     \
  }                                                                                                   \
  POLYARM_ROS_STAMPED_TRANSFORM(TYPE)
POLYARM_ROS_KDL(KDL::Vector, PointStamped, point)
POLYARM_ROS_KDL(KDL::Twist, TwistStamped, twist)
POLYARM_ROS_KDL(KDL::Wrench, WrenchStamped, wrench)
POLYARM_ROS_KDL(KDL::Frame, PoseStamped, pose)
#undef POLYARM_ROS_KDL

}  // namespace tf2

#include "tf2_ros/buffer_interface.hpp"
