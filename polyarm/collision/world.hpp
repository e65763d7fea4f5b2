#pragma once
/// What a robot must not touch: named convex bodies and half-spaces, in the world. Metres. Plain data; const
/// functions: any thread.
#include <string>
#include <vector>

#include "polyarm/collision/convex_body.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::collision {

/// The most bodies of a world, and the most corners of one.
inline constexpr std::size_t kMostObstacles = 20'000, kMostCorners = 1000;

/// All points p with dot(normal, p) <= offset are solid.
struct HalfSpace {
  Vec3 normal{0, 0, 1};  ///< unit, out of the solid
  double offset = 0;
};

struct Obstacle {
  std::string name;                                            ///< as a user knows it: "fixture table"
  description::ShapeKind kind = description::ShapeKind::mesh;  ///< mesh: a convex piece
  ConvexBody body;                                             ///< in the world
  Pose pose;  ///< box, cylinder, capsule, sphere: of its middle, z along its axis
  Vec3 half;  ///< box: half of its edges
  bool is_half_space = false;
  HalfSpace half_space;
};

class World {
 public:
  /// Adds a shape whose own pose refers to the frame T_world_frame. Throws Error("bad-shape") as bodies_of()
  /// does, Error("bad-pose") for a pose with NaN, infinity or without a rotation, Error("too-many") above the
  /// bounds.
  void add(const std::string& name, const description::Shape& shape, const Pose& T_world_frame = {});
  /// Throws Error("bad-pose") if the numbers are not finite or the normal has no length.
  void add(const std::string& name, const HalfSpace& half_space);

  const std::vector<Obstacle>& obstacles() const noexcept { return obstacles_; }

 private:
  void add(Obstacle obstacle);
  std::vector<Obstacle> obstacles_;
};

}  // namespace polyarm::collision
