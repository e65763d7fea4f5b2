#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/hash.hpp"
#include "polyarm/control/controller_manager.hpp"
#include "polyarm/control/cycle_tap.hpp"
#include "polyarm/control/limits.hpp"
#include "polyarm/control/supervisor.hpp"
#include "polyarm/hardware/hardware.hpp"
#include "polyarm/realtime/histogram.hpp"
#include "polyarm/realtime/jobs.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::control {

/// How often a component's thread has run so far, was late, and missed its turn.
struct ThreadCounts {
  std::uint64_t runs = 0, late = 0, missed = 0;
};

/// What a watcher sees of a cycle: whole, and the newest there is.
struct Snapshot {
  hardware::Cycle cycle;
  RunState state = RunState::running;
  StopCause cause = StopCause::none;
  FaultEvent event;  ///< what led to this state
  bool standing = true;
  StopTimes stop;
  std::vector<double> states, commands;
  hardware::WorldState world;
  std::vector<ThreadCounts> threads;  ///< by component; zeros where it has none
  std::vector<StopCause> fallen;      ///< by component: with what it fell; none: it did not, or is back
};

/// The last cycles: what was measured, what was commanded, and what the loop made of it. One thread records;
/// read what the recording thread has let go of.
class BlackBox {
 public:
  struct Row {
    std::uint64_t cycle = 0;
    RunState state = RunState::running;
    StopCause cause = StopCause::none;
    Request request = Request::none;  ///< that was taken in this cycle
    std::span<const double> states, commands;
  };
  /// So many rows, or as many as `most_bytes` hold.
  void build(std::size_t states, std::size_t commands, std::size_t rows,
             std::size_t most_bytes = static_cast<std::size_t>(-1));
  void record(const Row& row) noexcept;
  std::size_t rows() const noexcept { return filled_; }
  /// Row 0 is the oldest kept.
  Row row(std::size_t i) const noexcept;
  /// An empty one of the same size.
  BlackBox empty_one() const;

 private:
  struct Head {
    std::uint64_t cycle;
    RunState state;
    StopCause cause;
    Request request;
  };
  std::vector<Head> heads_;
  std::vector<double> data_;
  std::size_t states_ = 0, width_ = 0, capacity_ = 0, next_ = 0, filled_ = 0;
};

/// Raised by the control thread, read by any.
struct Health {
  realtime::Counter cycles;
  realtime::Counter gaps;       ///< of kGap or longer that did not hold
  realtime::Counter late;       ///< cycles that woke more than half a period late or were skipped whole
  realtime::Histogram cost;     ///< of step(), ns
  realtime::Histogram wake_up;  ///< latency against the grid, ns; empty in lock-step
  realtime::Histogram period;   ///< between the beginnings of two cycles, ns; empty in lock-step
};

struct LoopOptions {
  Nanoseconds period = 1'000'000;
  std::size_t black_box_rows = 10'000;
  bool measure = true;         ///< measure the cost of each cycle
  bool measure_parts = false;  ///< and of each component and controller in it
  bool limits = true;          ///< restrict commands; off only to measure what that costs
  Overrun overrun = Overrun::report;
  unsigned overrun_after = 10;  ///< late cycles in a row
  bool publish = true;          ///< snapshot and cycle records; off only to measure what that costs
  /// A gap of kGap holds; else it is counted in Health::gaps. Empty: holds where a component is real.
  std::optional<bool> stall_holds = true;
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
  CommandLimits& limits() { return limits_; }
  const CommandLimits& limits() const { return limits_; }
  /// For when nobody steps any more.
  const BlackBox& black_box() const { return black_box_; }
  /// Takes what was recorded so far out of the running loop, which goes on with an empty one. The box is the
  /// caller's once the job is done. Throws Error("busy").
  class TakeBlackBox;
  std::shared_ptr<TakeBlackBox> take_black_box();
  const LoopOptions& options() const { return options_; }

  /// A tap with room for so many cycles; `every`: one of so many.
  std::unique_ptr<CycleTap> make_tap(std::size_t rows, unsigned every) const;
  /// From the next cycle on rows go to `tap`; null: to nobody any more. What was tapped into before must live
  /// until the job is done. Throws Error("busy").
  std::shared_ptr<realtime::Job> tap(CycleTap* tap);

  /// Configures and activates the hardware, reads it once, and makes everything that a cycle needs.
  void start_hardware();
  void start_hardware(hardware::Caller& caller);
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
  /// Tells before a cycle how it woke up; what it means is decided by the options. `skipped`: whole periods
  /// that passed meanwhile. Returns whether wall time has gone missing.
  bool woke(Nanoseconds latency, std::uint64_t skipped) noexcept;
  hardware::Cycle cycle() const noexcept { return cycle_; }

  /// Shortest gap in wall time after which the loop holds instead of going on: a suspended process, a
  /// sleeping laptop. Ordinary lateness on a busy machine stays below it.
  static constexpr Nanoseconds kGap = 500'000'000;
  /// Whether it does: as the options say, else by what is real.
  bool holds_after_gap() const;

  /// From one other thread: at most one request is taken each cycle.
  bool post(Request request) { return inbox_.push(request); }
  realtime::Latest<Snapshot>& outbox() noexcept { return outbox_; }
  Health& health() noexcept { return health_; }
  /// Of every joint position, and every part's place, of every cycle so far.
  const TraceHash& trace() const noexcept { return trace_; }

 private:
  /// The supervisor decides on what was found; what is to be taken off is.
  void decide(const hardware::Cycle& cycle) noexcept;
  void react_to_faults(const hardware::Cycle& cycle) noexcept;
  Request take_request() noexcept;
  void limit(const hardware::Cycle& cycle) noexcept;
  void publish(const hardware::Cycle& cycle, Request request) noexcept;
  void publish_components(Snapshot& draft) noexcept;
  void publish_world(const hardware::WorldState& world, Snapshot& draft) noexcept;

  LoopOptions options_;
  realtime::Jobs jobs_;
  hardware::InterfaceTable table_;
  hardware::Hardware hardware_{table_, jobs_};
  hardware::Exchange& exchange_ = hardware_.exchange();
  hardware::FaultEvents faults_;
  ControllerManager controllers_{table_, hardware_, jobs_};
  Supervisor supervisor_;
  CommandLimits limits_;
  class SetTap;
  BlackBox black_box_;
  CycleTap* tap_ = nullptr;
  Nanoseconds last_wake_ = 0, last_cost_ = 0;
  Health health_;
  TraceHash trace_;
  std::vector<std::uint32_t> traced_;  // indices of joint position states
  realtime::Queue<Request> inbox_{64};
  realtime::Latest<Snapshot> outbox_;
  hardware::Cycle cycle_;
  unsigned late_in_a_row_ = 0;
  bool paced_ = false;
  Nanoseconds began_ = 0;  // the last cycle, on the wall clock
};

/// The box is empty before the job is done, and then what the loop had recorded.
class ControlLoop::TakeBlackBox : public realtime::Job {
 public:
  explicit TakeBlackBox(BlackBox& running) : box(running.empty_one()), running_(running) {}
  void run() noexcept override { std::swap(running_, box); }
  BlackBox box;

 private:
  BlackBox& running_;
};

}  // namespace polyarm::control
