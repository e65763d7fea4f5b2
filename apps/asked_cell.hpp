#pragma once
/// The cell of `run` and `check`, as named on the command line: a folder or file of a cell, a robot's
/// description with controllers' files, a model of the catalogue, or a launch file.
#include <optional>
#include <string>
#include <vector>

#include "apps/command_line.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::apps {

struct CellOption {
  std::string cell, description, branch;
  std::vector<std::string> controllers, activate, arguments;
  cell::Overrides overrides;

  void add_to(CommandLine& app);
  /// Interprets the command line. Returns an exit code if it names nothing that can run here; it has then
  /// printed the reason and what to type instead. `verb`: "run" or "check".
  std::optional<int> settle(const std::string& verb);
  /// Reads the cell's files. Throws Error that lists all problems found.
  cell::CellFile open() const;
};

}  // namespace polyarm::apps
