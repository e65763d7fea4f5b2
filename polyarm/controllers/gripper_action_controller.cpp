#include "polyarm/controllers/gripper_action_controller.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::controllers {

CallbackReturn GripperActionController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::string joint, speed, effort;
  double monitor = 20;
  p.read("joint", joint, {"the joint of the gripper"});
  p.read("goal_tolerance", tolerance_,
         {.text = "how near the goal is reached, rad or m", .changeable = true, .least = 0});
  p.read("allow_stalling", allow_stalling_,
         {.text = "a gripper that stalls has reached its goal", .changeable = true});
  p.read("stall_velocity_threshold", stall_velocity_,
         {.text = "slower than this it stalls, rad/s or m/s", .changeable = true, .least = 0});
  p.read("stall_timeout", stall_timeout_,
         {.text = "s for which it is slow before it has stalled", .changeable = true, .least = 0});
  p.read("max_effort", max_effort_, {.text = "N m or N, where a goal says none", .least = 0});
  p.read("max_velocity", max_velocity_, {.text = "rad/s or m/s, where a goal says none", .least = 0});
  p.read("max_effort_interface", effort, {"command interface that is told the effort"});
  p.read("max_velocity_interface", speed, {"command interface that is told the velocity"});
  p.read("action_monitor_rate", monitor, {"Hz at which the goal is looked at; here every cycle"});
  if (joint.empty()) return CallbackReturn::failure;
  const std::string whole = context.whole_joint(joint, "joint");
  const JointFacts& facts = *context.find_joint(whole);
  lower_ = facts.lower;
  upper_ = facts.upper;
  position_ = claim_state(whole + "/position");
  velocity_ =
      context.has_state(whole + "/velocity") ? static_cast<int>(claim_state(whole + "/velocity")) : -1;
  command_ = claim_command(whole + "/position");
  speed_command_ = speed.empty() ? -1 : static_cast<int>(claim_command(context.whole_name(speed)));
  effort_command_ = effort.empty() ? -1 : static_cast<int>(claim_command(context.whole_name(effort)));
  output_ = &add_output("gripper_state", "control_msgs/GripperCommand",
                        {"position", "velocity", "reference", "active"});
  period_s_ = seconds(context.period);
  return CallbackReturn::success;
}

CallbackReturn GripperActionController::on_activate(const Cycle&) noexcept {
  for (Command old; inbox_.pop(old);) {
  }
  goal_ = 0;
  wanted_ = std::isfinite(command(command_)) ? command(command_) : state(position_);
  if (!std::isfinite(wanted_)) return CallbackReturn::error;
  last_position_ = state(position_);
  set_command(command_, wanted_);
  return CallbackReturn::success;
}

void GripperActionController::end(GoalOutcome outcome, int code) noexcept {
  if (goal_ == 0) return;
  events_.push(GoalEvent{goal_, outcome, code, 0, wanted_ - last_position_, tolerance_});
  goal_ = 0;
}

ReturnType GripperActionController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  const double at = state(position_);
  const double speed =
      velocity_ >= 0 ? state(static_cast<std::size_t>(velocity_)) : (at - last_position_) / period_s_;
  last_position_ = at;
  for (std::uint64_t id = 0; cancels_.pop(id);)
    if (id == goal_) {
      end(GoalOutcome::canceled, 0);
      wanted_ = at;
    }
  if (Command arrived; inbox_.pop(arrived)) {
    end(GoalOutcome::aborted, -1);
    goal_ = arrived.id;
    wanted_ = std::clamp(arrived.position, lower_, upper_);
    speed_ = arrived.velocity;
    effort_ = arrived.effort;
    slow_for_ = 0;
    events_.push(GoalEvent{goal_, GoalOutcome::accepted});
  }
  if (verdict.speed <= 0 &&
      goal_ != 0) {  // a stop: what moves stays where it is, what grips goes on gripping
    end(GoalOutcome::aborted, -1);
    if (std::abs(speed) > stall_velocity_) wanted_ = at;
  }
  if (goal_ != 0) {
    slow_for_ = std::abs(speed) > stall_velocity_ ? 0 : slow_for_ + period_s_;
    if (std::abs(wanted_ - at) <= tolerance_)
      end(GoalOutcome::succeeded, 0);
    else if (slow_for_ > stall_timeout_)
      end(allow_stalling_ ? GoalOutcome::succeeded : GoalOutcome::aborted, allow_stalling_ ? 0 : -5);
  }
  set_command(command_, wanted_);
  if (speed_command_ >= 0) set_command(static_cast<std::size_t>(speed_command_), speed_);
  if (effort_command_ >= 0) set_command(static_cast<std::size_t>(effort_command_), effort_);
  double* out = output_->draft().values.data();
  for (const double value : {at, speed, wanted_, goal_ != 0 ? 1.0 : 0.0}) *out++ = value;
  output_->publish(cycle.time);
  return ReturnType::ok;
}

std::vector<InputPort> GripperActionController::inputs() const {
  return {{"gripper_cmd", {"control_msgs/ParallelGripperCommand", "control_msgs/GripperCommand"}, true}};
}

std::uint64_t GripperActionController::receive(const std::string&, const Input& message, bool) {
  const auto* asked = std::get_if<GripperCommand>(&message);
  if (!asked || !std::isfinite(asked->position))
    throw Error("wrong-message", "this controller takes a position (control_msgs/ParallelGripperCommand)");
  const Command made{next_id_, asked->position, asked->max_velocity.value_or(max_velocity_),
                     asked->max_effort.value_or(max_effort_)};
  if (!inbox_.push(made)) throw Error("busy", "the controller has not taken the last goals yet");
  return next_id_++;
}

std::optional<GoalEvent> GripperActionController::next_goal_event() {
  GoalEvent event;
  return events_.pop(event) ? std::optional(event) : std::nullopt;
}

}  // namespace polyarm::controllers
