#pragma once
/// URDF for readers that accept only standard URDF, such as ROS's own (urdfdom before version 5 fails at a
/// <capsule>). SI units.
#include <string>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// The same robot: a capsule becomes a cylinder and two spheres, and Polyarm's own elements are omitted.
std::string write_plain_urdf(const RobotModel& model);

}  // namespace polyarm::description
