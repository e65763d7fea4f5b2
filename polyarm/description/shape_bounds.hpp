#pragma once
/// The axis-aligned box around a shape. Metres, in the frame of the pose that is given. Any thread; no
/// allocation.
#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

struct Bounds {
  Vec3 lower, upper;
  /// True if the boxes are nearer than `margin`; with a negative one, if they overlap by more than that.
  bool near(const Bounds& other, double margin) const noexcept;
  bool contains(const Vec3& p) const noexcept;
};
/// `pose`: of the frame in which the shape has its own pose. A mesh counts by its convex pieces, and as a
/// point without them.
Bounds bounds_of(const Shape& shape, const Pose& pose) noexcept;

}  // namespace polyarm::description
