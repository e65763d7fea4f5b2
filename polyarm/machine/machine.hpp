#pragma once
/// The control loop of a cell with its controllers and hardware, and what it did by itself.
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

/// A component on its way from the files. Read it when it is done.
struct Remaking {
  std::atomic<bool> done{false};
  std::string name;
  mutable Remade made;  ///< its parts are taken when the reload begins
  std::exception_ptr failed;
};

class Machine;

/// A switch of controllers between two cycles, which begins again if the loop has changed controllers by
/// itself meanwhile. Cell thread.
class ControllerSwitch {
 public:
  /// Begins it. Throws Error with why it is refused.
  ControllerSwitch(Machine& machine, control::SwitchRequest request);
  /// Goes on with it; true when it is done. Throws Error where an activation failed.
  bool advance();
  const control::SwitchPlan& plan() const;

 private:
  Machine& machine_;
  control::SwitchRequest request_;
  std::shared_ptr<control::ControllerManager::Switch> job_;
  int tries_ = 0;
};

/// Cell thread, but for the loop's step (control thread; the same one in lock-step).
class Machine {
 public:
  Machine(CellSetup& setup, Observer& observer);

  // Building, in this order; each throws Error.
  void make_loop(const ros_files::ControllersFile& described);
  void add_hardware(Problems& problems);
  void start_hardware();
  /// After the controllers are made: nothing is added to the loop any more.
  void prepare();
  /// False: a component is still in a call and uses its robots; they stay until the process ends.
  bool shut_hardware_down(Nanoseconds patience);

  control::ControlLoop& loop() { return *loop_; }
  const control::ControlLoop& loop() const { return *loop_; }
  control::ControllerManager& controllers() const { return loop_->controllers(); }
  hardware::Hardware& hardware() const { return loop_->hardware(); }
  control::Supervisor& supervisor() const { return loop_->supervisor(); }
  const control::Health& health() const { return loop_->health(); }
  hardware::InterfaceTable& table() const { return loop_->table(); }
  Nanoseconds period() const { return loop_->options().period; }
  /// The newest state of the loop that this tick has seen.
  const control::Snapshot& snapshot() const { return loop_->outbox().value(); }
  /// Takes the newest state. `now`: cell time of the tick.
  void begin_tick(Nanoseconds now);
  Nanoseconds now() const { return now_; }
  const Nanoseconds& clock() const { return now_; }
  /// Throws Error("busy").
  void post(control::Request request) const;
  /// Of the joints of all robots, once prepared.
  const JointPlaces& joint_places() const { return joint_places_; }

  /// Stops on the path; `why` is the cause until the loop runs again.
  void hold_for(Problem why);
  /// What the cell itself stopped the loop for; empty once it runs again.
  const std::optional<Problem>& held_by() const { return held_by_; }

  /// Reports what the loop did by itself, and lets components that failed decide what they become.
  void report_events();
  /// The controllers that stopped when the component failed, since the last call.
  std::vector<std::string> take_fallen(const std::string& component);
  /// What became of the latest goals of a controller, oldest first.
  const std::vector<controllers::GoalEvent>& goal_events(const std::string& controller);
  void forget_goals(const std::string& controller) { goal_events_.erase(controller); }
  /// Callbacks of hardware that may take their time.
  HardwareCalls& calls() { return calls_; }

  /// Makes and configures a controller while the cell runs: with the type and parameters given, or with those
  /// that the controllers' files have under its name. Returns the warnings. `file`: a controllers file that
  /// is read instead of the cell's own. Where configuring fails, nothing is loaded.
  Problems load_controller(const std::string& name, const std::string& type,
                           controllers::Parameters parameters, const std::string& file);

  /// Begins to read the descriptions again, on `worker`, and to make the component of that name from them.
  std::shared_ptr<const Remaking> remake(const std::string& name, Worker& worker) const;
  /// When that is done: puts what was made in the place of the unconfigured component. Kinematics and limits
  /// stay those that the cell started with. Throws Error with what is wrong with the files.
  std::shared_ptr<hardware::Transition> begin_reload(const Remaking& remade);

  /// The controllers that begin when the cell is armed, or at once where nothing is real.
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
  std::vector<char> reported_threads_;  // by component: what the machine refused its thread was reported
  std::unique_ptr<control::ControlLoop> loop_;
  std::map<std::string, std::vector<controllers::GoalEvent>> goal_events_;
  std::map<std::string, std::vector<std::string>> fallen_;  // component → controllers
  std::string falling_;                                     // component whose failure is being reported
  JointPlaces joint_places_;
  std::optional<Problem> held_by_;
  Nanoseconds now_ = 0;
};

}  // namespace polyarm::cell
