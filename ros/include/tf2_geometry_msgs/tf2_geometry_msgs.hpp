#pragma once
/// Between tf2's types and messages, and transforms of messages.
#include "builtin_interfaces/msg/time.hpp"
#include "geometry_msgs/msg/point.hpp"
#include "geometry_msgs/msg/point_stamped.hpp"
#include "geometry_msgs/msg/pose.hpp"
#include "geometry_msgs/msg/pose_stamped.hpp"
#include "geometry_msgs/msg/quaternion.hpp"
#include "geometry_msgs/msg/quaternion_stamped.hpp"
#include "geometry_msgs/msg/transform.hpp"
#include "geometry_msgs/msg/transform_stamped.hpp"
#include "geometry_msgs/msg/vector3.hpp"
#include "geometry_msgs/msg/vector3_stamped.hpp"
#include "geometry_msgs/msg/wrench.hpp"
#include "geometry_msgs/msg/wrench_stamped.hpp"
#include "tf2/transform_datatypes.hpp"

namespace tf2 {
namespace gm = geometry_msgs::msg;

inline gm::Quaternion toMsg(const Quaternion& q) {
  gm::Quaternion out;
  out.x = q.x(), out.y = q.y(), out.z = q.z(), out.w = q.w();
  return out;
}
inline gm::Vector3 toMsg(const Vector3& v) {
  gm::Vector3 out;
  out.x = v.x(), out.y = v.y(), out.z = v.z();
  return out;
}
/// Into a Point or a Vector3.
template <typename Message>
Message& toMsg(const Vector3& v, Message& out) {
  out.x = v.x(), out.y = v.y(), out.z = v.z();
  return out;
}
inline gm::Transform toMsg(const Transform& t) {
  gm::Transform out;
  out.translation = toMsg(t.getOrigin()), out.rotation = toMsg(t.getRotation());
  return out;
}
inline gm::Pose& toMsg(const Transform& t, gm::Pose& out) {
  toMsg(t.getOrigin(), out.position), out.orientation = toMsg(t.getRotation());
  return out;
}
inline void fromMsg(const gm::Quaternion& from, Quaternion& to) {
  to.setValue(from.x, from.y, from.z, from.w);
}
template <typename Message>
void fromMsg(const Message& from, Vector3& to) {
  to.setValue(from.x, from.y, from.z);
}
inline void fromMsg(const gm::Transform& from, Transform& to) {
  to = Transform(Quaternion(from.rotation.x, from.rotation.y, from.rotation.z, from.rotation.w),
                 Vector3(from.translation.x, from.translation.y, from.translation.z));
}
inline void fromMsg(const gm::Pose& from, Transform& to) {
  to = Transform(Quaternion(from.orientation.x, from.orientation.y, from.orientation.z, from.orientation.w),
                 Vector3(from.position.x, from.position.y, from.position.z));
}
template <typename Message, typename To>
auto convert(const Message& from, To& to) -> decltype(fromMsg(from, to)) {
  fromMsg(from, to);
}
inline void convert(const Quaternion& from, gm::Quaternion& to) {
  to = toMsg(from);
}
inline void convert(const Vector3& from, gm::Vector3& to) {
  to = toMsg(from);
}
inline void convert(const Transform& from, gm::Transform& to) {
  to = toMsg(from);
}

inline builtin_interfaces::msg::Time toMsg(const TimePoint& time) {
  const auto ns = time.time_since_epoch().count();
  const auto rest = (ns % 1000000000 + 1000000000) % 1000000000;
  builtin_interfaces::msg::Time out;
  out.sec = static_cast<std::int32_t>((ns - rest) / 1000000000),
  out.nanosec = static_cast<std::uint32_t>(rest);
  return out;
}
inline TimePoint fromMsg(const builtin_interfaces::msg::Time& time) {
  return TimePoint(std::chrono::seconds(time.sec) + std::chrono::nanoseconds(time.nanosec));
}
template <typename T>
TimePoint getTimestamp(const T& from) {
  return fromMsg(from.header.stamp);
}
template <typename T>
TimePoint getTimestamp(const Stamped<T>& from) {
  return from.stamp_;
}
template <typename T>
std::string getFrameId(const T& from) {
  return from.header.frame_id;
}
template <typename T>
std::string getFrameId(const Stamped<T>& from) {
  return from.frame_id_;
}
/// Between a stamped value and the message whose FIELD has the value.
#define POLYARM_ROS_STAMPED_VALUE(TYPE, MESSAGE, FIELD)                          \
  inline gm::MESSAGE& toMsg(const Stamped<TYPE>& from, gm::MESSAGE& out) {       \
    out.header.stamp = toMsg(from.stamp_), out.header.frame_id = from.frame_id_; \
    convert(static_cast<const TYPE&>(from), out.FIELD);                          \
    return out;                                                                  \
  }                                                                              \
  inline void convert(const Stamped<TYPE>& from, gm::MESSAGE& to) {              \
    toMsg(from, to);                                                             \
  }                                                                              \
  inline void fromMsg(const gm::MESSAGE& from, Stamped<TYPE>& to) {              \
    to.stamp_ = fromMsg(from.header.stamp), to.frame_id_ = from.header.frame_id; \
    fromMsg(from.FIELD, static_cast<TYPE&>(to));                                 \
  }
/// The same for the message that stands for the value.
#define POLYARM_ROS_STAMPED_MESSAGE(TYPE, MESSAGE, FIELD) \
  POLYARM_ROS_STAMPED_VALUE(TYPE, MESSAGE, FIELD)         \
  inline gm::MESSAGE toMsg(const Stamped<TYPE>& from) {   \
    gm::MESSAGE out;                                      \
    return toMsg(from, out);                              \
  }
/// A transform of a stamped value, of one that transforms the value.
#define POLYARM_ROS_STAMPED_TRANSFORM(TYPE)                                                             \
  inline void doTransform(const Stamped<TYPE>& in, Stamped<TYPE>& out, const gm::TransformStamped& t) { \
    doTransform(static_cast<const TYPE&>(in), static_cast<TYPE&>(out), t);                              \
    out.stamp_ = fromMsg(t.header.stamp), out.frame_id_ = t.header.frame_id;                            \
  }
inline void convert(const Vector3& from, gm::Point& to) {
  toMsg(from, to);
}
inline void convert(const Transform& from, gm::Pose& to) {
  toMsg(from, to);
}
POLYARM_ROS_STAMPED_MESSAGE(Vector3, Vector3Stamped, vector)
POLYARM_ROS_STAMPED_VALUE(Vector3, PointStamped, point)
POLYARM_ROS_STAMPED_MESSAGE(Quaternion, QuaternionStamped, quaternion)
POLYARM_ROS_STAMPED_MESSAGE(Transform, TransformStamped, transform)
POLYARM_ROS_STAMPED_VALUE(Transform, PoseStamped, pose)

inline Transform transform_of(const gm::TransformStamped& t) {
  Transform out;
  fromMsg(t.transform, out);
  return out;
}
/// A Vector3 is a direction: it is rotated only.
inline void doTransform(const gm::Vector3& in, gm::Vector3& out, const gm::TransformStamped& t) {
  out = toMsg(transform_of(t).getBasis() * Vector3(in.x, in.y, in.z));
}
inline void doTransform(const gm::Point& in, gm::Point& out, const gm::TransformStamped& t) {
  toMsg(transform_of(t)(Vector3(in.x, in.y, in.z)), out);
}
inline void doTransform(const gm::Quaternion& in, gm::Quaternion& out, const gm::TransformStamped& t) {
  out = toMsg(transform_of(t).getRotation() * Quaternion(in.x, in.y, in.z, in.w));
}
inline void doTransform(const gm::Pose& in, gm::Pose& out, const gm::TransformStamped& t) {
  Transform pose;
  fromMsg(in, pose);
  toMsg(transform_of(t) * pose, out);
}
inline void doTransform(const gm::Transform& in, gm::Transform& out, const gm::TransformStamped& t) {
  Transform inner;
  fromMsg(in, inner);
  out = toMsg(transform_of(t) * inner);
}
/// A wrench as forces of a free vector: rotated, not moved.
inline void doTransform(const gm::Wrench& in, gm::Wrench& out, const gm::TransformStamped& t) {
  doTransform(in.force, out.force, t);
  doTransform(in.torque, out.torque, t);
}
#define POLYARM_ROS_STAMPED(TYPE, FIELD)                                                    \
  inline void doTransform(const gm::TYPE& in, gm::TYPE& out, const gm::TransformStamped& t) { \
    doTransform(in.FIELD, out.FIELD, t);                                                    \
    out.header = t.header;                                                                  \
  }
POLYARM_ROS_STAMPED(Vector3Stamped, vector)
POLYARM_ROS_STAMPED(PointStamped, point)
POLYARM_ROS_STAMPED(QuaternionStamped, quaternion)
POLYARM_ROS_STAMPED(PoseStamped, pose)
POLYARM_ROS_STAMPED(WrenchStamped, wrench)
#undef POLYARM_ROS_STAMPED
inline void doTransform(const gm::TransformStamped& in, gm::TransformStamped& out, const gm::TransformStamped& t) {
  doTransform(in.transform, out.transform, t);
  out.header = t.header;
}
}  // namespace tf2

#include "rclcpp/rclcpp.hpp"
