#pragma once
/// What MoveIt 2 is configured with, made from a cell.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "polyarm/inside/view.hpp"

namespace polyarm::apps {

struct MoveItFiles {
  std::map<std::string, std::string> texts;  ///< by name of the file
  std::vector<std::string> notes;            ///< what a person should know, one sentence each
};

/// Of one robot of the cell: description, SRDF, kinematics, limits, controllers and a launch file. `samples`:
/// joint states that are tried for the pairs of links that need not be compared.
MoveItFiles moveit_files(const cell::CellView& cell, std::size_t robot, int samples);

}  // namespace polyarm::apps
