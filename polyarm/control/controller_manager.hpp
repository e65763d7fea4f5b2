#pragma once
/// The controllers of one loop: their life cycle, switching between them, and their updates.
#include <atomic>
#include <cstdint>
#include <functional>
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

/// Options of a loaded controller.
struct LoadOptions {
  unsigned divisor = 1;  ///< updated every `divisor` cycles
  /// For a rate that does not divide the loop's, ns: updated in the first cycle that starts at or after a
  /// multiple of this period, so rounding up to a cycle does not accumulate. 0: use the divisor.
  Nanoseconds period = 0;
  bool async = false;      ///< runs on a thread of its own
  bool lock_step = false;  ///< async work runs inline; its result is used one period later
  realtime::ThreadOptions thread = {};
  std::vector<std::string> fallback = {};  ///< controllers to start if it fails
  Nanoseconds budget = 0;                  ///< limit of each update in the loop, ns; 0: unlimited
};

/// An action of the loop that the cell thread reports.
struct LoopEvent {
  enum class Kind : std::uint8_t {
    controller_failed,   ///< its update returned an error; it and its chain are now inactive
    controller_stopped,  ///< stopped together with another controller or with its hardware
    fallback_started,
    component_failed,
    component_deactivated,
    commands_stale,  ///< commands streamed to a controller are older than its command_timeout
  };
  Kind kind;
  std::int32_t who = -1;  ///< id of the controller or index of the component
  std::uint64_t cycle = 0;
};

struct ListedController {
  std::string name, type;
  hardware::LifecycleState state;
  bool chained = false, async = false;
  bool stale = false;  ///< its last command is too old
  unsigned divisor = 1;
  Nanoseconds period = 0;  ///< for a rate that does not divide the loop's
  std::uint64_t updates = 0, missed = 0;
  const realtime::ThreadHealth* thread = nullptr;  ///< null without a thread
  const realtime::PartHealth* part = nullptr;      ///< cost of its updates in the loop; null if not measured
  std::vector<std::string> claimed, required_commands, required_states, references, exported, fallback;
};

/// Manages the controllers of one loop: their life cycle, their names in the table, claims (one controller
/// per command; any number of readers per state), and the order of updates. All functions belong to the cell
/// thread, except update() and those beside it; decisions reach the loop between two cycles. While no loop is
/// running (Jobs not started), they take effect at once.
class ControllerManager {
 public:
  ControllerManager(hardware::InterfaceTable& table, hardware::Components& hardware, realtime::Jobs& jobs);
  ~ControllerManager();

  /// → unconfigured. Throws Error("duplicate-controller").
  void load(std::unique_ptr<controllers::Controller> controller, controllers::ControllerContext context,
            LoadOptions options = {});
  /// unconfigured → inactive. Throws Error with all errors of its parameters, or with the interface that does
  /// not exist; the controller then stays unconfigured (or is finalized, if its on_error says so).
  void configure(const std::string& name);
  /// The same for one of many while no loop is running; call refresh() once after all of them.
  void configure_only(const std::string& name);
  /// Binds all controllers again and creates a new schedule.
  void refresh();
  void cleanup(const std::string& name);  ///< inactive → unconfigured
  void unload(const std::string& name);   ///< anything but active → gone
  /// Calls load() and configure().
  void add(std::unique_ptr<controllers::Controller> controller, controllers::ControllerContext context,
           LoadOptions options = {});

  /// The effect of a switch, or why it is not possible.
  SwitchPlan plan(const SwitchRequest& request) const;
  class Switch;
  /// Begins a switch; it is complete when done(). Throws Error with the reason of a refusal. finish() throws
  /// Error if an activation failed, and returns false if the loop changed controllers by itself meanwhile:
  /// then begin again.
  std::shared_ptr<Switch> begin_switch(const SwitchRequest& request);
  bool finish(Switch& done);
  /// These begin and finish a switch while no loop is running.
  void activate(const std::string& name);
  void deactivate(const std::string& name);
  void switch_now(const SwitchRequest& request);

  /// New values of changeable parameters, written between two cycles. Throws Error for values that cannot be
  /// set.
  std::shared_ptr<realtime::Job> begin_change(const std::string& name,
                                              const std::vector<std::pair<std::string, std::string>>& values);
  /// The warnings about the parameters of `name` (unknown and superseded keys).
  std::vector<Problem> findings(const std::string& name) const;

  /// Looks up names again and creates a new schedule; call after the table was sealed.
  void bind_all();
  /// Actions of the loop since the last call.
  std::vector<LoopEvent> take_events();
  /// The next update that took longer than its budget; `who` is the controller's id.
  bool take_overrun(realtime::Overrun& out) { return overruns_.take(out); }

  controllers::Controller* find(const std::string& name) const;
  const controllers::ControllerContext* context(const std::string& name) const;
  std::vector<ListedController> list() const;
  /// The loaded controllers and their states, in the order of list().
  std::vector<std::pair<controllers::Controller*, hardware::LifecycleState>> loaded() const;
  /// Names of the loaded controllers, for hints.
  std::vector<std::string> names() const;
  std::vector<std::string> active_names() const;
  /// Calls `call` with the name of each active controller; allocates nothing.
  void for_each_active(const std::function<void(const std::string&)>& call) const;
  std::string name_of(int id) const;
  /// Id of the controller that the control thread is updating; -1: none. Any thread.
  int in_call() const noexcept { return in_call_.load(std::memory_order_relaxed); }
  /// Name of the active controller that claims the command, or "".
  std::string holder_of(const std::string& command) const;

  /// Call before the loop runs: the cycle for controllers that start at once.
  void set_cycle(const hardware::Cycle& cycle) { now_ = cycle; }
  /// Call before the loop runs: enables timing of each controller in each cycle.
  void measure(bool on) noexcept { measuring_ = on; }

  // --- control thread ---
  /// Updates the active controllers in order. A failure without a fallback is a fault event.
  void update(const hardware::Cycle& cycle, const controllers::Verdict& verdict,
              hardware::FaultEvents& faults) noexcept;
  /// Stops the controllers that use the component with this index.
  void component_failed(std::size_t component, bool deactivated, const hardware::Cycle& cycle) noexcept;
  /// True if a fault of the component affects its group only. False if a controller of the group also
  /// commands other components. False for -1.
  bool contains(std::int32_t component) const noexcept;
  /// True if no active controller requests motion.
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
  std::unique_ptr<Commit> failure_commit_of(const std::vector<Slot*>& slots, std::span<const ControllerView> views,
                                  std::span<const ControllerView> chain, std::size_t who) const;
  std::set<std::size_t> components_of(const ControllerView& view) const;
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
  void release_now(const Commit& commit) noexcept;
  void fall(Commit& commit, const Slot* culprit, const hardware::Cycle& cycle) noexcept;

  hardware::InterfaceTable& table_;
  hardware::Components& hardware_;
  realtime::Jobs& jobs_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::vector<std::pair<std::shared_ptr<realtime::Job>, std::unique_ptr<Slot>>> leaving_;
  controllers::SharedList<std::string> state_names_, command_names_;
  std::uint64_t named_at_ = ~std::uint64_t{0};  // number of table changes at which these were made
  int next_id_ = 0;
  std::uint64_t known_epoch_ = 0;
  realtime::Queue<LoopEvent> events_{256};
  realtime::OverrunWatch overruns_;

  // control thread
  std::unique_ptr<Schedule> schedule_;
  hardware::Cycle now_;
  std::uint64_t epoch_ = 0;  // counts the loop's own changes
  bool measuring_ = false;
  std::atomic<int> in_call_{-1};
};

/// A switch in progress.
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
