#pragma once
/// The robot of a new cell, if it is the user's own description: a copy that belongs to the cell.
#include <filesystem>
#include <map>
#include <string>

namespace polyarm::apps {

/// Names in a cell's folder, with their texts.
using Files = std::map<std::string, std::string>;

struct CopiedRobot {
  std::string model;  ///< the description in `files`, for cell.yaml
  Files files;        ///< the description, its SRDF and its meshes, in the folder robot
};

/// Reads a description with all files that it needs, so that a cell with the copy reads nothing outside its
/// folder. xacro is expanded. Meshes get names relative to the copy. Throws Error.
CopiedRobot copy_of_robot(const std::filesystem::path& description);

}  // namespace polyarm::apps
