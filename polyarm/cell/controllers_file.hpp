#pragma once
/// Controllers YAML as ROS 2 users write it: `controller_manager: ros__parameters: …` and a block per
/// controller.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/controller.hpp"

namespace polyarm::cell {

struct ControllerEntry {
  std::string name, type;
  controllers::Parameters parameters;
  Location where;
};

struct ControllersFile {
  double update_rate = 0;  ///< Hz; 0: not stated
  std::vector<ControllerEntry> controllers;
};

/// Reads the file; keys `name:`, `/name:`, `/ns/name:` and `/**:` each with `ros__parameters`. What is not
/// understood becomes a warning with its place; throws Error when nothing sensible can be made of the file.
ControllersFile read_controllers_file(const std::filesystem::path& path, Problems& warnings);

}  // namespace polyarm::cell
