#pragma once
/// The floor of a cell that has no scene.
#include <string>
#include <vector>

#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

/// True if physics lets the base of the robot stand on the floor by itself.
bool is_freestanding(const CellRobot& robot);
/// The lowest point, m in the world, of what a robot's joints move, where it starts: of shapes for collisions
/// but meshes, which are not simulated. Infinite where there is none, and for a robot that stands free.
double lowest_point(const CellRobot& robot);

/// The scene of a cell without a scene file: a floor at z = 0. If a fixed robot starts below that (for
/// example lying with all joints at zero, or legs with only the pelvis placed), the floor is a centimetre
/// below its lowest point, and a note reports it.
description::Scene scene_without_file(const CellRobots& robots, std::vector<std::string>& notes);

}  // namespace polyarm::cell
