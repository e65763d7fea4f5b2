#include "polyarm/joint_control/gripper_action_controller.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::controllers {

namespace {
constexpr int kInvalidGoal = -1, kGoalNotReached = -5;
constexpr double kGripperMoves = 1e-3;  // rad/s or m/s: slower is standing
constexpr const char* kFields[] = {"position", "effort",    "stalled", "reached_goal",
                                   "velocity", "reference", "active"};
}  // namespace

// --- configuration ----------------------------------------------------------------------------------------

/// Returns the joint.
std::string GripperActionController::read_parameters(Parameters& p) {
  settings_ = {};
  std::string joint, command = "position";
  std::vector<std::string> states{"position", "velocity"};
  double monitor = 20;
  bool reject_when_held = false;  // read by who gives it goals
  speed_interface_.clear();
  effort_interface_.clear();
  p.read("joint", joint, {"the joint of the gripper"});
  p.read(
      "command_interface", command,
      {.text = "interface to command; it follows from the type's name", .choices = {"position", "effort"}});
  p.read("goal_tolerance", settings_.tolerance,
         {.text = "how near the goal is reached, rad or m", .changeable = true, .least = 0});
  p.read("allow_stalling", settings_.allow_stalling,
         {.text = "a gripper that stalls has reached its goal", .changeable = true});
  p.read("stall_velocity_threshold", settings_.stall_velocity,
         {.text = "slower than this it stalls, rad/s or m/s", .changeable = true, .least = 0});
  p.read("stall_timeout", settings_.stall_timeout,
         {.text = "s for which it is slow before it has stalled", .changeable = true, .least = 0});
  p.read("max_effort", settings_.max_effort,
         {.text = "N m or N, if a goal has none; 0: the limit of the joint", .least = 0});
  p.read("max_velocity", settings_.max_velocity, {.text = "rad/s or m/s, if a goal has none", .least = 0});
  p.read("max_effort_interface", effort_interface_, {"command interface for the effort"});
  p.read("max_velocity_interface", speed_interface_, {"command interface for the velocity"});
  p.read("state_interfaces", states, {"states to read; here position, and velocity if it exists"});
  p.read("reject_goals_when_held", reject_when_held,
         {"a goal that comes while the cell is held is refused with the reason"});
  p.read("action_monitor_rate", monitor, {"rate of feedback, Hz; the goal is checked every cycle"});
  by_effort_ = command == "effort";
  if (joint.empty())
    p.problems().error("missing-parameter", {}, "the gripper controller has no joint", "write joint: NAME");
  return joint;
}

void GripperActionController::claim(ControllerContext& context, const std::string& joint) {
  const std::string whole = context.whole_joint(joint, "joint");
  const JointFacts& facts = *context.find_joint(whole);
  const auto told = [&](const std::string& interface) {
    return interface.empty() ? -1 : static_cast<int>(claim_command(context.whole_name(interface)));
  };
  asked_.reset(1);
  asked_.set(0, joint, &facts);
  lower_ = facts.lower;
  upper_ = facts.upper;
  position_ = claim_state(whole + "/position");
  velocity_ =
      context.has_state(whole + "/velocity") ? static_cast<int>(claim_state(whole + "/velocity")) : -1;
  command_ = claim_command(whole + (by_effort_ ? "/effort" : "/position"));
  speed_command_ = told(speed_interface_);
  effort_command_ = told(effort_interface_);
}

CallbackReturn GripperActionController::on_configure(ControllerContext& context) {
  const std::string joint = read_parameters(context.parameters);
  if (joint.empty()) return CallbackReturn::failure;
  claim(context, joint);
  gains_.clear();
  if (by_effort_) {
    read_ros_control_gains(context.parameters, "gains." + joint, gains_.emplace_back());
    pid_ = Pid(gains_[0].gains());
  }
  output_ =
      &add_output("gripper_state", "control_msgs/GripperCommand", {std::begin(kFields), std::end(kFields)});
  period_s_ = seconds(context.period);
  return CallbackReturn::success;
}

void GripperActionController::on_parameters_changed() noexcept {
  if (by_effort_) pid_.set_gains(gains_[0].gains());
}

std::string GripperActionController::refuse_changes(const std::vector<ParameterChange>& changes) const {
  return refuse_pid_changes(changes, gains_);
}

// --- life cycle -------------------------------------------------------------------------------------------

CallbackReturn GripperActionController::on_activate(const Cycle&) noexcept {
  refuse_waiting();
  at_ = state(position_);
  const double last = command(command_);
  wanted_ = !by_effort_ && std::isfinite(last) ? last : at_;
  if (!std::isfinite(wanted_)) return CallbackReturn::error;
  effort_ = settings_.max_effort;
  speed_ = settings_.max_velocity;
  pid_.reset();
  set_command(command_, by_effort_ ? 0 : wanted_);
  stopped_ = false;
  standing_ = true;
  return CallbackReturn::success;
}

void GripperActionController::on_deactivate(const Cycle&) noexcept {
  end(GoalOutcome::canceled, 0);
  refuse_waiting();
  if (by_effort_) set_command(command_, 0);  // a position stays where it was commanded last
  standing_ = true;
}

/// Goals that nobody has begun with are answered too.
void GripperActionController::refuse_waiting() noexcept {
  stalled_ = reached_ = false;
  for (std::uint64_t id = 0; cancels_.pop(id);) {
  }
  for (Command waiting; inbox_.pop(waiting);) tell(waiting.id, GoalOutcome::aborted, kInvalidGoal);
}

void GripperActionController::tell(std::uint64_t goal, GoalOutcome outcome, int code) noexcept {
  GoalEvent event{goal, outcome, code};
  if (outcome != GoalOutcome::accepted) {
    event.joint = 0;
    event.error = wanted_ - at_;
    event.tolerance = settings_.tolerance;
    event.gripper = {at_, given_effort_, stalled_, reached_};
    ended_.store(goal, std::memory_order_relaxed);
  }
  events_.push(event);
}

void GripperActionController::end(GoalOutcome outcome, int code) noexcept {
  if (goal_ != 0) tell(std::exchange(goal_, 0), outcome, code);
}

// --- the cycle --------------------------------------------------------------------------------------------

void GripperActionController::measure() noexcept {
  const double before = std::exchange(at_, state(position_));
  asked_.note_position(0, at_);
  moves_ = velocity_ >= 0 ? state(static_cast<std::size_t>(velocity_)) : (at_ - before) / period_s_;
}

void GripperActionController::hold() noexcept {
  if (std::isfinite(at_)) wanted_ = at_;
  effort_ = settings_.max_effort;
  speed_ = settings_.max_velocity;
}

/// A goal and its cancel may come in the same cycle, so goals are taken first, and all of them.
void GripperActionController::take_goals(bool stop) noexcept {
  for (Command arrived; inbox_.pop(arrived);) {
    end(GoalOutcome::canceled, 0);
    stalled_ = reached_ = false;
    if (stop) {
      tell(arrived.id, GoalOutcome::aborted, kInvalidGoal);
      continue;
    }
    goal_ = arrived.id;
    wanted_ = std::clamp(arrived.position, lower_, upper_);
    speed_ = arrived.velocity;
    effort_ = arrived.effort;
    slow_for_ = 0;
    tell(goal_, GoalOutcome::accepted, 0);
  }
  for (std::uint64_t id = 0; cancels_.pop(id);)
    if (goal_ != 0 && id == goal_) {
      end(GoalOutcome::canceled, 0);
      hold();
    }
}

void GripperActionController::judge() noexcept {
  if (goal_ == 0) return;
  slow_for_ = std::abs(moves_) > settings_.stall_velocity ? 0 : slow_for_ + period_s_;
  if (std::abs(wanted_ - at_) <= settings_.tolerance) {
    reached_ = true;
    end(GoalOutcome::succeeded, 0);
  } else if (slow_for_ > settings_.stall_timeout) {
    stalled_ = true;
    if (settings_.allow_stalling)
      end(GoalOutcome::succeeded, 0);
    else
      end(GoalOutcome::aborted, kGoalNotReached);
  }
}

void GripperActionController::write_commands() noexcept {
  if (by_effort_) {
    const double most = effort_ > 0 ? effort_ : kUnlimited;
    const double pushed = std::clamp(pid_.compute(wanted_ - at_, -moves_, period_s_), -most, most);
    given_effort_ = std::isfinite(pushed) ? pushed : 0;  // what is not measured is not pushed
    set_command(command_, given_effort_);
  } else {
    given_effort_ = effort_;
    set_command(command_, wanted_);
  }
  if (speed_command_ >= 0) set_command(static_cast<std::size_t>(speed_command_), speed_);
  if (effort_command_ >= 0) set_command(static_cast<std::size_t>(effort_command_), effort_);
}

ReturnType GripperActionController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  const bool stop = verdict.speed <= 0;
  measure();
  take_goals(stop);
  if (stop && !std::exchange(stopped_, true)) {  // what moves stays where it is, what grips goes on gripping
    end(GoalOutcome::aborted, kInvalidGoal);
    if (std::abs(moves_) > settings_.stall_velocity) hold();
  }
  stopped_ = stop;
  judge();
  write_commands();
  standing_ = goal_ == 0 && !(std::abs(moves_) > std::max(kGripperMoves, settings_.stall_velocity));
  publish(cycle);
  return ReturnType::ok;
}

void GripperActionController::publish(const Cycle& cycle) noexcept {
  double* out = output_->draft().values.data();
  for (const double value : {at_, given_effort_, stalled_ ? 1.0 : 0.0, reached_ ? 1.0 : 0.0, moves_, wanted_,
                             goal_ != 0 ? 1.0 : 0.0})
    *out++ = value;
  output_->publish(cycle.time);
}

// --- messages ---------------------------------------------------------------------------------------------

std::vector<InputPort> GripperActionController::inputs() const {
  return {{"gripper_cmd",
           {"control_msgs/ParallelGripperCommand", "control_msgs/GripperCommand"},
           true,
           "gripper_state"}};
}

std::uint64_t GripperActionController::receive(const std::string&, const Input& message, bool) {
  const auto* asked = std::get_if<GripperCommand>(&message);
  if (!asked)
    throw Error("wrong-message", "this controller takes a position (control_msgs/ParallelGripperCommand)");
  Problems problems;
  asked_.check(problems, 0, Asked::position, asked->position);
  asked_.check(problems, 0, Asked::velocity, asked->max_velocity.value_or(0));
  asked_.check(problems, 0, Asked::effort, asked->max_effort.value_or(0));
  problems.throw_if_errors();
  Command made{next_id_, asked->position, asked->max_velocity.value_or(settings_.max_velocity),
               std::abs(asked->max_effort.value_or(settings_.max_effort))};
  if (by_effort_ && made.effort == 0) made.effort = settings_.max_effort;
  if (!inbox_.push(made)) throw Error("busy", "the controller has not taken the last goals yet");
  return next_id_++;
}

bool GripperActionController::cancel(std::uint64_t goal) {
  return goal < next_id_ && goal > ended_.load(std::memory_order_relaxed) && cancels_.push(goal);
}

std::optional<GoalEvent> GripperActionController::next_goal_event() {
  GoalEvent event;
  return events_.pop(event) ? std::optional(event) : std::nullopt;
}

}  // namespace polyarm::controllers
