#include "polyarm/controllers/pid_controller.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/base/text.hpp"
#include "polyarm/controllers/pid_parameters.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kFields[] = {"reference", "feedback", "error", "output"};
}  // namespace

CallbackReturn PidController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::vector<std::string> names, others, interfaces{"position"};
  std::string command;
  bool forward = false, publish = false;
  p.read("dof_names", names, {"the degrees of freedom that are commanded"});
  p.read("reference_and_state_dof_names", others,
         {"names of their references and states, where these are others"});
  p.read("command_interface", command, {"the interface that is commanded"});
  p.read("reference_and_state_interfaces", interfaces,
         {"what is asked for and measured; the second is its derivative"});
  p.read("use_external_measured_states", external_, {"measured states come as messages"});
  p.read("set_current_state_as_first_setpoint", start_here_, {"begin by holding what is measured"});
  p.read("enable_feedforward", forward, {"feed forward is used where feedforward_gain is not 0"});
  p.read("activate_state_publisher", publish, {"the state can always be watched"});
  if (names.empty() || command.empty() || interfaces.empty() || interfaces.size() > 2)
    return CallbackReturn::failure;
  if (!others.empty() && others.size() != names.size())
    throw Error("wrong-size", "reference_and_state_dof_names has " + std::to_string(others.size()) +
                                  " names for " + std::to_string(names.size()) + " dof_names");
  width_ = interfaces.size();
  dofs_.assign(names.size(), {});
  gains_.assign(names.size(), {});
  std::vector<std::string> fields;
  for (std::size_t i = 0; i < names.size(); ++i) {
    Dof& dof = dofs_[i];
    dof.name = others.empty() ? names[i] : others[i];
    dof.command = claim_command(context.whole_name(names[i] + "/" + command));
    dof.pushes = command != "position";
    for (const std::string& interface : interfaces) {
      if (!external_) dof.states.push_back(claim_state(context.whole_name(dof.name + "/" + interface)));
      dof.references.push_back(export_reference(context.name + "/" + dof.name + "/" + interface));
    }
    dof.told_error = export_state(context.name + "/" + dof.name + "/pid_error");
    const std::string prefix = "gains." + names[i];
    read_pid_gains(p, prefix, gains_[i]);
    p.read(prefix + ".feedforward_gain", dof.feed_forward,
           {.text = "share of the reference that is commanded beside the feedback", .changeable = true});
    p.read(prefix + ".angle_wraparound", dof.wraps, {"the error goes the shorter way round"});
    p.read(prefix + ".save_i_term", dof.keeps_integral, {"the integral is kept while it is not active"});
    bool saturation = true;
    p.read(prefix + ".saturation", saturation, {"u_clamp_max and u_clamp_min hold"});
    if (!saturation) gains_[i].u_max = kUnlimited, gains_[i].u_min = -kUnlimited;
    dof.pid = Pid(gains_[i]);
    for (const char* field : kFields) fields.push_back(dof.name + "." + field);
  }
  output_ = &add_output("controller_state", "control_msgs/MultiDOFStateStamped", std::move(fields));
  const std::vector<double> nothing(names.size() * width_, kNone);
  references_.reset(nothing);
  external_states_.reset(nothing);
  measured_ = nothing;
  period_s_ = seconds(context.period);
  return CallbackReturn::success;
}

void PidController::set_first_references() noexcept {
  for (const Dof& dof : dofs_)
    for (std::size_t k = 0; k < width_; ++k)
      set_reference(dof.references[k], !start_here_ || external_ ? kNone
                                       : k == 0                  ? state(dof.states[0])
                                                                 : 0.0);
}

CallbackReturn PidController::on_activate(const Cycle&) noexcept {
  references_.fetch();
  for (Dof& dof : dofs_) dof.pid.reset(dof.keeps_integral);
  set_first_references();
  return CallbackReturn::success;
}

void PidController::on_deactivate(const Cycle&) noexcept {
  for (const Dof& dof : dofs_)
    if (dof.pushes) set_command(dof.command, 0);  // a position stays where it was commanded last
}

void PidController::on_parameters_changed() noexcept {
  for (std::size_t i = 0; i < dofs_.size(); ++i) dofs_[i].pid.set_gains(gains_[i]);
}

std::string PidController::refuse_changes(const std::vector<ParameterChange>& changes) const {
  return refuse_pid_changes(changes, gains_);
}

ReturnType PidController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  if (external_states_.fetch())
    measured_ = external_states_.value();  // of the same size: nothing is allocated
  const bool stop = verdict.speed <= 0;
  const bool fresh = references_.fetch();
  if (fresh && !chained() && !stop)
    for (std::size_t i = 0; i < dofs_.size(); ++i)
      for (std::size_t k = 0; k < width_; ++k)
        if (const double asked = references_.value()[i * width_ + k]; std::isfinite(asked))
          set_reference(dofs_[i].references[k], asked);
  double* told = output_->draft().values.data();
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    Dof& dof = dofs_[i];
    const auto measured = [&](std::size_t k) {
      return external_ ? measured_[i * width_ + k] : state(dof.states[k]);
    };
    const double reference = Controller::reference(dof.references[0]);
    double error = reference - measured(0);
    if (dof.wraps) error -= 2 * std::numbers::pi * std::round(error / (2 * std::numbers::pi));
    double out = kNone;
    if (std::isfinite(error)) {
      const double change = width_ > 1 ? Controller::reference(dof.references[1]) - measured(1) : kNone;
      out = std::isfinite(change) ? dof.pid.compute(error, change, period_s_)
                                  : dof.pid.compute(error, period_s_);
      out += dof.feed_forward * reference;
    }
    if (std::isfinite(out))
      set_command(dof.command, out);
    else if (dof.pushes)
      set_command(dof.command, 0);  // what is not measured is not pushed
    set_exported(dof.told_error, error);
    for (const double value : {reference, measured(0), error, out}) *told++ = value;
  }
  output_->publish(cycle.time);
  return ReturnType::ok;
}

std::vector<InputPort> PidController::inputs() const {
  return {{"reference", {"control_msgs/MultiDOFCommand"}},
          {"measured_state", {"control_msgs/MultiDOFCommand"}}};
}

std::vector<double> PidController::read_values(const Input& message) const {
  const auto* named = std::get_if<NamedValues>(&message);
  if (!named)
    throw Error("wrong-message", "this controller takes named values (control_msgs/MultiDOFCommand)");
  std::vector<double> out(dofs_.size() * width_, kNone);
  std::vector<std::string> known;
  for (const Dof& dof : dofs_) known.push_back(dof.name);
  for (std::size_t n = 0; n < named->names.size(); ++n) {
    std::string name = named->names[n];
    const bool derivative = name.ends_with("/dot");
    if (derivative) name.resize(name.size() - 4);
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      throw Error("unknown-dof", "the message names '" + name + "', which this controller has not" +
                                     did_you_mean(name, known));
    if (derivative && width_ < 2) continue;
    out[static_cast<std::size_t>(found - known.begin()) * width_ + (derivative ? 1 : 0)] = named->values[n];
  }
  return out;
}

std::uint64_t PidController::receive(const std::string& port, const Input& message, bool) {
  (port == "measured_state" ? external_states_ : references_).write(read_values(message));
  return 0;
}

}  // namespace polyarm::controllers
