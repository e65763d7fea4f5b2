#pragma once
/// `polyarm new cell`: writes a cell that runs.
#include <filesystem>
#include <string>

namespace polyarm::apps {

struct NewCell {
  std::string name;
  std::string robot;  ///< a catalogue name, or a description file
  std::filesystem::path folder;
};

/// Finds a place for table, feeder and tray that the robot reaches with its tool pointing down, runs `check`
/// and `check --dry` on the cell, and writes it. If there is no such place, the cell moves the joints
/// instead, and the reason is printed. Returns the exit code of the verb. Throws Error if nothing was
/// written.
int write_new_cell(const NewCell& asked);

}  // namespace polyarm::apps
