#pragma once
/// One program on several robots: which can run it, and how well.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::cell {

/// How near something came, and where the program stood then.
struct Nearest {
  double value = 0;
  std::string joint;  ///< of a limit
  Location where;
};

struct RobotVerdict {
  std::string robot;
  bool runs = false;
  std::optional<Problem> problem;  ///< the first thing that it cannot do, with its line
  double time_s = 0;               ///< of the whole run
  /// Of a pass of the outermost while: the mean of all but the first, or of the only one. Of a program
  /// without such a loop: until its end.
  std::optional<double> cycle_s;
  std::uint64_t cycles = 0;
  std::optional<Nearest> limit;        ///< rad or m from the nearest limit of a joint's range
  std::optional<Nearest> singularity;  ///< kinematics::smallest_singular_value(): 0 is singular
};

struct CompareOptions {
  Overrides overrides;       ///< its robot is the one to look at
  std::uint64_t cycles = 3;  ///< passes of the outermost while
  double seconds = 3600;     ///< of cell time
  std::filesystem::path state_folder;
};

/// Runs the cell's program in lock-step with the robot of the overrides in the place of the cell's own.
/// Contacts count as what it cannot do.
RobotVerdict try_robot(const std::filesystem::path& cell, const description::Catalogue& catalogue,
                       const CompareOptions& options);

}  // namespace polyarm::cell
