#pragma once
/// The floor of a cell that has no scene.
#include <string>
#include <vector>

#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

/// True if physics lets the base of the robot stand on the floor by itself.
bool stands_free(const CellRobot& robot);
/// The lowest point, m in the world, of what a robot's joints move, where it starts: of shapes for collisions
/// but meshes, which are not simulated. Infinite where there is none, and for a robot that stands free.
double lowest_point(const CellRobot& robot);

/// The scene of a cell whose file names none: a floor at z = 0. Where a robot that is bolted down starts
/// below that (a description whose joints at zero leave it lying, legs of which only the pelvis is placed),
/// the floor is a centimetre below its lowest point, which a note tells.
description::Scene scene_without_file(const CellRobots& robots, std::vector<std::string>& notes);

}  // namespace polyarm::cell
