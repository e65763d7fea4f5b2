#pragma once
/// What `polyarm new cell` writes: a cell that runs.
#include <filesystem>
#include <string>

namespace polyarm::apps {

struct NewCell {
  std::string name;
  std::string robot;  ///< of the catalogue, or a description
  std::filesystem::path folder;
};

/// Finds a place for table, feeder and tray that the robot reaches with its tool down, writes the cell, and
/// tries it: `check`, `check --dry`. Returns the exit code of the verb; what still has to be moved is
/// printed. Throws Error where nothing was written.
int write_new_cell(const NewCell& asked);

}  // namespace polyarm::apps
