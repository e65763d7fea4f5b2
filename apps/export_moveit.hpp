#pragma once
/// Generates the MoveIt 2 configuration of a cell.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "polyarm/inside/view.hpp"

namespace polyarm::apps {

struct MoveItFiles {
  std::map<std::string, std::string> texts;  ///< by file name
  std::vector<std::string> notes;            ///< hints for the user, one sentence each
};

/// The files for one robot of the cell: description, SRDF, kinematics, limits, controllers and a launch file.
/// `samples`: number of joint states used to find link pairs that need no collision check.
MoveItFiles moveit_files(const cell::CellView& cell, std::size_t robot, int samples);

}  // namespace polyarm::apps
