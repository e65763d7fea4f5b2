#pragma once
/// Runs a cell to its end, on the wall clock or in lock-step.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/cell/cell.hpp"
#include "polyarm/io/parts.hpp"
#include "polyarm/machine/stops.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "polyarm/setup/door.hpp"

namespace polyarm::cell {

enum class Outcome { completed, stopped, failed };
const char* name(Outcome outcome);

struct RunOptions {
  bool stay = false;         ///< it goes on when the program has ended, which then may begin anew
  bool fast = false;         ///< lock-step, as fast as the machine allows
  double seconds = 0;        ///< of cell time after which the run ends; 0: no limit
  int priority = 0;          ///< SCHED_FIFO priority of the control thread
  int cpu = -1;              ///< processor of the control thread
  bool socket = true;        ///< other programs of the same user may ask and tell
  bool fast_socket = false;  ///< in lock-step, too; such a run is not repeatable
  bool console = true;       ///< typed lines (resume, discard, stop, answers) are read
  /// So long a loop that has been asked to end, or a robot to stop, is waited for on the wall clock, ns.
  Nanoseconds patience = 6'000'000'000;
  std::vector<Door*> doors;  ///< served each tick beside those that the cell names; they outlive the run
  /// Called after each tick of the cell, with its time; null: nothing is.
  std::function<void(Nanoseconds)> each_tick;
  Nanoseconds started = 0;   ///< wall time at which the user gave the command; 0: unknown
};

/// How the control thread runs on the wall clock: what the run's options say, else the cell's `loop:`, else
/// the manager in the controllers' file.
realtime::ThreadOptions control_thread(const RunOptions& options, const LoopEntry& stated,
                                       const ros_files::ManagerParameters& manager);

struct LoopHealth {
  std::uint64_t cycles = 0, late = 0, late_empty = 0;
  Nanoseconds cost_p50 = 0, cost_p99 = 0, cost_max = 0;
  Nanoseconds wake_p50 = 0, wake_p99 = 0, wake_max = 0;  ///< zero in lock-step
};

struct RunResult {
  Outcome outcome = Outcome::completed;
  std::vector<Problem> problems;  ///< why it failed
  double sim_time_s = 0, wall_time_s = 0;
  std::optional<double> physics_step_s;  ///< empty without physics
  std::uint64_t program_cycles = 0;
  LoopHealth health;
  int contacts_max = 0;
  double tracking_error_max = 0;  ///< rad or m
  std::uint64_t clamps = 0;
  std::vector<PartReport> parts;
  std::vector<StopReport> stops;  ///< what each took, oldest first
  bool repeatable = false;
  std::string trace_hash;
  /// The control thread has not come back from what it called: the cell must not be destroyed, and the
  /// process is best ended.
  bool stuck = false;
  /// It was ended in order to be built anew.
  std::optional<RestartWish> restart;
  std::optional<double> first_motion_s;  ///< from the command to the first commanded motion, wall time
};

/// The stop latch of the run under way is set through this; safe in signal handlers.
void request_stop() noexcept;
/// The same, but only where nobody has asked yet: a closed terminal and what follows it are one wish.
void request_stop_once() noexcept;
/// The robots stop on their paths and are held, as `hold` does; nothing where no cell runs.
void request_hold() noexcept;
/// How often that was asked since the last run ended.
int stops_requested() noexcept;

RunResult run(Cell& cell, const RunOptions& options, Observer& observer);

}  // namespace polyarm::cell
