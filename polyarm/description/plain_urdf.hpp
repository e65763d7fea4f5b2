#pragma once
/// URDF for readers that know nothing but URDF, as ROS's own do (urdfdom before 5 gives up at a <capsule>).
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// The same robot: a capsule is a cylinder and two spheres, and what only Polyarm says is left out.
std::string write_plain_urdf(const RobotModel& model);

}  // namespace polyarm::description
