#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/base/hash.hpp"
#include "polyarm/control/controller_manager.hpp"
#include "polyarm/control/limits.hpp"
#include "polyarm/control/supervisor.hpp"
#include "polyarm/realtime/histogram.hpp"
#include "polyarm/realtime/jobs.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::control {

/// What a watcher sees of a cycle: whole, and the newest there is.
struct Snapshot {
  hardware::Cycle cycle;
  RunState state = RunState::running;
  StopCause cause = StopCause::none;
  std::int32_t culprit = -1;
  bool standing = true;
  std::vector<double> states, commands;
  hardware::WorldState world;
};

/// The last cycles, each a row of all states and commands as they were given; read it with the loop stopped.
class BlackBox {
 public:
  void build(std::size_t values, std::size_t rows);
  void record(std::span<const double> states, std::span<const double> commands) noexcept;
  std::size_t rows() const noexcept { return filled_; }
  std::size_t width() const noexcept { return width_; }
  /// Row 0 is the oldest kept.
  std::span<const double> row(std::size_t i) const noexcept;

 private:
  std::vector<double> data_;
  std::size_t width_ = 0, capacity_ = 0, next_ = 0, filled_ = 0;
};

/// Raised by the control thread, read by any.
struct Health {
  realtime::Counter cycles;
  realtime::Counter late;       ///< cycles that woke more than half a period late or were skipped whole
  realtime::Histogram cost;     ///< of step(), ns
  realtime::Histogram wake_up;  ///< latency against the grid, ns; empty in lock-step
};

struct LoopOptions {
  Nanoseconds period = 1'000'000;
  std::size_t black_box_rows = 10'000;
  bool measure = true;  ///< measure the cost of each cycle
  bool limits = true;   ///< restrict commands; off only to measure what that costs
  bool publish = true;  ///< snapshot and cycle records; off only to measure what that costs
};

/// One control loop: its table, hardware, controllers and supervisor, and the one function that a cycle is.
/// Built and taken apart with nobody stepping; step() belongs to the control thread; inbox and outbox to one
/// other thread.
class ControlLoop {
 public:
  explicit ControlLoop(const LoopOptions& options);

  hardware::InterfaceTable& table() { return table_; }
  hardware::Hardware& hardware() { return hardware_; }
  ControllerManager& controllers() { return controllers_; }
  Supervisor& supervisor() { return supervisor_; }
  const CommandLimits& limits() const { return limits_; }
  const BlackBox& black_box() const { return black_box_; }
  const LoopOptions& options() const { return options_; }

  /// Configures and activates the hardware, reads it once, and makes everything that a cycle needs.
  void start_hardware();
  /// Fixes limits, snapshot and hash; controllers must have been added by now.
  void prepare(const std::vector<controllers::JointFacts>& joints);

  /// From now on a control thread steps, and requests of controllers and hardware reach it between two
  /// cycles; before begin() and after end() they are done at once, by whoever asks.
  void begin() { jobs_.start(); }
  void end() { jobs_.stop(); }
  realtime::Jobs& jobs() { return jobs_; }

  /// One cycle. `gap`: wall time went missing since the last one.
  controllers::Verdict step(const hardware::Cycle& cycle, bool gap = false) noexcept;
  /// One cycle at the loop's own time, which advances by one period.
  controllers::Verdict step_next(bool gap = false) noexcept;
  hardware::Cycle cycle() const noexcept { return cycle_; }

  /// From one other thread: at most one request is taken each cycle.
  bool post(Request request) { return inbox_.push(request); }
  realtime::Latest<Snapshot>& outbox() noexcept { return outbox_; }
  Health& health() noexcept { return health_; }
  /// Of every joint position, and every part's place, of every cycle so far.
  const TraceHash& trace() const noexcept { return trace_; }

 private:
  void publish(const hardware::Cycle& cycle) noexcept;
  void take_off_failed(const hardware::Cycle& cycle) noexcept;

  LoopOptions options_;
  realtime::Jobs jobs_;
  hardware::InterfaceTable table_;
  hardware::Hardware hardware_{table_, jobs_};
  ControllerManager controllers_{table_, hardware_, jobs_};
  Supervisor supervisor_;
  CommandLimits limits_;
  BlackBox black_box_;
  Health health_;
  TraceHash trace_;
  std::vector<std::uint32_t> traced_;  // indices of joint position states
  realtime::Queue<Request> inbox_{64};
  realtime::Latest<Snapshot> outbox_;
  hardware::Cycle cycle_;
};

}  // namespace polyarm::control
