#pragma once
/// Circles through three points, and rotations in between, for controllers that interpolate. Any thread.
#include <cmath>
#include <numbers>
#include <optional>

#include "polyarm/base/pose.hpp"

namespace polyarm::wire {

/// A rotation `share` of the way from `a` to `b`.
inline Quaternion between(const Quaternion& a, const Quaternion& b, double share) {
  const Vec3 turn = to_rotation_vector(b * inverse(a));
  const double angle = norm(turn);
  return angle > 0 ? from_axis_angle(normalized(turn), share * angle) * a : a;
}

/// The circle on which an arc runs.
struct Circle {
  Vec3 center, axis, arm;  ///< arm: from the center to the beginning
  /// Nothing if the points are on one line.
  static std::optional<Circle> through(const Vec3& from, const Vec3& via, const Vec3& to) {
    const Vec3 u = via - from, v = to - from, w = cross(u, v);
    const double area = dot(w, w);
    if (!(area > 1e-14)) return std::nullopt;
    const Vec3 center = from + (1 / (2 * area)) * (dot(u, u) * cross(v, w) + dot(v, v) * cross(w, u));
    return Circle{center, normalized(w), from - center};
  }
  /// From the beginning, rad in [0, 2 pi).
  double angle_of(const Vec3& point) const {
    const Vec3 p = point - center;
    const double angle = std::atan2(dot(axis, cross(arm, p)), dot(arm, p));
    return angle < 0 ? angle + 2 * std::numbers::pi : angle;
  }
  Vec3 point(double angle) const { return center + from_axis_angle(axis, angle) * arm; }
};

}  // namespace polyarm::wire
