#pragma once
/// The control loop of a cell with its controllers and hardware, and reports of what the loop did by itself.
#include <atomic>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/control/control_loop.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/machine/hardware_calls.hpp"
#include "polyarm/machine/stops.hpp"
#include "polyarm/setup/cell_setup.hpp"

namespace polyarm::cell {

/// A component that is being rebuilt from the files. Read it when `done` is true.
struct Remaking {
  std::atomic<bool> done{false};
  std::string name;
  mutable Remade made;  ///< its parts are moved out when the reload begins
  std::exception_ptr failed;
};

class Machine;

/// A switch of controllers between two cycles. It restarts if the loop has changed controllers by itself
/// meanwhile. Cell thread.
class ControllerSwitch {
 public:
  /// Starts the switch. Throws Error if it is refused.
  ControllerSwitch(Machine& machine, control::SwitchRequest request);
  /// Advances the switch; true when it is done. Throws Error if an activation failed.
  bool advance();
  const control::SwitchPlan& plan() const;

 private:
  Machine& machine_;
  control::SwitchRequest request_;
  std::shared_ptr<control::ControllerManager::Switch> job_;
  int tries_ = 0;
};

/// Cell thread, except the loop's step (control thread; the same thread in lock-step).
class Machine {
 public:
  Machine(CellSetup& setup, Observer& observer);

  // Construction; call in this order. Each function throws Error.
  void make_loop(const ros_files::ControllersFile& described);
  void add_hardware(Problems& problems);
  void start_hardware();
  /// Call after the controllers are made; nothing may be added to the loop after this.
  void prepare();
  /// False if a component is still in a call and uses its robots; the robots must then stay alive until the
  /// process ends.
  bool shut_hardware_down(Nanoseconds patience);

  control::ControlLoop& loop() { return *loop_; }
  const control::ControlLoop& loop() const { return *loop_; }
  control::ControllerManager& controllers() const { return loop_->controllers(); }
  hardware::Hardware& hardware() const { return loop_->hardware(); }
  control::Supervisor& supervisor() const { return loop_->supervisor(); }
  const control::Health& health() const { return loop_->health(); }
  hardware::InterfaceTable& table() const { return loop_->table(); }
  Nanoseconds period() const { return loop_->options().period; }
  /// The newest snapshot of the loop that this tick has fetched.
  const control::Snapshot& snapshot() const { return loop_->outbox().value(); }
  /// Fetches the newest snapshot. `now`: cell time of the tick.
  void begin_tick(Nanoseconds now);
  Nanoseconds now() const { return now_; }
  const Nanoseconds& clock() const { return now_; }
  /// Throws Error("busy").
  void post(control::Request request) const;
  /// The joints of all robots; valid after prepare().
  const JointPlaces& joint_places() const { return joint_places_; }

  /// Stops the robots on their paths. `why` is the cause until the loop runs again.
  void hold_for(Problem why);
  /// The cell's own reason for stopping the loop; empty once it runs again.
  const std::optional<Problem>& held_by() const { return held_by_; }

  /// Reports what the loop did by itself, and lets failed components choose their next state.
  void report_events();
  /// The controllers that stopped because the component failed, since the last call.
  std::vector<std::string> take_failed(const std::string& component);
  /// The same; they stay for the next call.
  std::vector<std::string> stopped_with(const std::string& component) const;
  /// Outcomes of the controller's latest goals, oldest first.
  const std::vector<controllers::GoalEvent>& goal_events(const std::string& controller);
  void forget_goals(const std::string& controller) { goal_events_.erase(controller); }
  /// Hardware callbacks that may take long.
  HardwareCalls& calls() { return calls_; }

  /// Loads and configures a controller while the cell runs, with the given type and parameters, or with those
  /// under its name in the controllers' files. `file`: a controllers' file to read instead of the cell's own.
  /// Returns the warnings. If configuring fails, nothing is loaded.
  Problems load_controller(const std::string& name, const std::string& type,
                           controllers::Parameters parameters, const std::string& file);

  /// Starts to read the descriptions again, on `worker`, and to rebuild the component with this name.
  std::shared_ptr<const Remaking> remake(const std::string& name, Worker& worker) const;
  /// Call when that is done: replaces the unconfigured component by the rebuilt one. Kinematics and limits
  /// stay as they were at the start of the cell. Throws Error if the files contain errors.
  std::shared_ptr<hardware::Transition> begin_reload(const Remaking& remade);

  /// The controllers to start when the cell is armed, or at once if nothing is real.
  std::vector<std::string> chosen_controllers;

 private:
  void forget_hold_if_running();
  void report_overruns();
  void report_threads();
  void report_loop_event(const control::LoopEvent& event);

  CellSetup& setup_;
  Observer& observer_;
  HardwareCalls calls_;
  std::map<std::pair<std::string, std::string>, std::uint64_t> overruns_;  // by name and callback
  std::vector<char> reported_threads_;  // by component: true if its thread's refusals were reported
  std::unique_ptr<control::ControlLoop> loop_;
  std::map<std::string, std::vector<controllers::GoalEvent>> goal_events_;
  std::map<std::string, std::vector<std::string>> failed_components_;  // component → controllers
  std::string falling_;                                     // component whose failure is being reported
  JointPlaces joint_places_;
  std::optional<Problem> held_by_;
  Nanoseconds now_ = 0;
};

}  // namespace polyarm::cell
