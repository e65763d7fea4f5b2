#pragma once
/// All components of one control loop: their life cycle, their places in the interface table, and one call
/// each to read and to write them all.
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/hardware/own_clock.hpp"
#include "polyarm/hardware/transition.hpp"
#include "polyarm/realtime/async_runner.hpp"
#include "polyarm/realtime/jobs.hpp"
#include "polyarm/realtime/overrun_watch.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::hardware {

enum class FaultKind : std::uint8_t {
  none,
  component_read,
  component_write,
  component_deactivated,
  not_a_number,   ///< a joint's measured position was a number and is none any more
  jump,           ///< a joint's measured position changed by more than it can have moved
  not_following,  ///< a joint is far from where it is commanded to be, for too long
  late,           ///< its thread was late for too long
  outside,        ///< a joint is far outside its limits
  controller,     ///< a controller that works on it alone failed
};

/// What went wrong in a cycle, as numbers; texts are made outside the loop.
struct Fault {
  FaultKind kind = FaultKind::none;
  std::int32_t component = -1;  ///< index of the component
  explicit operator bool() const noexcept { return kind != FaultKind::none; }
};

/// A joint whose measured position is watched, and told from what is possible.
struct WatchedJoint {
  std::size_t state = 0;  ///< index of its position among the states
  int command = -1;       ///< index of its position command; -1: none
  double velocity = 0;    ///< rad/s or m/s, infinite where nobody states one
};

/// A value that a test of a fault forces onto an interface, over whatever hardware or controllers say.
struct ForcedValue {
  bool state = false;  ///< else command
  std::size_t index = 0;
  double value = 0;
};

/// What follows when a component's thread is late, or misses its turn, too often in a row. It is told in any
/// case, once until the component is let in again.
enum class WhenLate : std::uint8_t {
  report,  ///< no more
  hold,    ///< the loop stops on the path and holds
  fault,   ///< as if the component had failed
};

/// How a component is kept.
struct HostOptions {
  unsigned divisor = 1;  ///< it is read and written every so many cycles
  bool async = false;    ///< on a thread of its own
  /// Of an async component's own clock, ns; any, and `divisor` counts no more. 0: its thread is triggered by
  /// the loop, every `divisor` cycles.
  Nanoseconds period = 0;
  bool lock_step = false;  ///< async work is done inline
  realtime::ThreadOptions thread = {};
  WhenLate when_late = WhenLate::report;  ///< of its thread
  unsigned late_after = 10;               ///< runs in a row that were late, or turns that were missed
  Nanoseconds budget = 0;                 ///< of each read and write in the loop, ns; 0: any
  std::string group;                      ///< components of one group fail together
  bool contained = false;                 ///< its fault concerns its group alone, not the whole loop
  std::string plugin, type;               ///< as the description has them, for listing
  LifecycleState initial = LifecycleState::active;  ///< what configure_and_activate() takes it to
  /// How far a joint may be from its command for kFollowingTime, rad or m; infinite: as far as it likes. The
  /// component's parameter `following_error`; without it kRealFollowingError for what is real, else infinite.
  double following_error = std::numeric_limits<double>::infinity();
};
inline constexpr double kRealFollowingError = 0.35;
inline constexpr Nanoseconds kFollowingTime = 250'000'000;
/// Between two reads a joint's measured position changes by at most this many times what its velocity allows
/// in the time that may lie between them, and kJumpFloor (rad or m) of noise and rounding. That time is the
/// period of the reads; with a thread, from where the exchange before began to the end of this one.
inline constexpr double kJumpFactor = 5, kJumpFloor = 0.02;

/// A component as others may see it.
struct HostedInfo {
  std::string name, plugin, type, group;
  LifecycleState state;
  unsigned divisor;
  bool async;
  Nanoseconds period;  ///< of a component with a clock of its own; else 0
  std::uint64_t missed;
  std::vector<std::string> states, commands;
};

/// Building and life cycle: the cell thread. read(), write() and perform_mode_switch(): the control thread.
class Hardware {
 public:
  Hardware(InterfaceTable& table, realtime::Jobs& jobs) : table_(table), jobs_(jobs) {}
  ~Hardware();

  /// Initialises the component and enters its interfaces into the table. Throws Error when it refuses.
  void add(std::unique_ptr<Component> component, const ComponentContext& context, HostOptions options = {});
  /// Every component to its initial state, in order of addition. Throws Error that names component and step.
  void configure_and_activate();
  void configure_and_activate(Caller& caller);
  /// active → inactive → finalized, in reverse order. Never throws. Components whose callbacks, or whose
  /// thread's read or write, the caller gives up waiting for are left behind, never freed, and are no more
  /// among these; false when there are such. The control thread has ended.
  bool shut_down() noexcept;
  bool shut_down(Caller& caller) noexcept;

  /// A callback whose device may take its time: run it on any thread, and when it is done, finish() here
  /// takes the component to its new state and returns what has to be run next (on_error after an error), null
  /// when it is over. In between nobody else calls the component but the loop, and what is asked of it is
  /// refused with Error("busy"). For deactivate, cleanup and shutdown the loop has let go before: see
  /// begin_deactivate() and begin_cleanup(). Both throw as the transitions below.
  std::shared_ptr<Transition> begin(std::size_t i, Step step);
  std::shared_ptr<Transition> begin_replace(std::size_t i, std::unique_ptr<Component> component,
                                            const ComponentContext& context);
  std::shared_ptr<Transition> finish(Transition& done);
  /// Throws Error("busy") while the component is in a callback.
  void require_idle(std::size_t i) const { require_idle(*hosted_[i]); }
  /// The callback that the component is in; null: none.
  const Transition* pending(std::size_t i) const noexcept { return hosted_[i]->pending.get(); }

  // One transition each, as the reference has them; the callback runs in the calling thread, and the loop
  // reads and writes the component from the next cycle on, or no more. Throws Error("wrong-state") when the
  // component is not where the transition begins, Error("component-failed") when a callback returns failure
  // or error (after an error, on_error decides between unconfigured and finalized).
  void configure(std::size_t i);  ///< unconfigured → inactive: states are read
  void activate(std::size_t i);   ///< inactive → active: commands are written
  /// active → inactive in two steps, between which the loop lets go: begin_…() posts, finish_…() calls back.
  std::shared_ptr<realtime::Job> begin_deactivate(std::size_t i);
  void finish_deactivate(std::size_t i);
  std::shared_ptr<realtime::Job> begin_cleanup(std::size_t i);  ///< inactive → unconfigured
  void finish_cleanup(std::size_t i);
  void finish_shutdown(std::size_t i);  ///< after begin_cleanup: any → finalized
  /// The loop has taken the component off after a failure: on_error() decides what it becomes.
  void recover_from_error(std::size_t i);
  /// A new component in the place of one that is unconfigured or finalized. It must offer the same
  /// interfaces; throws Error naming the first that differs.
  void replace(std::size_t i, std::unique_ptr<Component> component, const ComponentContext& context);

  /// Forces every state and command interface with this name, until NaN is forced on it; not while another
  /// thread steps the loop. Throws Error("unknown-interface") if there is none.
  void force(const std::string& interface_name, double value);

  Fault read(const Cycle& cycle) noexcept;
  Fault write(const Cycle& cycle) noexcept;
  /// What befell the component in the last read() or write(); it has been taken off. Told once.
  enum class Fall : std::uint8_t { none, deactivated, error };
  Fall newly_failed(std::size_t i) noexcept { return std::exchange(hosted_[i]->newly_failed, Fall::none); }
  /// With what the component, or another of its group, has fallen; none: it is active since. Control thread.
  FaultKind fallen(std::size_t i) const noexcept { return hosted_[i]->fallen; }
  /// Takes the component off, with its group, for a reason that others found: `what` is the command whose
  /// joint is outside its limits. Control thread; newly_failed() tells it.
  void fail_for(std::size_t i, FaultKind kind, std::int32_t what) noexcept;
  bool contained(std::size_t i) const { return hosted_[i]->options.contained; }
  /// The component's commands begin anew, as measured: it was let in since it was asked last. Control thread.
  bool take_restarted(std::size_t i) noexcept { return std::exchange(hosted_[i]->restarted, false); }
  /// First command and number of commands of a component.
  std::pair<std::size_t, std::size_t> commands_of(std::size_t i) const noexcept {
    return {hosted_[i]->first_command, hosted_[i]->commands};
  }
  bool prepare_mode_switch(std::span<const std::string> start, std::span<const std::string> stop);
  bool perform_mode_switch(std::span<const std::string> start, std::span<const std::string> stop) noexcept;

  /// The first simulated world among the components, or null.
  const WorldState* world() const noexcept { return world_.load(std::memory_order_acquire); }
  const std::vector<std::string>& world_names() const { return world_names_; }
  std::size_t size() const noexcept { return hosted_.size(); }
  const std::string& component_name(std::size_t i) const { return hosted_[i]->name; }
  const std::string& group(std::size_t i) const { return hosted_[i]->options.group; }
  LifecycleState state_of(std::size_t i) const { return hosted_[i]->state.load(std::memory_order_acquire); }
  HostedInfo info(std::size_t i) const;
  /// How the component's thread is doing; null where it has none. Any thread.
  const realtime::ThreadHealth* thread_health(std::size_t i) const noexcept;
  /// What its read and write in the loop cost together; empty for one with a thread, and unless measured.
  const realtime::PartHealth& part_health(std::size_t i) const noexcept { return hosted_[i]->part; }
  /// Before the loop runs: whether each component is timed in each cycle.
  void measure(bool on) noexcept { measuring_ = on; }
  WhenLate when_late(std::size_t i) const { return hosted_[i]->options.when_late; }
  const realtime::ThreadOptions& thread_options(std::size_t i) const { return hosted_[i]->options.thread; }
  /// The component that offers the interface; -1: none.
  int component_of_state(std::size_t index) const;
  int component_of_command(std::size_t index) const;
  int find(std::string_view name) const;
  std::vector<std::string> summaries() const;
  /// The next read or write that took longer than its budget; `who` is the component's index.
  bool take_overrun(realtime::Overrun& out) { return overruns_.take(out); }
  /// The next component whose thread is late beyond what its options say.
  bool take_late(std::int32_t& who) { return late_.pop(who); }
  /// Is the loop to hold, as a thread is late? Told once. Control thread.
  bool take_hold() noexcept { return std::exchange(hold_, false); }
  /// Wall time passed without cycles: joints may have moved on for so long. Control thread.
  void skipped(Nanoseconds time) noexcept { skipped_ += time; }
  /// From here on the positions of these joints are watched; one that cannot be true is a fault of its
  /// component, as if it had failed itself.
  void watch(const std::vector<WatchedJoint>& joints, Nanoseconds period);
  /// The component whose read or write the control thread is in; -1: none. Any thread.
  int in_call() const noexcept { return in_call_.load(std::memory_order_relaxed); }
  /// Waits for the active component that paces the loop, if there is one: nothing where there is none.
  /// Control thread.
  std::optional<bool> await_cycle(Nanoseconds timeout) noexcept;
  bool real(std::size_t i) const { return hosted_[i]->component->real(); }
  /// Why the component failed last: what was watched, else its own words; may be empty.
  std::string reason(std::size_t i) const;
  /// Of that, the component's own words; may be empty.
  std::string own_reason(std::size_t i) const;
  /// The interface whose value was the reason; empty: none was.
  std::string blamed_interface(std::size_t i) const;

 private:
  /// Two lists side by side: the first is gone through in every cycle, and kept small for it.
  struct Watch {
    double last = std::numeric_limits<double>::quiet_NaN();
    float speed;  ///< largest change in a second, without the floor
    std::uint32_t state;
  };
  struct Following {
    int command;
    std::uint32_t behind = 0;  ///< cycles in which it was too far from its command
  };
  struct Hosted {
    std::string name;
    std::unique_ptr<Component> component;
    HostOptions options;
    std::atomic<LifecycleState> state{LifecycleState::unconfigured};
    std::shared_ptr<Transition> pending;  // shared with the thread that runs it
    std::atomic<bool> busy{false};        // the same, for the control thread
    std::size_t first_state = 0, states = 0, first_command = 0, commands = 0;
    std::unique_ptr<realtime::AsyncRunner> runner;
    std::unique_ptr<OwnClock> own_clock;           // in place of a runner
    std::vector<double> own_states, own_commands;  // of an async component
    Cycle own_cycle;
    std::atomic<ReturnType> own_result{ReturnType::ok};
    std::atomic<bool> ran{false};    // an async component has read since it was let in
    Exchanged own_exchanged;         // when it did
    std::atomic<int> bad_state{-1};  // what was watched and found impossible; of `outside`, the command
    std::atomic<FaultKind> bad_kind{FaultKind::none};
    // the control thread's
    std::vector<Watch> watched;
    std::vector<Following> following;  // of the same joints
    bool reading = false, writing = false, restarted = false;
    Nanoseconds exchange_began = 0;  // of one with a thread: that of the states that were taken last
    Nanoseconds skips_seen = 0;
    realtime::PartHealth part;
    Nanoseconds read_at = 0, read_took = 0;
    bool late_told = false;
    unsigned missed_in_a_row = 0;  // of one that the loop triggers
    Fall newly_failed = Fall::none;
    FaultKind fallen = FaultKind::none;
  };
  class Letting;
  static void leave_behind(std::unique_ptr<Hosted> hosted);
  std::shared_ptr<realtime::Job> let(Hosted& hosted, bool reading, bool writing);
  void require(const Hosted& hosted, LifecycleState state, const char* what) const;
  void require_idle(const Hosted& hosted) const;
  std::shared_ptr<Transition> pend(std::size_t i, Step step);
  void succeed(Hosted& hosted, Step step);
  [[noreturn]] void fail(const Hosted& hosted, Step step, const std::string& thrown) const;
  void settle_error(Hosted& hosted, const Transition& done);
  void take_new(Hosted& hosted, Transition& done);
  void go(std::shared_ptr<Transition> next, Caller& caller);
  bool offers(const Hosted& hosted, std::span<const std::string> commands) const;
  void note_world();
  void make_runner(Hosted& hosted, Nanoseconds loop_period);
  FaultKind judge_states(Hosted& hosted, double between) noexcept;
  double between_reads(Hosted& hosted, const Cycle& cycle, const Exchanged& exchanged) noexcept;
  bool follows(Hosted& hosted) noexcept;
  bool newly_late(Hosted& hosted, std::size_t i) noexcept;
  Fault fail(std::size_t i, ReturnType result, FaultKind kind) noexcept;
  static void take_off(Hosted& hosted, Fall fall, FaultKind kind) noexcept;
  bool due(const Hosted& hosted, const Cycle& cycle) const noexcept {
    return hosted.options.divisor == 1 || cycle.index % hosted.options.divisor == 0;
  }
  ReturnType read_async(Hosted& hosted, std::span<double> states, Exchanged& exchanged) noexcept;
  void write_async(Hosted& hosted, const Cycle& cycle, std::span<const double> commands) noexcept;

  InterfaceTable& table_;
  realtime::Jobs& jobs_;
  std::vector<std::unique_ptr<Hosted>> hosted_;
  std::vector<ForcedValue> forced_;
  realtime::OverrunWatch overruns_;
  realtime::Queue<std::int32_t> late_{64};
  bool hold_ = false;
  bool measuring_ = false;
  Nanoseconds skipped_ = 0;  // since the beginning
  std::atomic<int> in_call_{-1};
  int pacer_ = -1;  ///< component that paces the loop
  std::uint32_t following_cycles_ = 250;
  std::atomic<const WorldState*> world_ = nullptr;
  std::vector<std::unique_ptr<Component>> retired_;  ///< replaced; the control thread may look at one's world
  std::vector<std::string> world_names_;
};

}  // namespace polyarm::hardware
