#pragma once
/// The control loop: hardware, controllers, limits and supervisor of a cell, and the function that runs one
/// cycle.
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
#include "polyarm/realtime/zeros.hpp"

namespace polyarm::control {

/// Counts of a component's thread: runs, late runs, missed turns.
struct ThreadCounts {
  std::uint64_t runs = 0, late = 0, missed = 0;
};

/// A complete copy of one cycle for observers; only the newest is kept.
struct Snapshot {
  hardware::Cycle cycle;
  RunState state = RunState::running;
  StopCause cause = StopCause::none;
  FaultEvent event;  ///< what led to this state
  bool standing = true;
  StopTimes stop;
  std::vector<double> states, commands;
  hardware::WorldState world;
  std::vector<ThreadCounts> threads;  ///< by component; zeros without a thread
  std::vector<StopCause> fallen;      ///< by component: cause of its failure; none: it works, or works again
};

/// Records the last cycles: measured states, commands, and the loop's state. One thread records; read only a
/// box that this thread has released.
class BlackBox {
 public:
  struct Row {
    std::uint64_t cycle = 0;
    RunState state = RunState::running;
    StopCause cause = StopCause::none;
    Request request = Request::none;  ///< the request taken in this cycle
    std::span<const double> states, commands;
  };
  /// Room for `rows` rows, or for as many as `most_bytes` hold. `at_once`: see Zeros.
  void build(std::size_t states, std::size_t commands, std::size_t rows,
             std::size_t most_bytes = static_cast<std::size_t>(-1), bool at_once = true);
  void record(const Row& row) noexcept;
  std::size_t rows() const noexcept { return filled_; }
  /// Row 0 is the oldest.
  Row row(std::size_t i) const noexcept;
  /// An empty box of the same size.
  BlackBox empty_one() const;

 private:
  struct Head {
    std::uint64_t cycle;
    RunState state;
    StopCause cause;
    Request request;
  };
  realtime::Zeros<Head> heads_;
  realtime::Zeros<double> data_;
  bool at_once_ = true;
  std::size_t states_ = 0, width_ = 0, capacity_ = 0, next_ = 0, filled_ = 0;
};

/// Counters that the control thread writes and any thread may read.
struct Health {
  realtime::Counter cycles;
  realtime::Counter gaps;       ///< gaps of at least kGap that did not cause a hold
  realtime::Counter late;       ///< cycles that woke more than half a period late or were skipped
  realtime::Histogram cost;     ///< of step(), ns
  realtime::Histogram wake_up;  ///< latency relative to the time grid, ns; empty in lock-step
  realtime::Histogram period;   ///< between the starts of two cycles, ns; empty in lock-step
};

struct LoopOptions {
  Nanoseconds period = 1'000'000;
  std::size_t black_box_rows = 10'000;
  bool measure = true;         ///< measure the cost of each cycle
  bool measure_parts = false;  ///< also of each component and controller
  bool limits = true;          ///< restrict commands; off only to measure their cost
  Overrun overrun = Overrun::report;
  unsigned overrun_after = 10;  ///< late cycles in a row
  bool publish = true;          ///< snapshot and cycle records; off only to measure their cost
  /// False: the black box takes memory as it is filled, so that a short run with many robots takes little.
  /// Only for a loop that no clock drives.
  bool memory_at_once = true;
  /// True: a gap of at least kGap holds the robots; otherwise it is counted in Health::gaps. Empty: true if a
  /// component is real.
  std::optional<bool> stall_holds = true;
};

/// One control loop with its table, hardware, controllers and supervisor. Build and destroy it while nobody
/// steps it. step() belongs to the control thread; inbox and outbox to one other thread.
class ControlLoop {
 public:
  explicit ControlLoop(const LoopOptions& options);

  hardware::InterfaceTable& table() { return table_; }
  hardware::Hardware& hardware() { return hardware_; }
  ControllerManager& controllers() { return controllers_; }
  Supervisor& supervisor() { return supervisor_; }
  CommandLimits& limits() { return limits_; }
  const CommandLimits& limits() const { return limits_; }
  /// Call only when nobody steps any more.
  const BlackBox& black_box() const { return black_box_; }
  /// Takes the recorded cycles out of the running loop, which continues with an empty box. The caller owns
  /// the box when the job is done. Throws Error("busy").
  class TakeBlackBox;
  std::shared_ptr<TakeBlackBox> take_black_box();
  const LoopOptions& options() const { return options_; }

  /// Creates a tap with room for `rows` cycles; it records one of `every` cycles.
  std::unique_ptr<CycleTap> make_tap(std::size_t rows, unsigned every) const;
  /// Records into `tap` from the next cycle on; null: stops recording. The previous tap must live until the
  /// job is done. Throws Error("busy").
  std::shared_ptr<realtime::Job> tap(CycleTap* tap);

  /// Configures and activates the hardware, reads it once, and allocates everything that a cycle needs.
  void start_hardware();
  void start_hardware(hardware::Caller& caller);
  /// Sets up limits, snapshot and hash; call after the controllers are added.
  void prepare(const std::vector<controllers::JointFacts>& joints);

  /// After begin() a control thread steps the loop, and requests of controllers and hardware are executed
  /// between two cycles. Before begin() and after end() they are executed at once on the calling thread.
  void begin() { jobs_.start(); }
  void end() { jobs_.stop(); }
  realtime::Jobs& jobs() { return jobs_; }

  /// One cycle. `gap`: wall time is missing since the last cycle.
  controllers::Verdict step(const hardware::Cycle& cycle, bool gap = false) noexcept;
  /// One cycle at the loop's own time, which advances by one period.
  controllers::Verdict step_next(bool gap = false) noexcept;
  /// Call before a cycle with its wake-up latency, ns, and the number of skipped periods; the options decide
  /// on the reaction. Returns true if wall time is missing.
  bool woke(Nanoseconds latency, std::uint64_t skipped) noexcept;
  hardware::Cycle cycle() const noexcept { return cycle_; }

  /// Shortest gap in wall time that makes the loop hold instead of continuing: a suspended process, a
  /// sleeping laptop. Ordinary lateness on a busy machine is shorter.
  static constexpr Nanoseconds kGap = 500'000'000;
  /// The option `stall_holds`, or true if a component is real.
  bool holds_after_gap() const;

  /// Call from one other thread; each cycle takes at most one request.
  bool post(Request request) { return inbox_.push(request); }
  realtime::Latest<Snapshot>& outbox() noexcept { return outbox_; }
  Health& health() noexcept { return health_; }
  /// Hash of all joint positions and part positions of all cycles so far.
  const TraceHash& trace() const noexcept { return trace_; }

 private:
  /// Lets the supervisor decide on the pushed faults, and switches components off as decided.
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
  Nanoseconds began_ = 0;  // start of the last cycle on the wall clock
};

/// The box is empty until the job is done; then it contains the loop's recording.
class ControlLoop::TakeBlackBox : public realtime::Job {
 public:
  explicit TakeBlackBox(BlackBox& running) : box(running.empty_one()), running_(running) {}
  void run() noexcept override { std::swap(running_, box); }
  BlackBox box;

 private:
  BlackBox& running_;
};

}  // namespace polyarm::control
