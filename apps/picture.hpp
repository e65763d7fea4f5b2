#pragma once
/// Draws pictures of robots without GPU or browser; about ten kilobytes each.
#include <span>
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::apps {

/// The robot in joint state `q` as an SVG that contains a PNG: seen from its front and right, from above,
/// with a soft shadow. Robots without visuals are drawn with shapes::robot_shapes(), others with their shapes
/// and meshes, whose images are left out. Reads the mesh files. Throws Error like kinematics::Chain.
std::string picture_of(const description::RobotModel& model, std::span<const double> q);

}  // namespace polyarm::apps
