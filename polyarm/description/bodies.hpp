#pragma once
/// Properties of a robot for physics: links with a body, links on the floor, and placeholder values. Any
/// thread; throws nothing.
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// True if physics simulates at least one of these shapes. It does not simulate meshes.
bool has_body(const std::vector<Shape>& shapes);
/// Names of the links that are visible or have a collision shape, but no body: they have only meshes, or
/// nothing.
std::vector<std::string> links_without_body(const RobotModel& model);

/// For each link: true if it may touch the floor because its robot rolls or stands on it. On a robot with
/// wheels, these are the wheels, the links that carry them, and the links rigidly connected to the root
/// (fixed casters). For a robot without wheels: all links if it stands free, else none.
///
/// `wheel_joints`: indices of the joints that the controller of its base names, wheels and steering. All
/// links behind them are wheels, whatever their shapes. So are the casters: links at the end of a continuous
/// joint with a horizontal axis, no more than 5 cm higher than these wheels, behind joints that only swivel
/// (continuous, vertical) or that nothing commands. Where no controller says it, the robot has wheels if two
/// links or more look like wheels: they have a cylinder or sphere, on a continuous joint with a horizontal
/// axis, and carry no other joint.
std::vector<char> links_on_the_floor(const RobotModel& model, bool is_freestanding,
                                     const std::vector<int>& wheel_joints = {});

/// Sentences about efforts, inertias and masses that are the same round number everywhere, as exporters and
/// templates write them. Empty if nothing looks like a placeholder.
std::vector<std::string> placeholders(const RobotModel& model);

/// The cloud that a shape belongs to, "a.pcd: 12000 points in 300 boxes, cells of 10 mm"; empty: none.
/// Physics leaves such shapes out.
inline const std::string& cloud_of(const Shape& shape) {
  static const std::string none;
  return shape.kind == ShapeKind::mesh ? none : shape.mesh;
}

}  // namespace polyarm::description
