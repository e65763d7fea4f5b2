#include "polyarm/base/pose.hpp"

#include <algorithm>
#include <numbers>

namespace polyarm {

Quaternion normalized(const Quaternion& q) {
  const double n = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!(n > 0)) return {};
  return {q.x / n, q.y / n, q.z / n, q.w / n};
}

Quaternion from_axis_angle(const Vec3& axis, double angle) {
  const double s = std::sin(angle / 2);
  return {s * axis.x, s * axis.y, s * axis.z, std::cos(angle / 2)};
}

Quaternion from_rpy(double roll, double pitch, double yaw) {
  return from_axis_angle({0, 0, 1}, yaw) * from_axis_angle({0, 1, 0}, pitch) *
         from_axis_angle({1, 0, 0}, roll);
}

Vec3 to_rpy(const Quaternion& q) {
  // Sums of components are products of half angles (of pitch with roll + yaw, and with roll - yaw), which
  // stays exact near pitch = +-pi/2, where the arc sine of the pitch loses half of its digits.
  const double up = std::hypot(q.w + q.y, q.x - q.z), down = std::hypot(q.w - q.y, q.x + q.z);
  const double pitch = 2 * std::atan2(up, down) - std::numbers::pi / 2;
  const double half_sum = std::atan2(q.x + q.z, q.w - q.y),
               half_difference = std::atan2(q.x - q.z, q.w + q.y);
  const auto turn = [](double angle) { return std::remainder(angle, 2 * std::numbers::pi); };
  // At an end of pitch roll and yaw turn about one axis: give it all to roll.
  if (down < 1e-10) return {turn(2 * half_difference), std::numbers::pi / 2, 0};
  if (up < 1e-10) return {turn(2 * half_sum), -std::numbers::pi / 2, 0};
  return {turn(half_sum + half_difference), pitch, turn(half_sum - half_difference)};
}

Vec3 to_rotation_vector(const Quaternion& q_in) {
  const Quaternion q = q_in.w < 0 ? Quaternion{-q_in.x, -q_in.y, -q_in.z, -q_in.w} : q_in;
  const Vec3 v{q.x, q.y, q.z};
  const double s = norm(v);
  if (s < 1e-12) return 2.0 * v;
  return (2 * std::atan2(s, q.w) / s) * v;
}

Quaternion rotation_between(const Vec3& from, const Vec3& to) {
  const double c = dot(from, to);
  if (c < -1 + 1e-12) {  // opposite: any perpendicular axis will do
    const Vec3 other = std::abs(from.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    return from_axis_angle(normalized(cross(from, other)), std::numbers::pi);
  }
  const Vec3 v = cross(from, to);
  return normalized(Quaternion{v.x, v.y, v.z, 1 + c});
}

double angle_between(const Quaternion& a, const Quaternion& b) {
  return norm(to_rotation_vector(inverse(a) * b));
}

}  // namespace polyarm
