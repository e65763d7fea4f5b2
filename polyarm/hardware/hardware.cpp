#include "polyarm/hardware/hardware.hpp"

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::hardware {

const char* name(LifecycleState state) {
  switch (state) {
    case LifecycleState::unconfigured:
      return "unconfigured";
    case LifecycleState::inactive:
      return "inactive";
    case LifecycleState::active:
      return "active";
    case LifecycleState::finalized:
      return "finalized";
  }
  return "unknown";
}

Hardware::~Hardware() {
  shut_down();
}

void Hardware::add(std::unique_ptr<Component> component, const ComponentContext& context) {
  if (component->on_init(context) != CallbackReturn::success)
    throw Error("component-failed", "the hardware component '" + context.name + "' could not be initialised",
                "check its parameters");
  Hosted hosted{context.name, std::move(component)};
  hosted.first_state = table_.states().size();
  for (InterfaceDescription& d : hosted.component->state_interfaces())
    table_.add_state(std::move(d.name), d.initial);
  hosted.states = table_.states().size() - hosted.first_state;
  hosted.first_command = table_.commands().size();
  for (InterfaceDescription& d : hosted.component->command_interfaces())
    table_.add_command(std::move(d.name));
  hosted.commands = table_.commands().size() - hosted.first_command;
  hosted_.push_back(std::move(hosted));
}

void Hardware::advance(Hosted& hosted, CallbackReturn (Component::*step)(), LifecycleState to,
                       const char* step_name) {
  if ((hosted.component.get()->*step)() != CallbackReturn::success)
    throw Error("component-failed", "the hardware component '" + hosted.name + "' could not be " + step_name,
                "check that it is connected and that its parameters are right");
  hosted.state = to;
}

void Hardware::configure_and_activate() {
  for (Hosted& hosted : hosted_)
    advance(hosted, &Component::on_configure, LifecycleState::inactive, "configured");
  for (Hosted& hosted : hosted_)
    advance(hosted, &Component::on_activate, LifecycleState::active, "activated");
  for (const Hosted& hosted : hosted_)
    if (!world_ && hosted.component->world()) {
      world_ = hosted.component->world();
      world_names_ = hosted.component->world_names();
    }
}

void Hardware::shut_down() noexcept {
  for (auto hosted = hosted_.rbegin(); hosted != hosted_.rend(); ++hosted) {
    if (hosted->state == LifecycleState::active) hosted->component->on_deactivate();
    if (hosted->state != LifecycleState::finalized) hosted->component->on_shutdown();
    hosted->state = LifecycleState::finalized;
  }
}

void Hardware::force(const std::string& interface_name, double value) {
  const auto state = table_.find_state(interface_name);
  const auto command = table_.find_command(interface_name);
  if (!state && !command) {
    std::vector<std::string> names = table_.state_names();
    names.insert(names.end(), table_.command_names().begin(), table_.command_names().end());
    throw Error("unknown-interface",
                "there is no interface '" + interface_name + "'" + did_you_mean(interface_name, names),
                "interfaces are named robot/joint/interface, for example arm/tool/vacuum");
  }
  if (state) forced_.push_back({true, *state, value});
  if (command) forced_.push_back({false, *command, value});
}

Fault Hardware::read(const Cycle& cycle) noexcept {
  Fault fault;
  const std::span<double> states = table_.states();
  for (std::size_t i = 0; i < hosted_.size(); ++i) {
    Hosted& hosted = hosted_[i];
    if (hosted.state != LifecycleState::active) continue;
    const ReturnType result =
        hosted.component->read(cycle, states.subspan(hosted.first_state, hosted.states));
    if (result != ReturnType::ok && !fault)
      fault = {result == ReturnType::error ? FaultKind::component_read : FaultKind::component_deactivated,
               static_cast<std::int32_t>(i)};
  }
  for (const ForcedValue& forced : forced_)
    if (forced.state) states[forced.index] = forced.value;
  return fault;
}

Fault Hardware::write(const Cycle& cycle) noexcept {
  Fault fault;
  const std::span<double> commands = table_.commands();
  for (const ForcedValue& forced : forced_)
    if (!forced.state) commands[forced.index] = forced.value;
  for (std::size_t i = 0; i < hosted_.size(); ++i) {
    Hosted& hosted = hosted_[i];
    if (hosted.state != LifecycleState::active) continue;
    const ReturnType result =
        hosted.component->write(cycle, commands.subspan(hosted.first_command, hosted.commands));
    if (result != ReturnType::ok && !fault)
      fault = {result == ReturnType::error ? FaultKind::component_write : FaultKind::component_deactivated,
               static_cast<std::int32_t>(i)};
  }
  return fault;
}

bool Hardware::perform_mode_switch(std::span<const std::string> start, std::span<const std::string> stop) {
  for (Hosted& hosted : hosted_)
    if (hosted.component->prepare_command_mode_switch(start, stop) != ReturnType::ok) return false;
  for (Hosted& hosted : hosted_)
    if (hosted.component->perform_command_mode_switch(start, stop) != ReturnType::ok) return false;
  return true;
}

std::vector<std::string> Hardware::summaries() const {
  std::vector<std::string> out;
  for (const Hosted& hosted : hosted_)
    if (const std::string text = hosted.component->summary(); !text.empty())
      out.push_back(hosted.name + ": " + text);
  return out;
}

}  // namespace polyarm::hardware
