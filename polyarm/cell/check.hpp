#pragma once
/// Finds what is wrong with a cell before anything moves.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::cell {

struct PointReport {
  std::string name;
  Location where;
  bool reachable = false;
  std::string reason;          ///< why not
  std::vector<double> joints;  ///< where it puts the joints, coming from home
};

struct CheckResult {
  std::vector<Problem> problems;    ///< of every file, in the order of the cell
  std::vector<std::string> notes;   ///< what contacts are not detected for, and what looks like a placeholder
  std::vector<PointReport> points;  ///< every point of the program's data, for the cell's robot
  std::size_t moves = 0;            ///< of the program, that were planned
  Location reached;                 ///< where its moves could not be followed any further; empty: to its end
  bool has_errors() const;
};

struct CheckOptions {
  bool dry = false;  ///< run the program in lock-step and list contacts, limits and parts by line
  std::uint64_t cycles = 0;
  std::function<void(double)> progress;  ///< called in the dry run with its time, s; null: nobody asks
  std::filesystem::path state_folder;  ///< where data files are kept; empty: a temporary folder
};

/// Reads every file of the cell and adds every error and warning; checks every point for reach and joint
/// limits, and every move along its way as far as the program can be followed. Nothing real moves.
/// `open` reads the cell; what it throws is among the problems.
CheckResult check(const std::function<CellFile()>& open, const description::Catalogue& catalogue,
                  const CheckOptions& options);
CheckResult check(const std::filesystem::path& cell, const Overrides& overrides,
                  const description::Catalogue& catalogue, const CheckOptions& options);

}  // namespace polyarm::cell
