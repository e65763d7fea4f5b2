#pragma once
/// Checks a cell before anything moves: files, points, moves and optionally a dry run.
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
  std::string reason;          ///< why it is not reachable
  std::vector<double> joints;  ///< solution for the point, starting from home
};

struct CheckResult {
  std::vector<Problem> problems;    ///< from all files, in the cell's order
  std::vector<std::string> notes;   ///< undetected contacts, and values that look like placeholders
  std::vector<PointReport> points;  ///< all points of the program's data, for the cell's robot
  std::size_t moves = 0;            ///< number of planned moves of the program
  Location reached;                 ///< where following the moves stopped; empty: followed to the end
  bool has_errors() const;
};

struct CheckOptions {
  bool dry = false;  ///< runs the program in lock-step; lists contacts, limits and parts by line
  std::uint64_t cycles = 0;
  std::function<void(double)> progress;  ///< called in the dry run with its time, s; null: nobody asks
  std::filesystem::path state_folder;  ///< where data files are kept; empty: a temporary folder
};

/// Reads every file of the cell and collects all errors and warnings. Checks every point for reach and joint
/// limits, and every move along its path as far as the program can be followed. Moves no real hardware.
/// `open` reads the cell; errors that it throws are added to the problems.
CheckResult check(const std::function<CellFile()>& open, const description::Catalogue& catalogue,
                  const CheckOptions& options);
CheckResult check(const std::filesystem::path& cell, const Overrides& overrides,
                  const description::Catalogue& catalogue, const CheckOptions& options);

}  // namespace polyarm::cell
