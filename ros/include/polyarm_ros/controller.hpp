#pragma once
/// A controller of ros2_control as a controller of Polyarm. Interface names lose the robot's name: the controller
/// reads "joint1/position" where the cell has "arm/joint1/position".
///
/// Its topics and actions are the controller's inputs in Polyarm, where their messages are among those of
/// messages.hpp. What it throws is caught. In update the wrapper copies numbers and nothing else: it does not
/// allocate, lock or log, apart from the line that says what was thrown. How it stops: stopping.hpp.
#include <atomic>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "controller_interface/chainable_controller_interface.hpp"
#include "controller_interface/controller_interface.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/force/robot_user.hpp"
#include "polyarm_ros/description.hpp"
#include "polyarm_ros/exported.hpp"
#include "polyarm_ros/last_call.hpp"
#include "polyarm_ros/log.hpp"
#include "polyarm_ros/messages.hpp"
#include "polyarm_ros/robot_text.hpp"
#include "polyarm_ros/stopping.hpp"
#include "polyarm_ros/values.hpp"

namespace polyarm_ros {

namespace ci = ::controller_interface;

/// An object of the exported class; null if there is none, or if its base is no controller.
inline std::unique_ptr<ci::ControllerInterfaceBase> make_controller_object(const char* type) {
  const ExportedClass* exported = find_exported(type);
  std::unique_ptr<ci::ControllerInterfaceBase> out;
  if (exported && is_base(exported->base, "ControllerInterface"))
    out.reset(static_cast<ci::ControllerInterface*>(exported->make()));
  if (exported && is_base(exported->base, "ChainableControllerInterface"))
    out.reset(static_cast<ci::ChainableControllerInterface*>(exported->make()));
  return out;
}

class RosController : public pc::Controller, public pc::RobotUser {
 public:
  explicit RosController(const char* type) : type_(type) {
    if (!find_exported(type)) throw std::runtime_error(std::string("it exports no class ") + type);
  }
  ~RosController() override { end_object(); }

  pc::CallbackReturn on_configure(pc::ControllerContext& context) override;
  pc::CallbackReturn on_cleanup() override {
    if (object_) guarded("on_cleanup", [&] { return object_->on_cleanup(state(2, "inactive")); });
    end_object();
    return pc::CallbackReturn::success;
  }
  pc::CallbackReturn on_error() override {
    if (object_) guarded("on_error", [&] { return object_->on_error(state(3, "active")); });
    return pc::CallbackReturn::success;
  }

  pc::CallbackReturn on_activate(const pc::Cycle& cycle) noexcept override {
    const InCycle mark;
    virtual_time_ = epoch() + cycle.time;
    resting_ = discarded_ = false;
    stopping_.begin(1);
    set_times(cycle);
    return activate();
  }
  void on_deactivate(const pc::Cycle& cycle) noexcept override {
    const InCycle mark;
    set_times(cycle);
    deactivate();
    for (std::size_t i = 0; i < commands_.size(); ++i) write_command(i);
  }
  pc::ReturnType update(const pc::Cycle& cycle, const pc::Verdict& asked) noexcept override;
  void set_chained(bool chained) noexcept override {
    Controller::set_chained(chained);
    if (object_) guarded("set_chained_mode", [&] {
      object_->set_chained_mode(chained);
      return ci::CallbackReturn::SUCCESS;
    });
  }
  bool standing() const noexcept override { return stopping_.at_rest(); }

  std::vector<pc::InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const pc::Input& message, bool goal) override;
  bool cancel(std::uint64_t goal) override {
    if (!node_) return false;
    const ServesGraph serving;
    const WatchedCall mark(name_.c_str(), "callback for", "cancel");
    for (const auto& action : wires().actions())
      if (action->cancel(goal)) return true;
    return false;
  }
  std::optional<pc::GoalEvent> next_goal_event() override {
    if (node_) run_node();
    const std::lock_guard lock(events_mutex_);
    if (events_.empty()) return std::nullopt;
    const pc::GoalEvent out = events_.front();
    events_.pop_front();
    return out;
  }
  std::string refuse_changes(const std::vector<pc::ParameterChange>& changes) const override {
    if (!node_) return "it is not configured";
    std::vector<rclcpp::Parameter> all;  // all or none
    for (const pc::ParameterChange& change : changes) all.push_back(values_.parameter(change));
    const ServesGraph serving;
    const WatchedCall mark(name_.c_str(), "callback for", "parameters");
    const auto result = node_->set_parameters_atomically(all);
    if (result.successful) return {};
    return result.reason.empty() ? "it does not say why" : result.reason;
  }

 private:
  /// In each tick of the cell no callback begins after this time, ns; the next tick goes on.
  static constexpr std::int64_t kCallbacks = 5'000'000;
  struct InCycle {
    InCycle() { in_cycle() = true; }
    ~InCycle() { in_cycle() = false; }
  };
  struct Command {
    std::shared_ptr<hardware_interface::CommandInterface> handle;
    double* place;
    Kind kind;
    double seen;  ///< the value that was there before the controller ran
  };
  struct State {
    std::shared_ptr<hardware_interface::StateInterface> handle;
    double* place;
  };

  static std::int64_t epoch() {
    static const std::int64_t value = system_time();
    return value;
  }
  const rclcpp_lifecycle::State& state(std::uint8_t id, const char* label) {
    node_->polyarm_set_state(id, label);
    return node_->get_current_state();
  }
  Wires& wires() const { return node_->polyarm_wires(); }
  void end_object() {
    if (object_) object_->release_interfaces();
    node_.reset();
    if (auto* const object = object_.release()) end_of_plugin(name_.c_str(), [object] { delete object; });
    commands_.clear(), states_.clear(), references_.clear(), exported_.clear();
  }
  void set_times(const pc::Cycle& cycle) noexcept {
    time_source_->store(virtual_time_, std::memory_order_relaxed);
    timer_source_->store(epoch() + cycle.time, std::memory_order_relaxed);
  }

  /// The call's result; what it throws is an error, logged with its text.
  template <typename Call>
  bool guarded(const char* where, Call&& call) noexcept {
    const ServesGraph serving;
    try {
      return call() == ci::CallbackReturn::SUCCESS;
    } catch (const std::exception& e) {
      log_format(Severity::error, name_.c_str(), "%s: %s", where, e.what());
    } catch (...) {
      log_format(Severity::error, name_.c_str(), "%s: it threw something that is no std::exception", where);
    }
    return false;
  }
  template <typename Call>
  void expect(const char* where, Call&& call) {
    if (!guarded(where, call))
      throw polyarm::Error("controller-refused",
                           "the controller '" + name_ + "' does not accept its configuration: its " + where +
                               " failed",
                           "its log above says why");
  }

  /// Timers, and what has come from the ROS 2 graph.
  void run_node() {
    guarded("a callback of its node", [&] {
      node_->get_node_base_interface()->run_due_within(kCallbacks);
      return ci::CallbackReturn::SUCCESS;
    });
  }
  std::uint64_t hand_over(const std::string& port, const pc::Input& message);
  /// Stamps are in the controller's own time, which slowed time has put behind the cell's: a stamp of now is now.
  Naming naming() const {
    Naming out = naming_;
    out.epoch += time_source_->load(std::memory_order_relaxed) - timer_source_->load(std::memory_order_relaxed);
    return out;
  }
  void make_object(pc::ControllerContext& context);
  void claim(pc::ControllerContext& context);
  void claim_commands(const pc::ControllerContext& context);
  std::vector<std::string> names_of(const ci::InterfaceConfiguration& wanted,
                                    const pc::SharedList<std::string>& all, const std::string& robot) const;
  static std::pair<std::string, std::string> split(const std::string& name) {
    const auto slash = name.rfind('/');
    return slash == std::string::npos ? std::pair{std::string(), name}
                                      : std::pair{name.substr(0, slash), name.substr(slash + 1)};
  }

  // Control thread.
  pc::CallbackReturn activate() noexcept;
  void deactivate() noexcept {
    guarded("on_deactivate", [&] { return object_->on_deactivate(state(3, "active")); });
    object_->release_interfaces();
    state(2, "inactive");
  }
  void take_in() noexcept {
    for (std::size_t i = 0; i < states_.size(); ++i) *states_[i].place = Controller::state(i);
    if (chained())
      for (std::size_t i = 0; i < references_.size(); ++i) *references_[i].place = reference(i);
    for (Command& c : commands_) c.seen = *c.place;
  }
  /// Hands a command on that the controller has written, or that stays. A velocity is slowed down as time is.
  double write_command(std::size_t i) noexcept {
    const Command& c = commands_[i];
    double value = *c.place;
    if (c.kind == Kind::velocity && !stopping_.pushes()) value *= stopping_.share();
    if (c.kind == Kind::acceleration && !stopping_.pushes()) value *= stopping_.share() * stopping_.share();
    if (value == value || c.seen == c.seen) set_command(i, value);
    return value;
  }
  void give_out(double dt) noexcept {
    for (std::size_t i = 0; i < commands_.size(); ++i) stopping_.note(i, write_command(i), dt);
    for (std::size_t i = 0; i < exported_.size(); ++i) set_exported(i, *exported_[i].place);
    if (!chained())
      for (std::size_t i = 0; i < references_.size(); ++i) set_reference(i, *references_[i].place);
  }
  pc::ReturnType run(std::int64_t period) noexcept {
    ci::return_type result = ci::return_type::OK;
    const bool done = guarded("update", [&] {
      result = object_->update(rclcpp::Time(virtual_time_, RCL_ROS_TIME),
                               rclcpp::Duration::from_nanoseconds(period));
      return ci::CallbackReturn::SUCCESS;
    });
    return done && result == ci::return_type::OK ? pc::ReturnType::ok : pc::ReturnType::error;
  }
  void brake(double dt) noexcept {
    for (std::size_t i = 0; i < commands_.size(); ++i) {
      if (commands_[i].kind == Kind::other || commands_[i].kind == Kind::effort) continue;
      const double value = stopping_.braked(i, dt);
      if (value == value) *commands_[i].place = value, set_command(i, value);
    }
  }
  /// A trajectory controller that commands efforts counts the true periods, which it needs to hold the joints: it
  /// does not see slower time and would drive on through a stop. It is started again once in each stop, and after
  /// each message that comes while the stop lasts, and holds where it stands.
  bool ends_trajectory(double wanted) noexcept {
    if (!follows_ || !stopping_.pushes()) return false;
    if (wanted > 0) moves_.store(true, std::memory_order_relaxed);
    return wanted <= 0 && moves_.exchange(false, std::memory_order_relaxed);
  }
  /// After a stop that its motion does not survive: it starts again from where it stands.
  pc::ReturnType restart() noexcept {
    deactivate();
    virtual_time_ = timer_source_->load(std::memory_order_relaxed);  // the time that it lost is no longer of use
    time_source_->store(virtual_time_, std::memory_order_relaxed);
    resting_ = false;
    stopping_.begin(0);
    return activate() == pc::CallbackReturn::success ? pc::ReturnType::ok : pc::ReturnType::error;
  }

  const char* type_;
  std::string name_;
  std::unique_ptr<ci::ControllerInterfaceBase> object_;
  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_;
  Naming naming_;
  Values values_;
  std::vector<Command> commands_;
  std::vector<State> states_, references_, exported_;  // their handles are kept alive here
  std::vector<std::shared_ptr<hardware_interface::CommandInterface>> reference_handles_;
  Stopping stopping_;
  bool resting_ = false, discarded_ = false;
  bool follows_ = false;            ///< has an action FollowJointTrajectory
  std::atomic<bool> moves_{false};  ///< may follow a trajectory
  std::int64_t virtual_time_ = 0;  ///< ROS time, ns; slower than the cell's while a stop lasts
  TimeSource time_source_, timer_source_;
  std::uint64_t goals_ = 0;
  std::mutex events_mutex_;
  std::deque<pc::GoalEvent> events_;
};

inline void RosController::make_object(pc::ControllerContext& context) {
  end_object();
  object_ = make_controller_object(type_);
  if (!object_)
    throw polyarm::Error("controller-refused",
                         std::string("no class ") + type_ + " with a controller interface as its base is exported",
                         "build it again with `polyarm plugin build`");
  name_ = context.name;
  naming_ = {epoch(), context.robot};
  ci::ControllerInterfaceParams params;
  params.controller_name = context.name;
  const auto model = models().find(context.robot);
  if (model != models().end()) {
    std::string blocks;
    for (const own::HardwareInfo& block : model->second->hardware) blocks += block_text(block);
    params.robot_description = robot_text(*model->second, blocks);
  }
  params.update_rate = static_cast<unsigned>(1e9 / static_cast<double>(context.period) + 0.5);
  params.controller_manager_update_rate =
      static_cast<unsigned>(1e9 / static_cast<double>(context.loop_period) + 0.5);
  std::vector<rclcpp::Parameter> given = overrides(context.parameters);
  // In ROS a launch file gives it to all nodes of the controller manager's process.
  if (!context.parameters.has("robot_description"))
    given.emplace_back("robot_description", params.robot_description);
  params.node_options.parameter_overrides(given);
  for (const pc::JointFacts& joint : context.joints)
    note_limits(naming_.local(joint.name), joint, params.hard_joint_limits, params.soft_joint_limits);
  const bool ready = guarded("on_init", [&] {
    const bool good = object_->init(params) == ci::return_type::OK;
    return good ? ci::CallbackReturn::SUCCESS : ci::CallbackReturn::ERROR;
  });
  if (!ready)
    throw polyarm::Error("controller-refused", "the controller '" + name_ + "' does not accept its parameters",
                         "its log above says why");
  node_ = object_->get_node();
  wires().open = true;
  time_source_ = node_->get_clock()->polyarm_source();
  timer_source_ = node_->get_node_base_interface()->timer_source;
  time_source_->store(epoch());
  timer_source_->store(epoch());
}

inline pc::CallbackReturn RosController::on_configure(pc::ControllerContext& context) {
  make_object(context);
  expect("on_configure", [&] { return object_->on_configure(state(1, "unconfigured")); });
  state(2, "inactive");
  values_.declare(*node_->get_node_base_interface(), context.parameters);
  claim(context);
  follows_ = false;
  for (const auto& action : wires().actions())
    follows_ = follows_ || *action->type == typeid(control_msgs::action::FollowJointTrajectory::Goal);
  for (const auto& listener : wires().listeners())  // the door has the controller's inputs already
    if (find_conversion(*listener->type)) listener->port.reset();
  return pc::CallbackReturn::success;
}

/// The names that a configuration means, as the controller knows them.
inline std::vector<std::string> RosController::names_of(const ci::InterfaceConfiguration& wanted,
                                                        const pc::SharedList<std::string>& all,
                                                        const std::string& robot) const {
  using Type = ci::interface_configuration_type;
  if (wanted.type == Type::NONE) return {};
  if (wanted.type == Type::INDIVIDUAL) return wanted.names;
  std::vector<std::string> out;
  const std::string prefix = robot + "/";
  for (const std::string& whole : all) {
    const bool mine = whole.compare(0, prefix.size(), prefix) == 0;
    if (!mine && wanted.type == Type::ALL) continue;
    const std::string name = mine ? whole.substr(prefix.size()) : whole;
    bool take = wanted.type == Type::ALL;
    for (const std::string& each : wanted.names)
      take = take || (wanted.type == Type::REGEX ? std::regex_match(name, std::regex(each)) : name == each);
    if (take) out.push_back(name);
  }
  return out;
}

inline void RosController::claim_commands(const pc::ControllerContext& context) {
  const auto names =
      names_of(object_->command_interface_configuration(), context.command_names, context.robot);
  stopping_ = {};
  stopping_.resize(names.size());
  for (const std::string& name : names) {
    const auto [prefix, interface] = split(name);
    auto handle = std::make_shared<hardware_interface::CommandInterface>(prefix, interface, "double");
    const std::string whole = context.whole_name(name);
    const pc::JointFacts* joint = context.find_joint(split(whole).first);
    const Kind kind = joint ? kind_of(interface) : Kind::other;
    if (claim_command(whole) != commands_.size())
      throw polyarm::Error("controller-refused",
                           "the controller '" + name_ + "' asks for the command '" + name + "' twice",
                           "name each joint and interface once");
    stopping_.set(commands_.size(), kind,
                  joint ? std::min(joint->acceleration, joint->deceleration) : pc::kUnlimited,
                  joint ? joint->velocity : pc::kUnlimited);
    double* const place = handle->polyarm_place();
    commands_.push_back({std::move(handle), place, kind, 0});
  }
}

inline void RosController::claim(pc::ControllerContext& context) {
  claim_commands(context);
  for (const std::string& name :
       names_of(object_->state_interface_configuration(), context.state_names, context.robot)) {
    const auto [prefix, interface] = split(name);
    auto handle = std::make_shared<hardware_interface::StateInterface>(prefix, interface, "double");
    if (claim_state(context.whole_name(name)) != states_.size()) continue;  // named twice
    double* const place = handle->polyarm_place();
    states_.push_back({std::move(handle), place});
  }
  if (!object_->is_chainable()) return;
  reference_handles_ = object_->export_reference_interfaces();
  for (const auto& handle : reference_handles_) {
    export_reference(handle->get_name());
    references_.push_back({nullptr, handle->polyarm_place()});
  }
  for (const auto& handle : object_->export_state_interfaces()) {
    export_state(handle->get_name());
    const auto kept = std::const_pointer_cast<hardware_interface::StateInterface>(handle);
    exported_.push_back({kept, kept->polyarm_place()});
  }
}

inline pc::CallbackReturn RosController::activate() noexcept {
  const bool done = guarded("on_activate", [&] {
    for (std::size_t i = 0; i < commands_.size(); ++i) *commands_[i].place = command(i);
    take_in();
    std::vector<hardware_interface::LoanedCommandInterface> commands;
    std::vector<hardware_interface::LoanedStateInterface> states;
    commands.reserve(commands_.size());
    states.reserve(states_.size());
    for (const Command& c : commands_) commands.emplace_back(*c.handle);
    for (const State& s : states_) states.emplace_back(*s.handle);
    object_->assign_interfaces(std::move(commands), std::move(states));
    const auto result = object_->on_activate(state(2, "inactive"));
    state(3, "active");
    return result;
  });
  if (!done) return pc::CallbackReturn::error;
  give_out(1);
  return pc::CallbackReturn::success;
}

/// A chained controller does what its references ask for: the controller in front of it is the one that stops.
inline pc::ReturnType RosController::update(const pc::Cycle& cycle, const pc::Verdict& asked) noexcept {
  const InCycle mark;
  const pc::Verdict verdict = chained() ? pc::Verdict{} : asked;
  const double dt = polyarm::seconds(cycle.period);
  const double wanted = verdict.cut ? 0 : std::min(verdict.speed, 1.0);
  pc::ReturnType result = pc::ReturnType::ok;
  const bool leave = verdict.cut || (stopping_.brakes() && wanted <= 0);
  if (leave || (resting_ && wanted <= 0)) {  // each joint by itself; what it was doing is over
    if (!stopping_.pushes()) {
      resting_ = true;
      brake(dt);
      set_times(cycle);
      return result;
    }
  }
  if (resting_ || (verdict.discard && !discarded_) || ends_trajectory(wanted)) result = restart();
  discarded_ = verdict.discard;
  const double share = stopping_.next_share(wanted, dt);
  const auto period = static_cast<std::int64_t>(static_cast<double>(cycle.period) * share + 0.5);
  virtual_time_ += period;
  set_times(cycle);
  if (result != pc::ReturnType::ok) return result;
  take_in();
  if (period > 0 || stopping_.pushes()) result = run(stopping_.pushes() ? cycle.period : period);
  give_out(dt);
  return result;
}

inline std::vector<pc::InputPort> RosController::inputs() const {
  std::vector<pc::InputPort> out;
  if (!node_) return out;
  for (const auto& action : wires().actions())
    if (const Conversion* known = find_conversion(*action->type))
      out.push_back({port_name(action->name), {known->name}, true});
  for (const auto& listener : wires().listeners())
    if (const Conversion* known = find_conversion(*listener->type)) {
      std::vector<std::string> types = {known->name};
      if (types[0] == "geometry_msgs/TwistStamped") types.push_back("geometry_msgs/Twist");
      out.push_back({port_name(listener->topic), types});
    }
  return out;
}

inline std::uint64_t RosController::receive(const std::string& port, const pc::Input& message, bool) {
  if (!node_) throw polyarm::Error("wrong-state", "the controller '" + name_ + "' is not configured");
  const ServesGraph serving;
  try {
    node_->get_node_base_interface()->run_due_within(kCallbacks);
    const WatchedCall mark(name_.c_str(), "callback for", port);
    const std::uint64_t goal = hand_over(port, message);
    moves_ = true;
    return goal;
  } catch (const polyarm::Error&) {
    throw;
  } catch (const std::exception& e) {  // of the controller's callback
    throw polyarm::Error("controller-refused", name_ + "/" + port + ": " + e.what(),
                         "its log above may say more");
  }
}

inline std::uint64_t RosController::hand_over(const std::string& port, const pc::Input& message) {
  for (const auto& action : wires().actions()) {
    const Conversion* known = find_conversion(*action->type);
    if (!known || port_name(action->name) != port) continue;
    const std::uint64_t number = ++goals_;
    bool accepted = false;
    const auto ended = [this, type = action->type](std::uint64_t goal, GoalEnd how, const void* result) {
      pc::GoalEvent event;
      event.goal = goal;
      event.outcome = how == GoalEnd::succeeded ? pc::GoalOutcome::succeeded
                      : how == GoalEnd::aborted ? pc::GoalOutcome::aborted
                                                : pc::GoalOutcome::canceled;
      read_result(*type, result, event);
      const std::lock_guard lock(events_mutex_);
      events_.push_back(event);
    };
    const bool fits = known->hand(message, naming(), [&](const void* goal) {
      accepted = action->goal(goal, number, ended);
    });
    if (!fits) throw polyarm::Error("wrong-message", name_ + "/" + port + " takes " + known->name);
    if (!accepted)
      throw polyarm::Error("goal-refused", "the controller '" + name_ + "' refuses the goal",
                           "its log above says why");
    pc::GoalEvent event;
    event.goal = number;
    const std::lock_guard lock(events_mutex_);
    events_.push_front(event);
    return number;
  }
  for (const auto& listener : wires().listeners()) {
    const Conversion* known = find_conversion(*listener->type);
    if (!known || port_name(listener->topic) != port) continue;
    if (!known->hand(message, naming(), listener->deliver))
      throw polyarm::Error("wrong-message", name_ + "/" + port + " takes " + known->name);
    return 0;
  }
  throw polyarm::Error("unknown-input", "this controller takes no messages called '" + port + "'");
}

}  // namespace polyarm_ros
