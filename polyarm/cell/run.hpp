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
  bool stay = false;         ///< continue after the program has ended, so it can be started again
  bool fast = false;         ///< lock-step, as fast as possible
  double seconds = 0;        ///< limit of cell time, s; 0: no limit
  int priority = 0;          ///< SCHED_FIFO priority of the control thread
  int cpu = -1;              ///< processor of the control thread
  bool socket = true;        ///< open the socket for other programs of the same user
  bool fast_socket = false;  ///< open the socket also in lock-step; such a run is not repeatable
  bool console = true;       ///< read typed lines (resume, discard, stop, answers)
  /// How long to wait, on the wall clock, for a loop to end or a robot to stop, ns.
  Nanoseconds patience = 6'000'000'000;
  std::vector<Door*> doors;  ///< served each tick beside those that the cell names; they outlive the run
  /// Called after each tick of the cell, with its time; null: nothing is.
  std::function<void(Nanoseconds)> each_tick;
  Nanoseconds started = 0;   ///< wall time at which the user gave the command; 0: unknown
};

/// Thread options for a run on the wall clock. Priority: the run's options, then the cell's `loop:`, then the
/// manager's parameters in the controllers' file.
realtime::ThreadOptions control_thread(const RunOptions& options, const LoopEntry& stated,
                                       const ros_files::ManagerParameters& manager);

struct LoopHealth {
  std::uint64_t cycles = 0, late = 0, late_empty = 0;
  Nanoseconds cost_p50 = 0, cost_p99 = 0, cost_max = 0;
  Nanoseconds wake_p50 = 0, wake_p99 = 0, wake_max = 0;  ///< zero in lock-step
};

struct RunResult {
  Outcome outcome = Outcome::completed;
  std::vector<Problem> problems;  ///< why the run failed
  double sim_time_s = 0, wall_time_s = 0;
  std::optional<double> physics_step_s;  ///< empty without physics
  std::uint64_t program_cycles = 0;
  LoopHealth health;
  int contacts_max = 0;
  double tracking_error_max = 0;  ///< rad or m
  std::uint64_t clamps = 0;
  std::vector<PartReport> parts;
  std::vector<StopReport> stops;  ///< duration of each stop, oldest first
  bool repeatable = false;
  std::string trace_hash;
  /// The control thread is blocked in a call and has not returned: do not destroy the cell; end the process.
  bool stuck = false;
  /// Set if the run ended so the cell can be built again.
  std::optional<RestartRequest> restart;
  std::optional<double> first_motion_s;  ///< from the command to the first commanded motion, wall time
};

/// Sets the stop latch of the current run. Safe in signal handlers.
void request_stop() noexcept;
/// The same, but only if no stop was requested before: a closed terminal may send several signals for one
/// request.
void request_stop_once() noexcept;
/// Stops the robots on their paths and holds them, like `hold`. Does nothing if no cell runs.
void request_hold() noexcept;
/// Number of stop requests since the last run ended.
int stops_requested() noexcept;

RunResult run(Cell& cell, const RunOptions& options, Observer& observer);

}  // namespace polyarm::cell
