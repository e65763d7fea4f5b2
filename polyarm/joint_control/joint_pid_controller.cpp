#include "polyarm/joint_control/joint_pid_controller.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
constexpr const char* kFields[] = {
    "set_point", "process_value", "process_value_dot", "error", "time_step", "command", "p", "i",
    "d",         "i_clamp",       "antiwindup"};
constexpr double kJointMoves = 1e-3;  // rad/s or m/s: slower is standing

double shortest_turn(double angle) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return angle - kTurn * std::round(angle / kTurn);
}

/// Where a joint's gains stand: `pid` for the only one, else under its name.
std::string prefix_of(const Parameters& p, const std::string& joint, std::size_t count) {
  const auto any = [&](const std::string& prefix) {
    return std::any_of(p.entries.begin(), p.entries.end(),
                       [&](const auto& entry) { return entry.first.starts_with(prefix + "."); });
  };
  for (const std::string& prefix : {joint + ".pid", "gains." + joint, "pid." + joint})
    if (any(prefix)) return prefix;
  return count == 1 || any("pid") ? "pid" : joint + ".pid";
}
}  // namespace

CallbackReturn JointPidController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> names;
  std::string one, reference = "position", command = "effort";
  p.read("joint", one, {"the joint, if there is only one"});
  p.read("joints", names, {"the joints, in the order of the values"});
  p.read("reference", reference, {.text = "quantity of the reference", .choices = {"position", "velocity"}});
  p.read("command_interface", command, {.text = "interfaces to command", .choices = {"effort", "velocity"}});
  if (!one.empty()) names.insert(names.begin(), one);
  if (names.empty()) {
    refuse_no_joints(p);
    return CallbackReturn::failure;
  }
  position_ = reference == "position";
  joints_ = std::vector<Joint>(names.size());
  asked_.reset(names.size());
  gains_.clear();
  gains_.reserve(names.size());  // parameters know where they are
  prefixes_.clear();
  std::vector<std::string> fields;
  for (std::size_t j = 0; j < names.size(); ++j) {
    const std::string whole = context.whole_joint(names[j], one.empty() ? "joints" : "joint");
    const JointFacts& facts = *context.find_joint(whole);
    Joint& joint = joints_[j];
    joint.position = claim_state(whole + "/position");
    joint.velocity = claim_state(whole + "/velocity");
    joint.command = claim_command(whole + "/" + command);
    joint.continuous = facts.continuous;
    joint.lower = facts.lower;
    joint.upper = facts.upper;
    asked_.set(j, names[j], &facts);
    joint.gains = read_gains(p, prefix_of(p, names[j], names.size()));
    joint.pid = Pid(gains_[joint.gains].gains());
    for (const char* field : kFields) fields.push_back(names[j] + "." + field);
  }
  output_ = &add_output("state", "control_msgs/JointControllerState", std::move(fields));
  inbox_.reset(std::vector<double>(names.size(), std::numeric_limits<double>::quiet_NaN()));
  period_s_ = seconds(context.period);
  read_command_timeout(p);
  return CallbackReturn::success;
}

/// Which of gains_ these are; joints may share them.
std::size_t JointPidController::read_gains(Parameters& p, const std::string& prefix) {
  const auto known = std::find(prefixes_.begin(), prefixes_.end(), prefix);
  if (known != prefixes_.end()) return static_cast<std::size_t>(known - prefixes_.begin());
  prefixes_.push_back(prefix);
  read_ros_control_gains(p, prefix, gains_.emplace_back());
  return gains_.size() - 1;
}

void JointPidController::hold(Joint& joint) noexcept {
  joint.set_point = position_ ? measured(joint) : 0;
  joint.pid.reset();
}

CallbackReturn JointPidController::on_activate(const Cycle&) noexcept {
  inbox_.fetch();  // what was sent while it was not active is forgotten
  command_watch().forget();
  for (Joint& joint : joints_) {
    hold(joint);
    if (!std::isfinite(joint.set_point)) return CallbackReturn::error;
    set_command(joint.command, 0);
  }
  stopped_ = false;
  return CallbackReturn::success;
}

void JointPidController::on_deactivate(const Cycle&) noexcept {
  for (const Joint& joint : joints_) set_command(joint.command, 0);
}

void JointPidController::on_parameters_changed() noexcept {
  for (Joint& joint : joints_) joint.pid.set_gains(gains_[joint.gains].gains());
}

std::string JointPidController::refuse_changes(const std::vector<ParameterChange>& changes) const {
  return refuse_pid_changes(changes, gains_);
}

ReturnType JointPidController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  if (inbox_.fetch() && verdict.speed > 0) {
    command_watch().take(cycle.time, cycle.time);
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (const double asked = inbox_.value()[j]; std::isfinite(asked)) joints_[j].set_point = asked;
  }
  const bool asks = position_ || std::any_of(joints_.begin(), joints_.end(),
                                             [](const Joint& joint) { return joint.set_point != 0; });
  const bool expired = command_watch().expires(cycle.time, asks);
  // A stop: from now on it is held where it is, and what was asked for does not come back.
  if ((verdict.speed <= 0 && !std::exchange(stopped_, true)) || expired)
    for (Joint& joint : joints_)
      joint.set_point = position_ ? measured(joint) : 0;  // its integral carries it
  if (verdict.speed > 0) stopped_ = false;
  standing_ = true;
  for (Joint& joint : joints_) {
    joint.error = joint.set_point - measured(joint);
    if (position_ && joint.continuous) joint.error = shortest_turn(joint.error);
    const double speed = state(joint.velocity);
    asked_.note_position(static_cast<std::size_t>(&joint - joints_.data()), state(joint.position));
    // Of a position the measured velocity is the derivative that is known best.
    const double out = position_ ? joint.pid.compute(joint.error, -speed, period_s_)
                                 : joint.pid.compute(joint.error, period_s_);
    set_command(joint.command, std::isfinite(out) ? out : 0);  // what is not measured is not pushed
    if (!(std::abs(speed) < kJointMoves)) standing_ = false;
  }
  publish(cycle);
  return ReturnType::ok;
}

void JointPidController::publish(const Cycle& cycle) noexcept {
  if (!output_->wanted()) return;
  double* out = output_->draft().values.data();
  for (const Joint& joint : joints_) {
    const PidGains& gains = joint.pid.gains();
    const double change = position_ ? state(joint.velocity) : 0;  // nobody measures an acceleration
    for (const double value :
         {joint.set_point, measured(joint), change, joint.error, period_s_, command(joint.command), gains.p,
          gains.i, gains.d, gains.i_max, gains.clamp_output_only ? 0.0 : 1.0})
      *out++ = value;
  }
  output_->publish(cycle.time);
}

std::vector<InputPort> JointPidController::inputs() const {
  return {{"commands", {"std_msgs/Float64MultiArray"}}, {"command", {"std_msgs/Float64"}}};
}

std::uint64_t JointPidController::receive(const std::string&, const Input& message, bool) {
  const auto* numbers = std::get_if<Numbers>(&message);
  if (!numbers) throw Error("wrong-message", "this controller takes numbers (std_msgs/Float64)");
  if (numbers->values.size() != joints_.size())
    throw Error("wrong-size", "the message has " + std::to_string(numbers->values.size()) + " values for " +
                                  std::to_string(joints_.size()) + " joints");
  Problems problems;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    asked_.check(problems, j, position_ ? Asked::position : Asked::velocity, numbers->values[j]);
  problems.throw_if_errors();
  inbox_.write(numbers->values);
  return 0;
}

}  // namespace polyarm::controllers
