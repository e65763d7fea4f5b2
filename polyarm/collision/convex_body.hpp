#pragma once
/// Convex bodies for exact distances: points of a polyhedron, discs or segments, each with a radius around
/// it. Metres, in the frame of the owner (a link, or the base of the robot). Const functions: any thread.
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::collision {

/// A ball.
struct Ball {
  Vec3 center;
  double radius = 0;
};

/// The convex hull of `points`, each of which is a disc of radius `disc` perpendicular to `axis`, grown by
/// `radius`. A sphere is one point with a radius, a capsule two points, a cylinder two discs.
struct ConvexBody {
  std::vector<Vec3> points;
  double radius = 0;
  double disc = 0;
  Vec3 axis{0, 0, 1};  ///< unit

  /// The point of the body without its radius that is farthest along `direction`.
  Vec3 core_support(const Vec3& direction) const noexcept;
};

/// The body in another frame: T_to_from maps its points.
ConvexBody moved(const Pose& T_to_from, const ConvexBody& body);
/// A ball that contains the body; at most 2 % larger than the smallest.
Ball bounding_ball(const ConvexBody& body);
Ball bounding_ball(const std::vector<ConvexBody>& bodies);
/// A polyhedron with a radius that contains the body: discs become polygons around them.
ConvexBody without_discs(const ConvexBody& body);

/// The bodies of a shape in the frame that the shape's pose refers to. A mesh gives its convex pieces: none
/// if hulls::make_bodies was not called or failed. Throws Error("bad-shape") for NaN, infinite or negative
/// sizes.
std::vector<ConvexBody> bodies_of(const description::Shape& shape);

}  // namespace polyarm::collision
