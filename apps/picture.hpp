#pragma once
/// Pictures of robots: no GPU, no browser, about ten kilobytes.
#include <span>
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::apps {

/// The robot in joint state `q` as SVG that holds a PNG: seen from its front and right, from above, with a soft
/// shadow. Robots without a look of their own are drawn by shapes::robot_shapes; of others the plain shapes
/// are drawn, not the meshes. Throws Error as kinematics::Chain.
std::string picture_of(const description::RobotModel& model, std::span<const double> q);

}  // namespace polyarm::apps
