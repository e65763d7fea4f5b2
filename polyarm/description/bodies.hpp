#pragma once
/// What of a robot physics has a body for, what stands on the floor, and what looks like a placeholder.
/// Any thread; throws nothing.
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// Does physics simulate any of these shapes? Meshes it does not.
bool has_body(const std::vector<Shape>& shapes);
/// Names of the links that can be seen or state a collision, and have no body: only meshes, or nothing.
std::vector<std::string> links_without_body(const RobotModel& model);

/// By link: may it touch the floor because its robot rolls or stands on it? Of a robot with two wheels or more:
/// wheels, what carries them, and what is rigid with the root (casters). A wheel is a link with a cylinder or
/// sphere on a continuous joint whose axis is horizontal, and that carries no other joint. Of one without
/// wheels: every link where it stands free, else none.
std::vector<char> links_on_the_floor(const RobotModel& model, bool stands_free);

/// Sentences about efforts, inertias and masses that are the same round number everywhere, as exporters and
/// templates write them. Empty: none looks like one.
std::vector<std::string> placeholders(const RobotModel& model);

}  // namespace polyarm::description
