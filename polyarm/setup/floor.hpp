#pragma once
/// The floor of a cell that has no scene.
#include <string>
#include <vector>

#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

/// Lowest point of a robot's moving links in the start state, m in the world. Uses collision shapes except
/// meshes, which are not simulated. Infinite if there is none, and for a robot with a free base.
double lowest_point(const CellRobot& robot);

/// The scene of a cell without a scene file: a floor at z = 0. If a fixed robot starts below that (for
/// example lying with all joints at zero, or legs with only the pelvis placed), the floor is a centimetre
/// below its lowest point, and a note reports it.
description::Scene scene_without_file(const CellRobots& robots, std::vector<std::string>& notes);

}  // namespace polyarm::cell
