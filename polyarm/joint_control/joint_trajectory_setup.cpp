/// The joint trajectory controller outside the loop: its parameters, its interfaces and its messages.
#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/controllers/pid_parameters.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"

namespace polyarm::controllers {

namespace {

/// From nothing to full acceleration, s, where no jerk is stated.
constexpr double kTimeToAcceleration = 0.1;
/// A speed scaling above this is a mistake.
constexpr double kMostScaling = 10;
/// A change of speed stays this far within a limit that commands are held to, and may go this far beyond one
/// that nobody enforces: the rest is what a plan that brakes at its limit leaves to stop with.
constexpr double kWithin = 0.99, kBeyond = 1.02;

trajectory::JointDynamics dynamics_of(const JointFacts* facts) {
  trajectory::JointDynamics out{kUnlimited, kUnlimited, kUnlimited};
  if (!facts || !std::isfinite(facts->acceleration)) return out;
  const double share = facts->states_acceleration ? kWithin : kBeyond;
  out.acceleration = share * facts->acceleration;
  out.deceleration = share * std::min(facts->acceleration, facts->deceleration);
  out.jerk = std::isfinite(facts->jerk) ? facts->jerk : facts->acceleration / kTimeToAcceleration;
  return out;
}

/// From full speed to rest it takes velocity / deceleration, and at most 2.6 times that where the plan brakes
/// some joint at its limit all the while.
double longest_stop_of(const ControllerContext& context, const std::vector<std::string>& joints) {
  constexpr double kShortest = 0.5, kLongest = 5, kTimeout = 2.6;  // s, s
  double out = kShortest;
  for (const std::string& joint : joints) {
    const JointFacts* facts = context.find_joint(joint);
    const double most = dynamics_of(facts).deceleration;
    if (facts && std::isfinite(facts->velocity) && std::isfinite(most))
      out = std::max(out, kTimeout * facts->velocity / most + 2 * kTimeToAcceleration);
  }
  return std::min(out, kLongest);
}

bool contains(const std::vector<std::string>& list, const char* word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

Location where(const ControllerContext& context, const char* key) {
  const auto found = context.parameters.entries.find(key);
  return found == context.parameters.entries.end() ? Location{} : found->second.where;
}

}  // namespace

int JointTrajectoryController::place(bool is_command, std::size_t joint, const char* quantity) {
  const std::string name = joints_[joint] + "/" + quantity;
  return static_cast<int>(is_command ? claim_command(name) : claim_state(name));
}

void JointTrajectoryController::read_interfaces(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> commands{"position"}, states{"position", "velocity"}, command_joints;
  p.read("command_interfaces", commands,
         {.text = "interfaces to command: position; position, velocity; position, velocity, acceleration; "
                  "velocity; effort; "
                  "position, effort",
          .choices = {"position", "velocity", "acceleration", "effort"}});
  p.read("state_interfaces", states,
         {.text = "interfaces to read", .choices = {"position", "velocity", "acceleration"}});
  p.read("command_joints", command_joints,
         {"names to command in place of the joints, such as the references of another controller"});
  const bool cp = contains(commands, "position"), cv = contains(commands, "velocity"),
             ca = contains(commands, "acceleration"), ce = contains(commands, "effort");
  const auto refuse = [&](const std::string& what, const char* advice) {
    p.problems().error("unsupported-interface", where(context, "command_interfaces"),
                       "the controller '" + context.name + "' cannot command " + join(commands, ", ") + what,
                       advice);
  };
  if (commands.empty()) refuse("nothing", "set command_interfaces: [position]");
  if ((ca && !(cp && cv)) || (ce && (cv || ca)))
    refuse(" together",
           "possible are position; position, velocity; position, velocity, acceleration; velocity; "
           "effort; position, effort");
  closed_loop_ = (cv && !cp) || ce;
  const bool sp = contains(states, "position"), sv = contains(states, "velocity");
  if (!sp) refuse(" without reading position", "set state_interfaces: [position, velocity]");
  if (closed_loop_ && !sv) refuse(" without reading velocity", "set state_interfaces: [position, velocity]");
  const std::vector<std::string> own = joints_;
  if (!command_joints.empty() && command_joints.size() != joints_.size())
    return p.problems().error("wrong-size", where(context, "command_joints"),
                              "command_joints has " + std::to_string(command_joints.size()) + " names for " +
                                  std::to_string(joints_.size()) + " joints");
  for (auto* in : {&commands_, &states_})
    for (auto* list : {&in->position, &in->velocity, &in->acceleration, &in->effort})
      list->assign(joints_.size(), -1);
  const auto commanded = [&](std::size_t j, const char* quantity) {
    if (command_joints.empty()) return place(true, j, quantity);
    return static_cast<int>(claim_command(context.whole_name(command_joints[j] + "/" + quantity)));
  };
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (cp) commands_.position[j] = commanded(j, "position");
    if (cv) commands_.velocity[j] = commanded(j, "velocity");
    if (ca) commands_.acceleration[j] = commanded(j, "acceleration");
    if (ce) commands_.effort[j] = commanded(j, "effort");
    if (sp) states_.position[j] = place(false, j, "position");
    // Velocity is read where hardware has it; without a closed loop it is only told and used for braking.
    if (sv && (closed_loop_ || context.has_state(joints_[j] + "/velocity")))
      states_.velocity[j] = place(false, j, "velocity");
  }
  rules_.effort = ce;
}

void JointTrajectoryController::read_gains(ControllerContext& context) {
  Parameters& p = context.parameters;
  gains_.assign(joints_.size(), {});
  feed_forward_.assign(joints_.size(), 0.0);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const std::string prefix = "gains." + reported_joints_[j];
    if (closed_loop_) {
      read_pid_gains(p, prefix, gains_[j]);
      p.read(prefix + ".ff_velocity_scale", feed_forward_[j],
             {.text = "share of the desired velocity that is commanded beside the feedback",
              .changeable = true});
      p.read("velocity_ff." + reported_joints_[j], feed_forward_[j], {"ros_control's name of ff_velocity_scale"});
    }
    p.superseded(prefix + ".angle_wraparound", "joints without limits turn the shorter way by themselves");
    p.superseded(prefix + ".normalize_error", "joints without limits turn the shorter way by themselves");
  }
  if (!closed_loop_)
    for (const auto& [key, entry] : p.entries)
      if (key.starts_with("gains.")) {
        p.problems().warning("no-effect", entry.where, "gains have no effect if positions are commanded",
                             "they work with command_interfaces: [velocity] or [effort]");
        break;
      }
  if (!closed_loop_)
    std::erase_if(p.entries, [](const auto& pair) { return pair.first.starts_with("gains."); });
  pids_.clear();
  for (const PidGains& gains : gains_) pids_.emplace_back(gains);
}

void JointTrajectoryController::read_tolerances(ControllerContext& context) {
  Parameters& p = context.parameters;
  Tolerances& t = default_tolerances_;
  t.path.assign(joints_.size(), {});
  t.goal.assign(joints_.size(), {});
  double stopped = 0.01;
  p.read("constraints.stopped_velocity_tolerance", stopped,
         {.text = "velocity below which a joint counts as stopped at the end, rad/s or m/s", .least = 0});
  p.read(
      "constraints.goal_time", t.goal_time,
      {.text = "s after the end in which the goal must be met; 0: no limit", .changeable = true, .least = 0});
  p.read("reject_goals_when_held", reject_when_held_,
         {.text = "a goal that comes while the cell is held is refused; else it waits, with a warning",
          .changeable = true});
  p.read("constraints.decelerate_on_cancel", brake_on_cancel_,
         {"slow down instead of holding at once when a goal is cancelled"});
  most_braking_.assign(joints_.size(), 0.0);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const std::string prefix = "constraints." + reported_joints_[j];
    p.read(prefix + ".trajectory", t.path[j].position,
           {.text = "how far the joint may be off on the way, rad or m; 0: not checked",
            .changeable = true,
            .least = 0});
    p.read(prefix + ".goal", t.goal[j].position,
           {.text = "how far it may be off at the end, rad or m; 0: not checked",
            .changeable = true,
            .least = 0});
    t.goal[j].velocity = stopped;
    p.read(prefix + ".max_deceleration_on_cancel", most_braking_[j],
           {.text = "how hard it slows down on a cancel, rad/s² or m/s²", .changeable = true, .least = 0});
    if (brake_on_cancel_ && most_braking_[j] > 0 && states_.velocity[j] < 0)
      p.problems().warning("no-effect", where(context, "constraints.decelerate_on_cancel"),
                           "'" + reported_joints_[j] + "' cannot slow down on a cancel: its velocity is not read",
                           "add velocity to state_interfaces");
  }
  note_checks();
  judged_.tolerances = t;
}

void JointTrajectoryController::read_behaviour(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::string method = "splines", state_interface, command_interface;
  bool upsample = false, open_loop = false;
  double frequency = 0, monitor = 20;
  p.read("interpolation_method", method,
         {.text = "splines, or none: from point to point in steps", .choices = {"splines", "none"}});
  p.read("allow_partial_joints_goal", rules_.partial,
         {"trajectories may omit joints; these hold, or continue"});
  p.read("allow_trajectory_replacement", replacement_,
         {"a new trajectory replaces the active one smoothly; joints that it omits continue the active one"});
  p.read("open_loop_control", open_loop, {"the older name of interpolate_from_desired_state"});
  from_desired_ = open_loop;
  p.read("interpolate_from_desired_state", from_desired_,
         {"begin at the last command instead of the measured position"});
  p.read("allow_integration_in_goal_trajectories", rules_.integrate,
         {"points may have velocities or accelerations alone"});
  p.read("set_last_command_interface_value_as_state_on_activation", keep_command_,
         {"begin at the last command, so that nothing sags"});
  p.read("positions_upsampling.enable", upsample,
         {"positions that come in even steps become a smooth curve"});
  p.read("positions_upsampling.policy_frequency", frequency,
         {.text = "steps per second of these positions, Hz", .least = 0});
  p.read("allow_nonzero_velocity_at_trajectory_end", rules_.nonzero_end,
         {"the last point may have a velocity"});
  p.read("cmd_timeout", cmd_timeout_,
         {.text = "s after the last point in which the next trajectory must come; 0: for ever",
          .changeable = true,
          .least = 0});
  p.read("action_monitor_rate", monitor,
         {.text = "rate of feedback, Hz; the goal is checked every cycle", .least = 0});
  p.read("speed_scaling.initial_scaling_factor", initial_scaling_,
         {.text = "speed at the start, 1: as planned", .least = 0, .most = kMostScaling});
  p.read("speed_scaling.state_interface", state_interface, {"state interface with the speed factor"});
  p.read("speed_scaling.command_interface", command_interface, {"command interface for the speed factor"});
  if (!state_interface.empty())
    scaling_state_ = static_cast<int>(claim_state(context.whole_name(state_interface)));
  if (!command_interface.empty())
    scaling_command_ = static_cast<int>(claim_command(context.whole_name(command_interface)));
  rules_.step = method == "none";
  rules_.upsampling = upsample ? frequency : 0;
  if (upsample && frequency <= 0)
    p.problems().error("bad-value", where(context, "positions_upsampling.enable"),
                       "positions_upsampling needs policy_frequency above 0");
  if (cmd_timeout_ > 0 && cmd_timeout_ <= default_tolerances_.goal_time) {
    p.problems().warning("no-effect", where(context, "cmd_timeout"),
                         "cmd_timeout is not longer than constraints.goal_time and has no effect",
                         "make it longer than that");
    cmd_timeout_ = 0;
  }
  p.superseded("state_publish_rate",
               "controller_state comes every cycle; `polyarm watch --rate` thins it out");
  p.superseded("start_with_holding", "it always holds until a trajectory comes");
  p.superseded("stop_trajectory_duration", "a stop slows down within the limits");
  p.superseded("hold_trajectory_duration", "a stop slows down within the limits");
}

void JointTrajectoryController::make_output() {
  std::vector<std::string> fields;
  for (const std::string& joint : reported_joints_)
    for (const char* field :
         {"reference.position", "reference.velocity", "reference.acceleration", "feedback.position",
          "feedback.velocity", "error.position", "error.velocity", "output"})
      fields.push_back(joint + "." + field);
  fields.emplace_back("time_from_start");
  state_output_ =
      &add_output("controller_state", "control_msgs/JointTrajectoryControllerState", std::move(fields));
}

void JointTrajectoryController::make_rows() {
  const std::size_t n = joints_.size();
  const auto rows = {&position_,        &plan_velocity_,     &plan_acceleration_,
                     &velocity_,        &acceleration_,      &effort_,
                     &sample_position_, &sample_velocity_,   &sample_acceleration_,
                     &sample_effort_,   &measured_position_, &measured_velocity_,
                     &error_,           &error_velocity_,    &output_,
                     &path_position_,   &path_velocity_,     &path_acceleration_};
  rows_.assign(rows.size() * n, 0.0);
  std::size_t at = 0;
  for (std::span<double>* row : rows) *row = std::span(rows_).subspan(n * at++, n);
  const auto places = [n](const std::vector<int>& claimed, std::vector<std::uint32_t>& out) {
    out.assign(claimed.front() >= 0 ? n : 0, 0);
  };
  places(commands_.position, position_places_);
  places(commands_.velocity, velocity_places_);
  places(commands_.acceleration, acceleration_places_);
  places(commands_.effort, effort_places_);
  for (auto* values : {&sampled_.position, &sampled_.velocity, &sampled_.acceleration})
    values->assign(n, 0.0);
}

CallbackReturn JointTrajectoryController::on_configure(ControllerContext& context) {
  joints_.clear();
  reported_joints_.clear();
  std::vector<std::string> joints;
  context.parameters.read("joints", joints, {"the joints, in the order of commands"});
  for (const std::string& joint : joints) {
    joints_.push_back(context.whole_joint(joint));
    reported_joints_.push_back(joint);
  }
  if (joints_.empty()) {
    refuse_no_joints(context.parameters);
    return CallbackReturn::failure;
  }
  rules_ = {};
  rules_.joints = reported_joints_;
  rules_.whole = joints_;
  continuous_.clear();
  for (const std::string& joint : joints_) continuous_.push_back(context.find_joint(joint)->continuous);
  rules_.continuous = continuous_;
  asked_.reset(joints_.size());
  for (std::size_t j = 0; j < joints_.size(); ++j)
    asked_.set(j, reported_joints_[j], context.find_joint(joints_[j]));
  rules_.limits = &asked_;
  scaling_state_ = scaling_command_ = -1;
  read_interfaces(context);
  read_gains(context);
  read_tolerances(context);
  read_behaviour(context);
  make_output();
  const std::size_t n = joints_.size();
  make_rows();
  leader_.assign(n, -1);
  braking_.assign(n, {});
  tracks_.assign(n + 1, {});
  tracks_used_ = 0;
  waiting_.assign(8, nullptr);
  period_s_ = seconds(context.period);
  dynamics_.clear();
  for (const std::string& joint : joints_) dynamics_.push_back(dynamics_of(context.find_joint(joint)));
  longest_stop_ = longest_stop_of(context, joints_);
  scale_ = trajectory::TimeScale();
  return CallbackReturn::success;
}

void JointTrajectoryController::note_checks() noexcept {
  checks_ = false;
  for (const Tolerances::Of& of : default_tolerances_.path)
    checks_ = checks_ || of.position > 0 || of.velocity > 0;
}

void JointTrajectoryController::on_parameters_changed() noexcept {
  note_checks();
  for (std::size_t j = 0; j < pids_.size(); ++j) pids_[j].set_gains(gains_[j]);
}

std::string JointTrajectoryController::refuse_changes(const std::vector<ParameterChange>& changes) const {
  return refuse_pid_changes(changes, gains_);
}

std::vector<InputPort> JointTrajectoryController::inputs() const {
  return {{"joint_trajectory", {"trajectory_msgs/JointTrajectory"}},
          {"command", {"trajectory_msgs/JointTrajectory"}},
          {"follow_joint_trajectory", {"control_msgs/FollowJointTrajectory"}, true},
          {"speed_scaling_input", {"control_msgs/SpeedScalingFactor", "std_msgs/Float64"}}};
}

std::uint64_t JointTrajectoryController::receive(const std::string& port, const Input& message, bool goal) {
  if (port == "speed_scaling_input") {
    const auto* numbers = std::get_if<Numbers>(&message);
    if (!numbers || numbers->values.size() != 1) throw Error("bad-value", "speed scaling takes one number");
    if (const double factor = numbers->values[0]; !(factor >= 0 && factor <= kMostScaling))
      throw Error("bad-value", "a speed scaling of " + format_number(factor) + " is refused",
                  "it takes 0 to " + format_number(kMostScaling) + "; 1 is as planned");
    requested_factor_.store(numbers->values[0], std::memory_order_relaxed);
    return 0;
  }
  const auto* trajectory = std::get_if<TrajectoryMessage>(&message);
  if (!trajectory)
    throw Error("wrong-message", "this controller takes trajectories (trajectory_msgs/JointTrajectory)");
  if (forward_.load(std::memory_order_acquire))
    throw Error(
        "forward-mode",
        "this robot's own controller interpolates (`motion: forward`); it takes moves, no trajectories",
        "send moves: a program, or move requests; or set `motion: stream` at the robot");
  const bool action = goal || port == "follow_joint_trajectory";
  std::unique_ptr<TrajectoryGoal> made =
      make_goal(*trajectory, rules_, now_.load(std::memory_order_relaxed), action);
  made->id = next_id_++;
  const std::uint64_t id = made->id;
  if (!inbox_.give(made))
    throw Error("busy", "the controller has not taken the last trajectories yet", "is the loop running?");
  return id;
}

bool JointTrajectoryController::cancel(std::uint64_t goal) {
  return goal < next_id_ && cancels_.push(goal);
}

std::optional<GoalEvent> JointTrajectoryController::next_goal_event() {
  GoalEvent event;
  return events_.pop(event) ? std::optional(event) : std::nullopt;
}

}  // namespace polyarm::controllers
