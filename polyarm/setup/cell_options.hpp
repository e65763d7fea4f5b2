#pragma once
/// Options for building and running a cell, in addition to its file.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/language/parser.hpp"
#include "polyarm/io/breakpoints.hpp"

namespace polyarm::cell {

/// Changes for rebuilding a cell; empty values stay unchanged.
struct RestartRequest {
  std::string robot, hardware, program, cell;
  std::optional<bool> real{};  ///< true: on its real hardware; false: simulated
};

/// A test in a file of tests, by its index.
struct TestEntry {
  std::filesystem::path file;
  std::size_t index = 0;
};

/// Why a cell cannot continue by itself.
struct Failure {
  Problem problem;
  Nanoseconds time = 0;
};

struct CellOptions {
  bool lock_step = false;   ///< one thread, file access inline, no monitoring of the cell thread
  bool links = false;       ///< in lock-step: connect links to the outside anyway
  bool keep = false;        ///< continue with the data of the last run in .state/
  bool real = false;        ///< drive real hardware, after a person has armed it
  bool full_speed = false;  ///< real hardware runs at full speed from the first pass on
  /// Time after the end of the run after which hardware callbacks are abandoned, ns.
  Nanoseconds hardware_timeout = 5'000'000'000;
  /// While hardware starts: returns true if a person has asked to end it. Running callbacks are then
  /// abandoned.
  std::function<bool()> start_given_up;
  bool allow_contact = false;   ///< contacts are reported and do not end the run
  bool contact_errors = false;  ///< with allow_contact: report contacts as errors instead of warnings
  /// The program starts on a request, and the cell continues after it has ended.
  bool waits = false;
  bool no_code = false;                      ///< do not load plugins of the cell, approved or not
  std::uint64_t cycles = 0;                  ///< passes of the program's outermost while; 0: no limit
  std::map<std::string, double> faults;      ///< interface name → forced value
  std::vector<std::string> answers;          ///< to `wait user`, in order
  bool resume_holds = false;                 ///< resume at once after each `hold` of a program
  std::optional<TestEntry> test;             ///< runs in parallel to the program, which the test starts
  std::vector<FileBreakpoints> breakpoints;  ///< taken over from a previous cell; files by absolute path
  std::filesystem::path state_folder;        ///< folder for data files; empty: .state/data of the cell
  program::ReadPrograms read;                ///< scripts that are already parsed
};

}  // namespace polyarm::cell
