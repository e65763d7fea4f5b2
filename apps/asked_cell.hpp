#pragma once
/// The cell that `run` and `check` are about, as named on the command line: a folder or file of a cell, a
/// robot's description with controllers files, a model of the catalogue, or a launch file.
#include <optional>
#include <string>
#include <vector>

#include "apps/command_line.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::apps {

struct AskedCell {
  std::string cell, description;
  std::vector<std::string> controllers, activate, arguments;
  cell::Overrides overrides;

  void add_to(CommandLine& app);
  /// Sorts what the command line named. An exit code where nothing that runs here is named; then why has been
  /// printed, with what to type instead. `verb`: "run" or "check".
  std::optional<int> settle(const std::string& verb);
  /// The files of the cell, read. Throws Error with everything that is wrong.
  cell::CellFile open() const;
};

}  // namespace polyarm::apps
