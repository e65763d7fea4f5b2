#pragma once
/// `polyarm new cell`: writes a cell that runs.
#include <filesystem>
#include <string>

#include "apps/new_cell_robot.hpp"

namespace polyarm::apps {

struct NewCell {
  std::string name;
  std::string robot;  ///< a catalogue name, or a description file
  std::filesystem::path folder;
  Files robot_files = {};  ///< set by write_new_cell: a copy of that file and what it needs
};

/// Finds a place for table, feeder and tray that the robot reaches with its tool pointing down, runs `check`
/// and `check --dry` on the cell, and writes it. If there is no such place, the cell moves the joints
/// instead, and the reason is printed. A description file is copied into the cell. Returns the exit code of
/// the verb. Throws Error if nothing was written.
int write_new_cell(const NewCell& asked);

}  // namespace polyarm::apps
