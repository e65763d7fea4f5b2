#pragma once
/// Between Eigen's types and messages, and transforms of Eigen's types.
#include <Eigen/Geometry>

#include "geometry_msgs/msg/twist.hpp"
#include "tf2_geometry_msgs/tf2_geometry_msgs.hpp"

namespace tf2 {

inline Eigen::Isometry3d transformToEigen(const geometry_msgs::msg::Transform& t) {
  return Eigen::Isometry3d(Eigen::Translation3d(t.translation.x, t.translation.y, t.translation.z) *
                           Eigen::Quaterniond(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z));
}
inline Eigen::Isometry3d transformToEigen(const geometry_msgs::msg::TransformStamped& t) {
  return transformToEigen(t.transform);
}
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
/// Only its translation and rotation.
inline geometry_msgs::msg::TransformStamped eigenToTransform(const Eigen::Affine3d& from) {
  Eigen::Isometry3d rigid = Eigen::Isometry3d::Identity();
  rigid.linear() = from.rotation(), rigid.translation() = from.translation();
  return eigenToTransform(rigid);
}

template <int mode>
geometry_msgs::msg::Pose toMsg(const Eigen::Transform<double, 3, mode>& from) {
  const auto t = eigenToTransform(from).transform;
  geometry_msgs::msg::Pose out;
  out.position.x = t.translation.x, out.position.y = t.translation.y, out.position.z = t.translation.z;
  out.orientation = t.rotation;
  return out;
}
template <int mode>
geometry_msgs::msg::Pose& toMsg(const Eigen::Transform<double, 3, mode>& from,
                                geometry_msgs::msg::Pose& out) {
  return out = toMsg(from);
}
inline geometry_msgs::msg::Point toMsg(const Eigen::Vector3d& from) {
  geometry_msgs::msg::Point out;
  out.x = from.x(), out.y = from.y(), out.z = from.z();
  return out;
}
/// Into a Point or a Vector3.
template <typename Message>
Message& toMsg(const Eigen::Vector3d& from, Message& out) {
  out.x = from.x(), out.y = from.y(), out.z = from.z();
  return out;
}
inline geometry_msgs::msg::Quaternion toMsg(const Eigen::Quaterniond& q) {
  return toMsg(Quaternion(q.x(), q.y(), q.z(), q.w()));
}
inline geometry_msgs::msg::Quaternion& toMsg(const Eigen::Quaterniond& q,
                                             geometry_msgs::msg::Quaternion& out) {
  return out = toMsg(q);
}
/// Linear, then angular.
inline geometry_msgs::msg::Twist toMsg(const Eigen::Matrix<double, 6, 1>& from) {
  geometry_msgs::msg::Twist out;
  toMsg(Eigen::Vector3d(from.head<3>()), out.linear);
  toMsg(Eigen::Vector3d(from.tail<3>()), out.angular);
  return out;
}
/// Force, then torque.
inline geometry_msgs::msg::Wrench& toMsg(const Eigen::Matrix<double, 6, 1>& from,
                                         geometry_msgs::msg::Wrench& out) {
  toMsg(Eigen::Vector3d(from.head<3>()), out.force);
  toMsg(Eigen::Vector3d(from.tail<3>()), out.torque);
  return out;
}

template <int mode>
void fromMsg(const geometry_msgs::msg::Pose& from, Eigen::Transform<double, 3, mode>& to) {
  const auto& q = from.orientation;
  to = Eigen::Translation3d(from.position.x, from.position.y, from.position.z) *
       Eigen::Quaterniond(q.w, q.x, q.y, q.z);
}
template <int mode>
void fromMsg(const geometry_msgs::msg::Transform& from, Eigen::Transform<double, 3, mode>& to) {
  to = Eigen::Transform<double, 3, mode>(transformToEigen(from).matrix());
}
template <typename Message>
void fromMsg(const Message& from, Eigen::Vector3d& to) {
  to = {from.x, from.y, from.z};
}
inline void fromMsg(const geometry_msgs::msg::Quaternion& from, Eigen::Quaterniond& to) {
  to = Eigen::Quaterniond(from.w, from.x, from.y, from.z);
}
inline void fromMsg(const geometry_msgs::msg::Twist& from, Eigen::Matrix<double, 6, 1>& to) {
  to << from.linear.x, from.linear.y, from.linear.z, from.angular.x, from.angular.y, from.angular.z;
}
template <int mode>
void convert(const Eigen::Transform<double, 3, mode>& from, geometry_msgs::msg::Pose& to) {
  to = toMsg(from);
}
template <typename Message>
void convert(const Eigen::Vector3d& from, Message& to) {
  toMsg(from, to);
}
inline void convert(const Eigen::Quaterniond& from, geometry_msgs::msg::Quaternion& to) {
  to = toMsg(from);
}
template <typename Message>
auto convert(const Message& from, Eigen::Vector3d& to) -> decltype(from.x, void()) {
  fromMsg(from, to);
}
inline void convert(const geometry_msgs::msg::Quaternion& from, Eigen::Quaterniond& to) {
  fromMsg(from, to);
}
template <int mode>
void convert(const geometry_msgs::msg::Pose& from, Eigen::Transform<double, 3, mode>& to) {
  fromMsg(from, to);
}

inline void doTransform(const Eigen::Vector3d& in, Eigen::Vector3d& out,
                        const geometry_msgs::msg::TransformStamped& t) {
  out = transformToEigen(t) * in;
}
inline void doTransform(const Eigen::Quaterniond& in, Eigen::Quaterniond& out,
                        const geometry_msgs::msg::TransformStamped& t) {
  out = Eigen::Quaterniond(transformToEigen(t).rotation()) * in;
}
template <int mode>
void doTransform(const Eigen::Transform<double, 3, mode>& in, Eigen::Transform<double, 3, mode>& out,
                 const geometry_msgs::msg::TransformStamped& t) {
  out = Eigen::Transform<double, 3, mode>(transformToEigen(t) * in);
}
#define POLYARM_ROS_EIGEN(TYPE, MESSAGE, FIELD)     \
  POLYARM_ROS_STAMPED_MESSAGE(TYPE, MESSAGE, FIELD) \
  POLYARM_ROS_STAMPED_TRANSFORM(TYPE)
POLYARM_ROS_EIGEN(Eigen::Vector3d, PointStamped, point)
POLYARM_ROS_EIGEN(Eigen::Quaterniond, QuaternionStamped, quaternion)
POLYARM_ROS_EIGEN(Eigen::Affine3d, PoseStamped, pose)
POLYARM_ROS_EIGEN(Eigen::Isometry3d, PoseStamped, pose)
#undef POLYARM_ROS_EIGEN

}  // namespace tf2

#include "tf2_ros/buffer_interface.hpp"
