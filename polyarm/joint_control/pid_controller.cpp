#include "polyarm/joint_control/pid_controller.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/controllers/pid_parameters.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kFields[] = {"reference", "feedback",  "feedback_dot", "error",
                                   "error_dot", "time_step", "output"};
constexpr double kMoves = 1e-3;    // rad/s or m/s: slower is standing
constexpr double kRestTime = 0.1;  // s for which a position stays where it is before it rests

void require(Parameters& p, const char* key, bool there, const char* what, const char* advice) {
  const auto entry = p.entries.find(key);
  if (!there)
    p.problems().error("missing-parameter", entry == p.entries.end() ? Location{} : entry->second.where, what,
                       advice);
}
}  // namespace

// --- values that come in messages -------------------------------------------------------------------------

void ValueInbox::reset(std::size_t size) {
  sent_ = {0, std::vector<double>(size, kNone), std::vector<std::uint64_t>(size, 0)};
  seen_ = 0;
  box_.reset(sent_);
}

void ValueInbox::post(const std::vector<std::size_t>& places, const std::vector<double>& values) {
  ++sent_.count;
  for (std::size_t k = 0; k < places.size(); ++k) {
    sent_.values[places[k]] = values[k];
    sent_.message[places[k]] = sent_.count;
  }
  box_.write(sent_);
}

void ValueInbox::forget() noexcept {
  fetch([](std::size_t, double) {});
}

// --- configuration ----------------------------------------------------------------------------------------

CallbackReturn PidController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> names, others, interfaces{"position"};
  std::string command;
  external_ = false, start_here_ = forward_ = true;
  p.read("dof_names", names, {"the degrees of freedom that are commanded"});
  p.read("reference_and_state_dof_names", others,
         {"names of their references and states, where these are others"});
  read_command_timeout(p);
  p.read("command_interface", command, {"the interface that is commanded"});
  p.read("reference_and_state_interfaces", interfaces,
         {"interfaces of references and measured states; the second is the derivative of the first"});
  p.read("use_external_measured_states", external_, {"measured states come as messages"});
  p.read("set_current_state_as_first_setpoint", start_here_, {"begin by holding the measured value"});
  p.read("enable_feedforward", forward_,
         {.text = "feed forward is used where feedforward_gain is not 0", .changeable = true});
  require(p, "dof_names", !names.empty(), "the PID has no degrees of freedom", "write dof_names: [JOINT, …]");
  require(p, "command_interface", !command.empty(), "it is not said what the PID commands",
          "write command_interface: effort, velocity or position");
  require(p, "reference_and_state_interfaces", interfaces.size() == 1 || interfaces.size() == 2,
          "the PID needs one interface, or two of which the second is the derivative of the first",
          "write reference_and_state_interfaces: [position] or [position, velocity]");
  require(p, "reference_and_state_dof_names", others.empty() || others.size() == names.size(),
          "reference_and_state_dof_names has not as many names as dof_names",
          "write one for each, in their order");
  if (p.problems().has_errors()) return CallbackReturn::failure;
  width_ = interfaces.size();
  quantity_ = interfaces[0] == "position"   ? Quantity::position
              : interfaces[0] == "velocity" ? Quantity::velocity
                                            : Quantity::other;
  measures_speed_ = width_ > 1 && interfaces[1] == "velocity";
  dofs_ = std::vector<Dof>(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) dofs_[i].name = others.empty() ? names[i] : others[i];
  read_dofs(context, names, interfaces, command);
  std::vector<std::string> fields;
  for (const Dof& dof : dofs_)
    for (const char* field : kFields) fields.push_back(dof.name + "." + field);
  output_ = &add_output("controller_state", "control_msgs/MultiDOFStateStamped", std::move(fields));
  const std::size_t values = dofs_.size() * width_;
  references_.reset(values);
  external_states_.reset(values);
  measured_.assign(values, kNone);
  wanted_.assign(values, kNone);
  period_s_ = seconds(context.period);
  stopped_ = released_ = false;
  standing_ = true;
  return CallbackReturn::success;
}

void PidController::read_dofs(ControllerContext& context, const std::vector<std::string>& names,
                              const std::vector<std::string>& interfaces, const std::string& command) {
  for (const std::string& interface : interfaces)
    for (const Dof& dof : dofs_) {
      if (!external_) claim_state(context.whole_name(dof.name + "/" + interface));
      export_reference(context.name + "/" + dof.name + "/" + interface);
      export_state(context.name + "/" + dof.name + "/" + interface);
    }
  gains_.assign(names.size(), {});
  asked_.reset(names.size());
  const auto is_joint = [&](const std::string& interface) {
    return context.find_joint(interface.substr(0, interface.rfind('/'))) != nullptr;
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    Dof& dof = dofs_[i];
    const std::string commanded = context.whole_name(names[i] + "/" + command);
    dof.command = claim_command(commanded);
    dof.pushes = command != "position";
    dof.velocity = command == "velocity";
    const std::string measured = context.whole_name(dof.name + "/" + interfaces[0]);
    asked_.set(i, dof.name, context.find_joint(measured.substr(0, measured.rfind('/'))));
    dof.joint = is_joint(commanded) || is_joint(context.whole_name(dof.name + "/" + interfaces[0]));
    read_gains(context.parameters, "gains." + names[i], i);
  }
}

void PidController::read_gains(Parameters& p, const std::string& prefix, std::size_t i) {
  Dof& dof = dofs_[i];
  bool publish = false;
  read_pid_gains(p, prefix, gains_[i]);
  p.read(prefix + ".feedforward_gain", dof.feed_forward,
         {.text = "share of the reference (of two: of the derivative) that is commanded beside the feedback",
          .changeable = true});
  p.read(prefix + ".angle_wraparound", dof.wraps, {"the error goes the shorter way round"});
  p.read(prefix + ".save_i_term", dof.keeps_integral, {"the integral is kept while it is not active"});
  p.read(prefix + ".saturation", dof.saturates,
         {.text = "u_clamp_max and u_clamp_min hold", .changeable = true});
  p.read(prefix + ".activate_state_publisher", publish, {"the state can always be watched"});
  dof.pid = Pid(gains_of(i));
}

PidGains PidController::gains_of(std::size_t i) const noexcept {
  PidGains gains = gains_[i];
  if (!dofs_[i].saturates) gains.u_max = kUnlimited, gains.u_min = -kUnlimited;
  return gains;
}

void PidController::on_parameters_changed() noexcept {
  for (std::size_t i = 0; i < dofs_.size(); ++i) dofs_[i].pid.set_gains(gains_of(i));
}

std::string PidController::refuse_changes(const std::vector<ParameterChange>& changes) const {
  return refuse_pid_changes(changes, gains_);
}

// --- life cycle -------------------------------------------------------------------------------------------

void PidController::forget_values() noexcept {
  references_.forget();
  command_watch().forget();
  external_states_.forget();
  std::fill(measured_.begin(), measured_.end(), kNone);
  for (std::size_t k = 0; k < wanted_.size(); ++k) {
    ask(k, kNone);
    set_exported(k, kNone);
  }
}

CallbackReturn PidController::on_activate(const Cycle&) noexcept {
  forget_values();
  measure();
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    Dof& dof = dofs_[i];
    dof.pid.reset(dof.keeps_integral);
    dof.rests_at = measured_[i];
    dof.rests_for = kRestTime;
    if (!start_here_ || external_) continue;  // what comes in messages is held when it comes
    ask(i, measured_[i]);
    if (width_ > 1) ask(place(i, 1), 0);
  }
  stopped_ = released_ = false;
  standing_ = true;
  return CallbackReturn::success;
}

void PidController::on_deactivate(const Cycle&) noexcept {
  for (const Dof& dof : dofs_)
    if (dof.pushes) set_command(dof.command, 0);  // a position stays where it was commanded last
  forget_values();
  standing_ = true;
}

/// The controller before this one may go while this one stays: its last position is held, its last velocity
/// is not.
void PidController::set_chained(bool chained) noexcept {
  released_ = Controller::chained() && !chained;
  Controller::set_chained(chained);
}

// --- the cycle --------------------------------------------------------------------------------------------

void PidController::measure() noexcept {
  if (external_)
    external_states_.fetch([&](std::size_t k, double value) { measured_[k] = value; });
  else
    for (std::size_t k = 0; k < measured_.size(); ++k) measured_[k] = state(k);
  for (std::size_t k = 0; k < measured_.size(); ++k) set_exported(k, measured_[k]);
  if (quantity_ == Quantity::position)
    for (std::size_t i = 0; i < dofs_.size(); ++i) asked_.note_position(i, measured_[i]);
}

void PidController::take_references(bool stop, Nanoseconds now) noexcept {
  const bool chained = Controller::chained();
  if (chained) command_watch().forget();
  if (chained)
    for (std::size_t k = 0; k < wanted_.size(); ++k) wanted_[k] = reference(k);
  else if (std::exchange(released_, false))
    for (std::size_t k = quantity_ == Quantity::velocity ? 0 : dofs_.size(); k < wanted_.size(); ++k)
      ask(k, 0);
  references_.fetch([&](std::size_t k, double value) {
    if (chained || stop || !std::isfinite(value)) return;
    ask(k, value);
    command_watch().take(now, now);
  });
  if (command_watch().expires(now)) hold();
  if (!external_ || !start_here_ || chained) return;
  for (std::size_t i = 0; i < dofs_.size(); ++i)
    if (std::isnan(wanted_[i]) && std::isfinite(measured_[i])) {
      ask(i, measured_[i]);
      if (width_ > 1 && std::isnan(wanted_[place(i, 1)])) ask(place(i, 1), 0);
    }
}

/// A stop: what was asked for does not come back. The integral carries what it carried.
void PidController::hold() noexcept {
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    if (!dofs_[i].joint || quantity_ == Quantity::other) continue;
    if (quantity_ == Quantity::velocity)
      ask(i, 0);
    else if (std::isfinite(measured_[i]))
      ask(i, measured_[i]);
    if (width_ > 1) ask(place(i, 1), 0);
  }
}

void PidController::control(std::size_t i, bool stop) noexcept {
  Dof& dof = dofs_[i];
  // A joint that moves until something else is as it should be (a force) stands while it is stopped.
  if (stop && dof.joint && dof.velocity && quantity_ == Quantity::other) return set_command(dof.command, 0);
  double error = wanted_[i] - measured_[i], out = kNone;
  if (dof.wraps) error -= 2 * std::numbers::pi * std::round(error / (2 * std::numbers::pi));
  if (std::isfinite(error)) {
    const double requested_change = width_ > 1 ? wanted_[place(i, 1)] : kNone;
    const double change = width_ > 1 ? requested_change - measured_[place(i, 1)] : kNone;
    out =
        std::isfinite(change) ? dof.pid.compute(error, change, period_s_) : dof.pid.compute(error, period_s_);
    const double ahead = width_ > 1 ? requested_change : wanted_[i];
    if (forward_ && std::isfinite(ahead)) out += dof.feed_forward * ahead;
  }
  if (std::isfinite(out))
    set_command(dof.command, out);
  else if (dof.pushes)
    set_command(dof.command, 0);  // what is not measured is not pushed
}

/// By its velocity where that is measured, else when it has stayed where it is for a while.
bool PidController::rests(std::size_t i) noexcept {
  Dof& dof = dofs_[i];
  if (!dof.joint || quantity_ == Quantity::other) return true;
  if (quantity_ == Quantity::velocity) return !(std::abs(measured_[i]) >= kMoves);
  if (measures_speed_) return !(std::abs(measured_[place(i, 1)]) >= kMoves);
  if (!std::isfinite(measured_[i])) return true;
  if (std::abs(measured_[i] - dof.rests_at) <= kMoves * kRestTime) {
    dof.rests_for += period_s_;
  } else {
    dof.rests_at = measured_[i];
    dof.rests_for = 0;
  }
  return dof.rests_for >= kRestTime;
}

ReturnType PidController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  const bool stop = verdict.speed <= 0;
  measure();
  take_references(stop, cycle.time);
  if (stop && !std::exchange(stopped_, true) && !chained()) hold();
  stopped_ = stop;
  standing_ = true;
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    control(i, stop);
    standing_ = rests(i) && standing_;
  }
  publish(cycle);
  return ReturnType::ok;
}

void PidController::publish(const Cycle& cycle) noexcept {
  if (!output_->wanted()) return;
  double* told = output_->draft().values.data();
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    const std::size_t dot = width_ > 1 ? place(i, 1) : 0;
    double error = wanted_[i] - measured_[i];
    if (dofs_[i].wraps) error -= 2 * std::numbers::pi * std::round(error / (2 * std::numbers::pi));
    for (const double value :
         {wanted_[i], measured_[i], width_ > 1 ? measured_[dot] : kNone, error,
          width_ > 1 ? wanted_[dot] - measured_[dot] : kNone, period_s_, command(dofs_[i].command)})
      *told++ = value;
  }
  output_->publish(cycle.time);
}

Asked PidController::kind_of(bool derivative) const noexcept {
  if (quantity_ == Quantity::position) return derivative ? Asked::velocity : Asked::position;
  if (quantity_ == Quantity::velocity) return derivative ? Asked::acceleration : Asked::velocity;
  return Asked::effort;
}

// --- messages ---------------------------------------------------------------------------------------------

std::vector<InputPort> PidController::inputs() const {
  std::vector<InputPort> out{{"reference", {"control_msgs/MultiDOFCommand"}}};
  if (external_) out.push_back({"measured_state", {"control_msgs/MultiDOFCommand"}});
  return out;
}

void PidController::send(ValueInbox& inbox, const Input& message, const RequestedLimits* limits) const {
  const auto* named = std::get_if<NamedValues>(&message);
  if (!named || named->names.size() != named->values.size())
    throw Error("wrong-message",
                "this controller takes named values, one for each name (control_msgs/MultiDOFCommand)");
  std::vector<std::string> known;
  for (const Dof& dof : dofs_) known.push_back(dof.name);
  std::vector<std::size_t> places;
  std::vector<double> values;
  Problems problems;
  for (std::size_t k = 0; k < named->names.size(); ++k) {
    std::string name = named->names[k];
    const bool derivative = name.ends_with("/dot");
    if (derivative) name.resize(name.size() - 4);
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      throw Error("unknown-dof", "the message names '" + name + "', which this controller has not" +
                                     did_you_mean(name, known));
    if (derivative && width_ < 2) continue;  // nobody asked for it
    const auto dof = static_cast<std::size_t>(found - known.begin());
    if (limits) limits->check(problems, dof, kind_of(derivative), named->values[k]);
    places.push_back(place(dof, derivative ? 1 : 0));
    values.push_back(named->values[k]);
  }
  problems.throw_if_errors();
  inbox.post(places, values);
}

std::uint64_t PidController::receive(const std::string& port, const Input& message, bool goal) {
  if (port == "measured_state" && external_)
    send(external_states_, message, nullptr);
  else if (port == "reference")
    send(references_, message, &asked_);
  else
    return Controller::receive(port, message, goal);
  return 0;
}

}  // namespace polyarm::controllers
