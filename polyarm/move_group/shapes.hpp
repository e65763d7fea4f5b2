#pragma once
/// Shapes of ROS messages as bodies for contacts, and back. Metres. Any thread; allocates.
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"
#include "polyarm/move_group/poses.hpp"

namespace polyarm::move_group {

/// The shapes of a message in its own frame. A cone and a mesh become convex pieces, a plane a thin slab.
/// Throws Refusal(INVALID_OBJECT_NAME) that names the shape and the fault.
std::vector<description::Shape> shapes_of(const msg::CollisionObject& message);
/// Adds shapes to a message. A capsule becomes a cylinder and two spheres, convex pieces become meshes.
void add_to_message(const std::vector<description::Shape>& shapes, msg::CollisionObject& message);

}  // namespace polyarm::move_group
