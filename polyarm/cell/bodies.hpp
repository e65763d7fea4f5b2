#pragma once
/// What contacts are not detected for. Any thread.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/cell/robots.hpp"
#include "polyarm/description/scene.hpp"

namespace polyarm::cell {

/// Does physics look for contacts of this robot?
bool checks_contacts(const CellRobot& robot);
/// One for each robot, tool and fixture that passes through everything: a warning of code no-contacts (robot,
/// driver), links-without-body (robot, count, all, links), tool-without-body (robot, tool) or
/// fixture-without-body (fixture).
std::vector<Problem> unchecked_bodies(const CellRobots& robots, const description::Scene& scene);
/// What each of them says.
std::vector<std::string> sentences(const std::vector<Problem>& problems);
/// What looks like a placeholder in the robots that physics plays, a sentence each.
std::vector<std::string> placeholder_notes(const CellRobots& robots);

}  // namespace polyarm::cell
