#include "polyarm/broadcasters/gpio_command_controller.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/text.hpp"
#include "polyarm/broadcasters/sensor_interfaces.hpp"

namespace polyarm::controllers {

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// "gpio/interface" for every interface that `kind`.<gpio>.interfaces lists.
std::vector<std::string> listed(Parameters& p, const std::string& kind, const std::vector<std::string>& gpios,
                                const char* text) {
  std::vector<std::string> out;
  for (const std::string& gpio : gpios) {
    const std::string key = kind + "." + gpio + ".interfaces";
    std::vector<std::string> interfaces;
    p.read(key, interfaces, {text});
    for (const std::string& interface : interfaces) {
      const std::string name = gpio + "/" + interface;
      if (std::find(out.begin(), out.end(), name) != out.end())
        p.problems().error("bad-value", place_of(p, key), "'" + name + "' is named twice");
      else
        out.push_back(name);
    }
  }
  return out;
}

/// Interfaces of what is not among `gpios` are told once, and passed over.
void pass_over_strangers(Parameters& p, const std::vector<std::string>& gpios) {
  std::erase_if(p.entries, [&](const auto& item) {
    for (const std::string kind : {"command_interfaces.", "state_interfaces."}) {
      const std::string& key = item.first;
      if (!key.starts_with(kind) || key.rfind('.') < kind.size()) continue;
      const std::string gpio = key.substr(kind.size(), key.rfind('.') - kind.size());
      if (std::find(gpios.begin(), gpios.end(), gpio) != gpios.end()) continue;
      p.problems().warning("unknown-gpio", item.second.where,
                           "'" + gpio + "' is not among gpios" + did_you_mean(gpio, gpios),
                           "it has no effect");
      return true;
    }
    return false;
  });
}

std::vector<std::string> read_gpios(Parameters& p) {
  std::vector<std::string> gpios;
  p.read("gpios", gpios, {"the gpios, by their names in the description"});
  if (gpios.empty())
    p.problems().error("bad-value", place_of(p, "gpios"), "it names no gpios", "write gpios: [NAME, …]");
  std::vector<std::string> sorted = gpios;
  std::sort(sorted.begin(), sorted.end());
  if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
    p.problems().error("bad-value", place_of(p, "gpios"), "'" + *twice + "' is named twice");
  return gpios;
}

}  // namespace

void GpioCommandController::read_commands(ControllerContext& context, const std::vector<std::string>& gpios) {
  Parameters& p = context.parameters;
  command_names_ = listed(p, "command_interfaces", gpios, "the commands of this gpio");
  command_places_.clear();
  for (const std::string& name : command_names_) {
    const std::string whole = context.whole_name(name);
    if (context.has_command(whole)) {
      command_places_.push_back(claim_command(whole));
      continue;
    }
    const std::string key = "command_interfaces." + name.substr(0, name.rfind('/')) + ".interfaces";
    p.problems().error("unknown-interface", place_of(p, key),
                       "there is no command '" + name + "'" + did_you_mean(whole, context.command_names));
  }
}

void GpioCommandController::read_states(ControllerContext& context, const std::vector<std::string>& gpios) {
  Parameters& p = context.parameters;
  state_names_ = listed(p, "state_interfaces", gpios, "the states of this gpio");
  if (state_names_.empty())
    for (const std::string& gpio : gpios)
      for (const std::string& state : context.state_names)
        if (state.starts_with(context.robot + "/" + gpio + "/"))
          state_names_.push_back(state.substr(context.robot.size() + 1));
  state_places_.clear();
  for (const std::string& name : state_names_) {
    const std::string whole = context.whole_name(name);
    if (context.has_state(whole)) {
      state_places_.push_back(claim_state(whole));
      continue;
    }
    const std::string key = "state_interfaces." + name.substr(0, name.rfind('/')) + ".interfaces";
    p.problems().error("unknown-interface", place_of(p, key),
                       "there is no state '" + name + "'" + did_you_mean(whole, context.state_names));
  }
}

CallbackReturn GpioCommandController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  const std::vector<std::string> gpios = read_gpios(p);
  read_commands(context, gpios);
  read_states(context, gpios);
  pass_over_strangers(p, gpios);
  read_command_timeout(p);
  if (!gpios.empty() && command_names_.empty() && state_names_.empty())
    p.problems().error("bad-value", place_of(p, "gpios"),
                       "there is nothing to command and nothing to publish: no gpio of the list has states",
                       "write command_interfaces: {GPIO: {interfaces: [NAME, …]}}");
  states_ = &add_output("gpio_states", "control_msgs/DynamicJointState", state_names_);
  asked_ = {0, std::vector<double>(command_names_.size(), kNothing)};
  inbox_.reset(asked_);
  return CallbackReturn::success;
}

CallbackReturn GpioCommandController::on_activate(const Cycle&) noexcept {
  activation_.fetch_add(1);  // what was sent before is forgotten
  inbox_.fetch();
  command_watch().forget();
  return CallbackReturn::success;
}

ReturnType GpioCommandController::update(const Cycle& cycle, const Verdict&) noexcept {
  if (inbox_.fetch() && inbox_.value().activation == activation_.load(std::memory_order_relaxed)) {
    const std::vector<double>& asked = inbox_.value().values;
    command_watch().take(cycle.time, cycle.time);
    for (std::size_t i = 0; i < command_places_.size(); ++i)
      if (!std::isnan(asked[i])) set_command(command_places_[i], asked[i]);
  }
  if (command_watch().expires(cycle.time)) {
    activation_.fetch_add(1);  // what was sent before does not come back with the next message
    for (std::size_t i = 0; i < command_places_.size(); ++i)
      if (!std::isnan(inbox_.value().values[i])) set_command(command_places_[i], 0);
  }
  std::vector<double>& out = states_->draft().values;
  for (std::size_t i = 0; i < state_places_.size(); ++i) out[i] = state(state_places_[i]);
  states_->publish(cycle.time);
  return ReturnType::ok;
}

std::vector<InputPort> GpioCommandController::inputs() const {
  if (command_names_.empty()) return {};
  return {{"commands", {"control_msgs/DynamicJointState"}}};
}

std::uint64_t GpioCommandController::receive(const std::string& port, const Input& message, bool goal) {
  if (port != "commands" || command_names_.empty()) return Controller::receive(port, message, goal);
  const auto* sent = std::get_if<NamedValues>(&message);
  if (!sent) throw Error("wrong-message", "this controller takes values by name (DynamicJointState)");
  if (sent->names.size() != sent->values.size())
    throw Error("wrong-size", "the message has " + std::to_string(sent->names.size()) + " names and " +
                                  std::to_string(sent->values.size()) + " values");
  const std::uint32_t activation = activation_.load();
  if (asked_.activation != activation)
    asked_ = {activation, std::vector<double>(command_names_.size(), kNothing)};
  std::vector<double> asked = asked_.values;
  for (std::size_t k = 0; k < sent->names.size(); ++k) {
    const auto found = std::find(command_names_.begin(), command_names_.end(), sent->names[k]);
    if (found == command_names_.end())
      throw Error("unknown-interface",
                  "it commands no '" + sent->names[k] + "'" + did_you_mean(sent->names[k], command_names_),
                  "it commands " + join(command_names_, ", "));
    if (std::isinf(sent->values[k]))
      throw Error("not-a-number", "the value for '" + sent->names[k] + "' is not finite");
    if (!std::isnan(sent->values[k]))
      asked[static_cast<std::size_t>(found - command_names_.begin())] = sent->values[k];
  }
  asked_.values = std::move(asked);
  inbox_.write(asked_);
  return 0;
}

}  // namespace polyarm::controllers
