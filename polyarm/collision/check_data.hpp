#pragma once
/// Makes the arrays of the kernels from a robot and a world. Private to this room.
#include <vector>

#include "polyarm/collision/box_tree.hpp"
#include "polyarm/collision/check_model.hpp"
#include "polyarm/collision/robot_body.hpp"
#include "polyarm/collision/world.hpp"

namespace polyarm::collision {

/// Owns what its `model` points to; so it is not copied.
struct CheckData {
  CheckData() = default;
  CheckData(const CheckData&) = delete;
  CheckData& operator=(const CheckData&) = delete;

  std::vector<CheckStep> steps;
  std::vector<CheckLink> links;
  std::vector<CheckSphere> spheres;
  std::vector<CheckPair> pairs;
  std::vector<std::uint32_t> reachable;
  std::vector<CheckBox> aligned, turned;
  std::vector<CheckCylinder> cylinders;
  std::vector<CheckConvex> convex;
  std::vector<CheckPlane> faces, planes;
  std::vector<CheckNode> nodes;
  /// For each link of the kernels: its LinkBody, and the obstacles that it can reach. Links that do not move
  /// have no entry.
  std::vector<std::size_t> body_of_link;
  std::vector<std::vector<std::size_t>> obstacles_of_link;
  /// The same with those out of reach: all whose distance counts.
  std::vector<std::vector<std::size_t>> measured_of_link;
  /// Trees over both lists, for exact distances: they have what is bounded; the lists keep what is not.
  struct Nearby {
    std::vector<std::size_t> always;    ///< half-spaces
    std::vector<std::size_t> obstacle;  ///< by leaf
    BoxTree tree;
  };
  std::vector<Nearby> reachable_near, measured_near;
  CheckModel model;
};

/// `obstacles` are in the robot's base. `clearance`: m, added to each obstacle. `allowed`: [link body *
/// obstacles + obstacle] is true for pairs that may touch; empty: none.
void make_check_data(const RobotBody& robot, const std::vector<Obstacle>& obstacles, double clearance,
                     const std::vector<char>& allowed, CheckData& out);

}  // namespace polyarm::collision
