#pragma once
/// Worlds around an arm at the origin that tests and the benchmark share: a table with boxes, a cage of bars,
/// a shelf.
#include <string>
#include <vector>

#include "polyarm/collision/world.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/kinematics/random.hpp"

namespace polyarm::planning {

inline void add_box(collision::World& world, const std::string& name, const Vec3& size, const Vec3& at,
                    double yaw = 0) {
  description::Shape box;
  box.size = size;
  world.add(name, box, {at, from_rpy(0, 0, yaw)});
}

/// A table top under the base, and boxes, a can and a ball on it.
inline collision::World table_world() {
  collision::World out;
  add_box(out, "table", {1.8, 1.8, 0.04}, {0.3, 0, -0.03});
  add_box(out, "crate", {0.3, 0.2, 0.3}, {0.5, 0.35, 0.15}, 0.4);
  add_box(out, "box", {0.2, 0.2, 0.4}, {0.45, -0.35, 0.2}, -0.2);
  add_box(out, "wall", {0.04, 0.6, 0.35}, {0.55, 0, 0.175});
  description::Shape can;
  can.kind = description::ShapeKind::cylinder;
  can.radius = 0.05, can.length = 0.25;
  out.add("can", can, {{-0.3, 0.45, 0.125}, {}});
  return out;
}

/// Bars on all sides, and a roof.
inline collision::World cage_world() {
  collision::World out;
  add_box(out, "floor plate", {1.6, 1.6, 0.04}, {0, 0, -0.03});
  for (int i = 0; i < 10; ++i) {
    const double angle = 2 * M_PI * i / 10;
    add_box(out, "bar " + std::to_string(i + 1), {0.05, 0.05, 1.3},
            {0.62 * std::cos(angle), 0.62 * std::sin(angle), 0.65}, angle);
  }
  for (const double z : {0.35, 0.75}) {
    add_box(out, "front rail", {0.04, 0.8, 0.04}, {0.62, 0, z});
    add_box(out, "side rail", {0.8, 0.04, 0.04}, {0, 0.62, z});
  }
  return out;
}

/// A bookshelf in front of the arm, on both sides of which there is room.
inline collision::World shelf_world() {
  collision::World out;
  add_box(out, "table", {1.4, 1.6, 0.04}, {0.2, 0, -0.03});
  for (const double y : {-0.4, 0.0, 0.4}) add_box(out, "side board", {0.3, 0.02, 0.9}, {0.6, y, 0.45});
  for (const double z : {0.02, 0.32, 0.62, 0.92}) add_box(out, "shelf board", {0.3, 0.82, 0.02}, {0.6, 0, z});
  add_box(out, "back", {0.02, 0.82, 0.9}, {0.76, 0, 0.45});
  for (const double y : {-0.25, 0.2, 0.3}) add_box(out, "book", {0.16, 0.03, 0.2}, {0.63, y, 0.44});
  return out;
}

}  // namespace polyarm::planning
