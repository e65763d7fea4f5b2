#pragma once
/// Poses and their algebra, in standard types only, so that plugin headers need no matrix library. Lengths
/// are in metres, angles in radians.
#include <array>
#include <cmath>

namespace polyarm {

struct Vec3 {
  double x = 0, y = 0, z = 0;
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Vec3 operator-(const Vec3& a) {
  return {-a.x, -a.y, -a.z};
}
constexpr Vec3 operator*(double s, const Vec3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
constexpr double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
/// The unit vector along `a`; z if `a` is zero.
inline Vec3 normalized(const Vec3& a) {
  const double n = norm(a);
  return n > 0 ? (1.0 / n) * a : Vec3{0, 0, 1};
}

/// A rotation as a unit quaternion, stored x y z w.
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
  friend bool operator==(const Quaternion&, const Quaternion&) = default;
};

constexpr Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
constexpr Quaternion inverse(const Quaternion& q) {
  return {-q.x, -q.y, -q.z, q.w};
}
constexpr Vec3 operator*(const Quaternion& q, const Vec3& v) {
  const Vec3 u{q.x, q.y, q.z};
  const Vec3 t = 2.0 * cross(u, v);
  return v + q.w * t + cross(u, t);
}
Quaternion normalized(const Quaternion& q);
/// Roll, pitch, yaw about fixed x, y, z: R = Rz(yaw) Ry(pitch) Rx(roll), as in URDF.
Quaternion from_rpy(double roll, double pitch, double yaw);
/// The inverse of from_rpy. Pitch is in [-pi/2, pi/2]; yaw is 0 where pitch is +-pi/2.
Vec3 to_rpy(const Quaternion& q);
Quaternion from_axis_angle(const Vec3& unit_axis, double angle);
/// The rotation vector (axis times angle, angle in [0, pi]) of `q`.
Vec3 to_rotation_vector(const Quaternion& q);
/// The shortest rotation that turns unit vector `from` into unit vector `to`.
Quaternion rotation_between(const Vec3& from, const Vec3& to);
/// The angle of the rotation from `a` to `b`, in [0, pi].
double angle_between(const Quaternion& a, const Quaternion& b);

/// T_a_b: maps coordinates in b into coordinates in a. T_a_b * T_b_c = T_a_c.
struct Pose {
  Vec3 position;
  Quaternion rotation;
  friend bool operator==(const Pose&, const Pose&) = default;
};

constexpr Pose operator*(const Pose& a, const Pose& b) {
  return {a.position + a.rotation * b.position, a.rotation * b.rotation};
}
constexpr Vec3 operator*(const Pose& a, const Vec3& p) {
  return a.position + a.rotation * p;
}
constexpr Pose inverse(const Pose& a) {
  const Quaternion r = inverse(a.rotation);
  return {-(r * a.position), r};
}
inline Pose pose_xyz_rpy(const Vec3& xyz, const Vec3& rpy) {
  return {xyz, from_rpy(rpy.x, rpy.y, rpy.z)};
}

}  // namespace polyarm
