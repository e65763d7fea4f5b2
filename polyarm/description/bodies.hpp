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

/// For each link: true if it may touch the floor because its robot rolls or stands on it. If the robot has
/// two wheels or more, these are the wheels, the links that carry them, and the links rigidly connected to
/// the root (casters). A wheel is a link with a cylinder or sphere, on a continuous joint with a horizontal
/// axis, that carries no other joint. For a robot without wheels: all links if it stands free, else none.
std::vector<char> links_on_the_floor(const RobotModel& model, bool is_freestanding);

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
