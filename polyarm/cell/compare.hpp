#pragma once
/// Runs one program on several robots and compares them: which robots can run it, and how well.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/setup/cell_file.hpp"

namespace polyarm::cell {

/// Smallest value during the run, and the program line at that moment.
struct Nearest {
  double value = 0;
  std::string joint;  ///< set for limits only
  Location where;
};

struct RobotVerdict {
  std::string robot;
  bool runs = false;
  std::optional<Problem> problem;  ///< first problem that prevents the run, with its line
  double time_s = 0;               ///< duration of the whole run
  /// Time of one pass of the outermost `while`, s: the mean without the first pass, or the only pass. For a
  /// program without such a loop: time until its end.
  std::optional<double> cycle_s;
  std::uint64_t cycles = 0;
  std::optional<Nearest> limit;        ///< smallest distance to a joint limit, rad or m
  std::optional<Nearest> singularity;  ///< kinematics::smallest_singular_value(): 0 is singular
};

struct CompareOptions {
  Overrides overrides;       ///< these name the robot to try
  std::uint64_t cycles = 3;  ///< passes of the outermost while
  double seconds = 3600;     ///< limit of cell time, s
  std::filesystem::path state_folder;
};

/// Runs the cell's program in lock-step with the robot from the overrides instead of the cell's own robot. A
/// contact counts as a failure.
RobotVerdict try_robot(const std::filesystem::path& cell, const description::Catalogue& catalogue,
                       const CompareOptions& options);

}  // namespace polyarm::cell
