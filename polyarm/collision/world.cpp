#include "polyarm/collision/world.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"

namespace polyarm::collision {

using description::Shape;
using description::ShapeKind;

namespace {

bool finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Pose checked(const std::string& name, Pose pose) {
  const Quaternion& r = pose.rotation;
  const double length = std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w);
  if (!finite(pose.position) || !std::isfinite(length) || length < 1e-6)
    throw Error("bad-pose", "the pose of " + name + " contains NaN or infinity, or has no rotation",
                "give finite numbers and a unit quaternion");
  pose.rotation = normalized(r);
  return pose;
}

}  // namespace

void World::add(Obstacle obstacle) {
  if (obstacles_.size() >= kMostObstacles)
    throw Error("too-many", fmt::format("the world has more than {} bodies", kMostObstacles),
                "leave out what the robot cannot reach");
  if (obstacle.body.points.size() > kMostCorners)
    throw Error("too-many",
                fmt::format("{} has a convex piece with {} corners, the most are {}", obstacle.name,
                            obstacle.body.points.size(), kMostCorners),
                "simplify its mesh");
  obstacles_.push_back(std::move(obstacle));
}

void World::add(const std::string& name, const Shape& shape, const Pose& T_world_frame) {
  Shape own = shape;
  own.pose = checked(name, shape.pose);
  const Pose frame = checked(name, T_world_frame);
  for (const ConvexBody& body : bodies_of(own)) {
    Obstacle obstacle;
    obstacle.name = name;
    obstacle.kind = shape.kind;
    obstacle.body = moved(frame, body);
    obstacle.pose = frame * own.pose;
    obstacle.half = 0.5 * shape.size;
    add(std::move(obstacle));
  }
}

void World::add(const std::string& name, const HalfSpace& half_space) {
  const double length = norm(half_space.normal);
  if (!finite(half_space.normal) || !std::isfinite(half_space.offset) || !(length > 1e-9))
    throw Error("bad-pose", "the plane " + name + " has no direction, or contains NaN or infinity",
                "give a normal and an offset");
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.is_half_space = true;
  obstacle.half_space = {(1 / length) * half_space.normal, half_space.offset / length};
  add(std::move(obstacle));
}

}  // namespace polyarm::collision
