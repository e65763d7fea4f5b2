#pragma once
/// How a cell is built and run, beside what its file says.
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
#include "polyarm/setup/breakpoints.hpp"

namespace polyarm::cell {

/// What a cell is to be built anew with; empty: as it is.
struct RestartWish {
  std::string robot, hardware, program, cell;
  std::optional<bool> real{};  ///< on its real hardware, or simulated
};

/// A test of a file of tests, by its place among them.
struct TestEntry {
  std::filesystem::path file;
  std::size_t index = 0;
};

/// Why a cell cannot go on by itself.
struct Failure {
  Problem problem;
  Nanoseconds time = 0;
};

struct CellOptions {
  bool lock_step = false;   ///< one thread, files inline, the cell cannot fall silent
  bool links = false;       ///< lock-step: links to the outside are connected all the same
  bool keep = false;        ///< go on from what the last run left in .state/
  bool real = false;        ///< real hardware is driven, after a person has armed it
  bool full_speed = false;  ///< real hardware moves as fast as it may from the first pass on
  /// Callbacks of hardware that have not come back so long after the end are left behind, ns.
  Nanoseconds hardware_patience = 5'000'000'000;
  /// While hardware starts: whether a person has asked to end it. Then what has not come back is left behind.
  std::function<bool()> start_given_up;
  bool allow_contact = false;   ///< contacts are reported and do not end the run
  bool contact_errors = false;  ///< with that: they are reported as errors, not as warnings
  /// The program begins on a request, and the cell goes on when it has ended.
  bool waits = false;
  bool no_code = false;                  ///< plugins that the cell brings are not loaded, approved or not
  std::uint64_t cycles = 0;              ///< passes of the program's outermost while; 0: no limit
  std::map<std::string, double> faults;  ///< interface name → value forced upon it
  std::vector<std::string> answers;      ///< to `wait user`, in order
  bool resume_holds = false;             ///< each `hold` of a program is resumed at once
  std::optional<TestEntry> test;         ///< runs beside the program, which begins when the test says so
  std::vector<FileBreakpoints>
      breakpoints;                     ///< as those of a cell before it were, files by their whole paths
  std::filesystem::path state_folder;  ///< where data files are kept; empty: .state/data of the cell
  program::ReadPrograms read;          ///< scripts that have been read already
};

}  // namespace polyarm::cell
