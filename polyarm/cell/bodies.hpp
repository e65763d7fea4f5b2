#pragma once
/// What contacts are not detected for, in sentences. Any thread.
#include <string>
#include <vector>

#include "polyarm/cell/robots.hpp"
#include "polyarm/description/scene.hpp"

namespace polyarm::cell {

/// Does physics look for contacts of this robot?
bool checks_contacts(const CellRobot& robot);
/// One sentence for each robot, tool and fixture that passes through everything.
std::vector<std::string> unchecked_bodies(const CellRobots& robots, const description::Scene& scene);
/// What looks like a placeholder in the robots that physics plays, a sentence each.
std::vector<std::string> placeholder_notes(const CellRobots& robots);

}  // namespace polyarm::cell
