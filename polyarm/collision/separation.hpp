#pragma once
/// The exact distance between two convex bodies, and how deep they overlap. Metres. Any thread; allocates
/// nothing. Source: Gilbert, Johnson and Keerthi 1988 (GJK); nearest points of simplices after Ericson,
/// Real-Time Collision Detection, 5.1.
#include "polyarm/collision/convex_body.hpp"

namespace polyarm::collision {

struct Separation {
  /// A proven lower bound of the distance, and the distance that was found; they differ by less than 1e-7
  /// unless the search ended early. Both are 0 or negative if the bodies touch.
  double lower = 0, distance = 0;
  Vec3 on_a, on_b;  ///< the nearest points; in the frame of `b`; undefined if they touch
};

/// T_b_a: the pose of the frame of `a` in that of `b`.
Separation separation(const ConvexBody& a, const Pose& T_b_a, const ConvexBody& b) noexcept;

/// The shortest translation that parts two bodies which overlap: never less than the true one, usually within
/// 2 % of it. 0 if they do not overlap.
struct Depth {
  double depth = 0;
  Vec3 direction;  ///< unit, in the frame of `b`: `a` is free after moving by depth along it
};
Depth overlap(const ConvexBody& a, const Pose& T_b_a, const ConvexBody& b) noexcept;

}  // namespace polyarm::collision
