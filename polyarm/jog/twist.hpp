#pragma once
/// Velocities and small motions of the TCP as six numbers. Metres, radians, seconds. Any thread; nothing
/// allocates.
#include <array>
#include <cmath>

#include "polyarm/base/pose.hpp"

namespace polyarm::jog {

/// linear x y z (m/s), angular x y z (rad/s).
using Twist = std::array<double, 6>;

/// Magnitude of the linear part, m/s.
inline double linear(const Twist& t) noexcept {
  return std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
}
/// Magnitude of the angular part, rad/s.
inline double angular(const Twist& t) noexcept {
  return std::sqrt(t[3] * t[3] + t[4] * t[4] + t[5] * t[5]);
}
/// The twist in other axes; `r` rotates the axes of `t` to those of the result.
inline Twist turned(const Quaternion& r, const Twist& t) noexcept {
  const Vec3 v = r * Vec3{t[0], t[1], t[2]}, w = r * Vec3{t[3], t[4], t[5]};
  return {v.x, v.y, v.z, w.x, w.y, w.z};
}
/// The difference from `a` to `b` in the world: translation (m) and rotation vector (rad).
inline Twist between(const Pose& a, const Pose& b) noexcept {
  const Vec3 d = b.position - a.position, r = to_rotation_vector(b.rotation * inverse(a.rotation));
  return {d.x, d.y, d.z, r.x, r.y, r.z};
}
/// Moves a pose by a translation (m) and a rotation vector (rad), in the world.
inline void advance(Pose& pose, const Twist& by) noexcept {
  pose.position = pose.position + Vec3{by[0], by[1], by[2]};
  const Vec3 r{by[3], by[4], by[5]};
  const double angle = norm(r);
  if (angle > 0) pose.rotation = normalized(from_axis_angle((1 / angle) * r, angle) * pose.rotation);
}

}  // namespace polyarm::jog
