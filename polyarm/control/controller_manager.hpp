#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/control/switch_plan.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/hardware/components.hpp"
#include "polyarm/hardware/fault_event.hpp"
#include "polyarm/realtime/async_runner.hpp"
#include "polyarm/realtime/jobs.hpp"
#include "polyarm/realtime/overrun_watch.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::control {

/// How a controller is kept.
struct LoadOptions {
  unsigned divisor = 1;  ///< it is updated every so many cycles
  /// Where its rate is no part of the loop's, ns: it is updated in the first cycle that does not begin before
  /// a whole multiple of this, so that rounding up to a cycle does not add up; 0: by the divisor.
  Nanoseconds period = 0;
  bool async = false;      ///< on a thread of its own
  bool lock_step = false;  ///< async work is done inline, its result one period later
  realtime::ThreadOptions thread = {};
  std::vector<std::string> fallback = {};  ///< started when it fails
  Nanoseconds budget = 0;                  ///< of each update in the loop, ns; 0: any
};

/// What the loop did by itself, for the cell thread to tell.
struct LoopEvent {
  enum class Kind : std::uint8_t {
    controller_failed,   ///< its update returned an error; it and its chain are inactive
    controller_stopped,  ///< it was stopped with another, or with its hardware
    fallback_started,
    component_failed,
    component_deactivated,
    commands_stale,  ///< what is streamed to a controller has grown older than its command_timeout
  };
  Kind kind;
  std::int32_t who = -1;  ///< id of the controller, or index of the component
  std::uint64_t cycle = 0;
};

struct ListedController {
  std::string name, type;
  hardware::LifecycleState state;
  bool chained = false, async = false;
  bool stale = false;  ///< its last command has grown old
  unsigned divisor = 1;
  Nanoseconds period = 0;  ///< where its rate is no part of the loop's
  std::uint64_t updates = 0, missed = 0;
  const realtime::ThreadHealth* thread = nullptr;  ///< of one that has a thread
  const realtime::PartHealth* part = nullptr;      ///< what its updates in the loop cost; where measured
  std::vector<std::string> claimed, required_commands, required_states, references, exported, fallback;
};

/// Keeps the controllers of one loop: their life cycle, their names in the table, claims (commands to one
/// controller at a time, states to all), and their updates in order. Everything but update() and what stands
/// beside it belongs to the cell thread; what it decides reaches the loop between two cycles. As long as no
/// loop is running (Jobs not started), it is done at once.
class ControllerManager {
 public:
  ControllerManager(hardware::InterfaceTable& table, hardware::Components& hardware, realtime::Jobs& jobs);
  ~ControllerManager();

  /// → unconfigured. Throws Error("duplicate-controller").
  void load(std::unique_ptr<controllers::Controller> controller, controllers::ControllerContext context,
            LoadOptions options = {});
  /// unconfigured → inactive. Throws Error with everything that is wrong with its parameters, or naming the
  /// interface that does not exist; then it stays unconfigured (or is finalized, if its on_error says so).
  void configure(const std::string& name);
  /// The same for one of many, while no loop is running: refresh() has to follow, once for all of them.
  void configure_only(const std::string& name);
  /// Binds all controllers again and makes a new schedule.
  void refresh();
  void cleanup(const std::string& name);  ///< inactive → unconfigured
  void unload(const std::string& name);   ///< anything but active → gone
  /// load and configure.
  void add(std::unique_ptr<controllers::Controller> controller, controllers::ControllerContext context,
           LoadOptions options = {});

  /// What a switch would do, or why it cannot be.
  SwitchPlan plan(const SwitchRequest& request) const;
  class Switch;
  /// Begins a switch; it is over when done(). Throws Error with the reason of the refusal. finish() then
  /// throws Error where an activation failed, and returns false when the loop changed something by itself in
  /// the meantime: begin again.
  std::shared_ptr<Switch> begin_switch(const SwitchRequest& request);
  bool finish(Switch& done);
  /// Begins and finishes a switch while no loop is running.
  void activate(const std::string& name);
  void deactivate(const std::string& name);
  void switch_now(const SwitchRequest& request);

  /// New values of changeable parameters, written between two cycles. Throws Error for what cannot be.
  std::shared_ptr<realtime::Job> begin_change(const std::string& name,
                                              const std::vector<std::pair<std::string, std::string>>& values);
  /// The warnings of the parameters of `name` (unknown and superseded keys).
  std::vector<Problem> findings(const std::string& name) const;

  /// Looks names up again and makes a new schedule, after the table was sealed.
  void bind_all();
  /// What the loop did by itself since the last call.
  std::vector<LoopEvent> take_events();
  /// The next update that took longer than its budget; `who` is the controller's id.
  bool take_overrun(realtime::Overrun& out) { return overruns_.take(out); }

  controllers::Controller* find(const std::string& name) const;
  const controllers::ControllerContext* context(const std::string& name) const;
  std::vector<ListedController> list() const;
  /// Those that are loaded and their states, in the order of list().
  std::vector<std::pair<controllers::Controller*, hardware::LifecycleState>> loaded() const;
  /// Names of the controllers that the loaded ones have, for hints.
  std::vector<std::string> names() const;
  std::string name_of(int id) const;
  /// Id of the controller whose update the control thread is in; -1: none. Any thread.
  int in_call() const noexcept { return in_call_.load(std::memory_order_relaxed); }
  /// Name of the active controller that claims the command, or "".
  std::string holder_of(const std::string& command) const;

  /// Before the loop runs: the cycle at which controllers that start at once do so.
  void set_cycle(const hardware::Cycle& cycle) { now_ = cycle; }
  /// Before the loop runs: whether each controller is timed in each cycle.
  void measure(bool on) noexcept { measuring_ = on; }

  // --- control thread ---
  /// Updates the active controllers in order. One that fails with nobody to take its place is a fault event.
  void update(const hardware::Cycle& cycle, const controllers::Verdict& verdict,
              hardware::FaultEvents& faults) noexcept;
  /// Stops the controllers that use the component, whose place in the hardware is `component`.
  void component_failed(std::size_t component, bool deactivated, const hardware::Cycle& cycle) noexcept;
  /// Does a fault of the component concern its group alone? Not when a controller that works on the group
  /// commands others, too. False for -1.
  bool contains(std::int32_t component) const noexcept;
  /// True when no active controller asks for motion.
  bool standing() const noexcept;

 private:
  struct Slot;
  struct Commit;
  struct Schedule;
  class NewSchedule;
  friend class Switch;

  Slot& slot(const std::string& name) const;
  ControllerView view(const Slot& slot) const;
  std::vector<ControllerView> views() const;
  std::string why_unavailable(const std::string& interface, bool command) const;
  void bind(Slot& slot);
  void withdraw(Slot& slot);
  void name_interfaces(controllers::ControllerContext& context);
  void make_runner(Slot& slot);
  std::unique_ptr<Commit> commit_of(const SwitchPlan& plan) const;
  std::unique_ptr<Schedule> make_schedule(const std::vector<std::string>& active) const;
  std::unique_ptr<Commit> fall_of(const std::vector<Slot*>& slots, std::span<const ControllerView> views,
                                  std::span<const ControllerView> chain, std::size_t who) const;
  std::set<std::size_t> components_of(const ControllerView& view) const;
  std::vector<std::string> active_names() const;
  int home_of(std::span<const ControllerView> chain) const;
  std::vector<char> contained_components(std::span<const char> tied) const;
  bool commands_beyond(const ControllerView& view, std::size_t component) const;
  void post_schedule();

  // control thread
  controllers::ReturnType run(Slot& slot, const hardware::Cycle& cycle,
                              const controllers::Verdict& verdict) noexcept;
  controllers::ReturnType run_async(Slot& slot, const hardware::Cycle& cycle,
                                    const controllers::Verdict& verdict) noexcept;
  void start(Slot& slot, const hardware::Cycle& cycle, Commit& commit) noexcept;
  void stop(Slot& slot, const hardware::Cycle& cycle) noexcept;
  void execute(Commit& commit, const hardware::Cycle& cycle) noexcept;
  void let_go(const Commit& commit) noexcept;
  void fall(Commit& commit, const Slot* culprit, const hardware::Cycle& cycle) noexcept;

  hardware::InterfaceTable& table_;
  hardware::Components& hardware_;
  realtime::Jobs& jobs_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::vector<std::pair<std::shared_ptr<realtime::Job>, std::unique_ptr<Slot>>> leaving_;
  controllers::SharedList<std::string> state_names_, command_names_;
  std::uint64_t named_at_ = ~std::uint64_t{0};  // changes of the table that these have
  int next_id_ = 0;
  std::uint64_t known_epoch_ = 0;
  realtime::Queue<LoopEvent> events_{256};
  realtime::OverrunWatch overruns_;

  // control thread
  std::unique_ptr<Schedule> schedule_;
  hardware::Cycle now_;
  std::uint64_t epoch_ = 0;  // counts what the loop did by itself
  bool measuring_ = false;
  std::atomic<int> in_call_{-1};
};

/// A switch on its way.
class ControllerManager::Switch : public realtime::Job {
 public:
  Switch(ControllerManager& manager, SwitchPlan plan);
  ~Switch() override;
  void run() noexcept override;
  const SwitchPlan& plan() const { return plan_; }

 private:
  friend class ControllerManager;
  ControllerManager& manager_;
  SwitchPlan plan_;
  std::unique_ptr<Commit> commit_;
  std::unique_ptr<Schedule> schedule_;
  std::uint64_t epoch_;
  bool stale_ = false;
};

}  // namespace polyarm::control
