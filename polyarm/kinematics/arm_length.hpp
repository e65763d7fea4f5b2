#pragma once
/// A reference length for an arm's deviations. Private to this room.
#include "polyarm/kinematics/arm_geometry.hpp"

namespace polyarm::kinematics {

/// The sum of the distances from axis to axis, m. It does not depend on the mounting or on the tool.
inline double length_between_axes(const ArmGeometry& arm) noexcept {
  if (arm.count < 2) return 0;
  // Starts at the point of the first axis that is nearest to the second, if that point is unique.
  const JointAxis &one = arm.axes[0], &two = arm.axes[1];
  const Vec3 square = cross(one.direction, two.direction), way = two.point - one.point;
  const double sine2 = dot(square, square);
  Vec3 at = one.point;
  if (sine2 > 1e-6) at = at + (dot(way, cross(two.direction, square)) / sine2) * one.direction;
  double sum = 0;
  for (std::size_t i = 1; i < arm.count; ++i) {
    const Vec3 away = arm.axes[i].point - at;
    const Vec3 next = away - dot(away, arm.axes[i].direction) * arm.axes[i].direction;
    sum += norm(next);
    at = at + next;
  }
  return sum;
}

}  // namespace polyarm::kinematics
