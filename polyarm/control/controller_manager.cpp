#include "polyarm/control/controller_manager.hpp"

#include "polyarm/base/text.hpp"

namespace polyarm::control {

using hardware::LifecycleState;

namespace {
template <typename Find>
std::vector<std::size_t> resolve(const std::vector<std::string>& names, const std::vector<std::string>& known,
                                 const char* kind, const std::string& controller, Find find) {
  std::vector<std::size_t> out;
  for (const std::string& name : names) {
    const auto index = find(name);
    if (!index)
      throw Error("unknown-interface",
                  "the controller '" + controller + "' needs the " + kind + " interface '" + name +
                      "', which no hardware offers" + did_you_mean(name, known),
                  "check the joint names and the interfaces of the hardware");
    out.push_back(*index);
  }
  return out;
}
}  // namespace

void ControllerManager::add(std::unique_ptr<controllers::Controller> controller,
                            const controllers::ControllerContext& context, unsigned divisor) {
  for (const Slot& other : slots_)
    if (other.name == context.name)
      throw Error("duplicate-controller", "two controllers are called '" + context.name + "'",
                  "rename one of them");
  if (controller->on_configure(context) != controllers::CallbackReturn::success)
    throw Error("controller-failed", "the controller '" + context.name + "' could not be configured",
                "check that its parameters name joints or interfaces");
  Slot slot{context.name, std::move(controller)};
  slot.divisor = divisor == 0 ? 1 : divisor;
  slot.command_names = slot.controller->command_interfaces();
  slot.commands = resolve(slot.command_names, table_.command_names(), "command", slot.name,
                          [&](const std::string& name) { return table_.find_command(name); });
  auto states = resolve(slot.controller->state_interfaces(), table_.state_names(), "state", slot.name,
                        [&](const std::string& name) { return table_.find_state(name); });
  slot.controller->bind({table_.states(), table_.commands(), std::move(states), slot.commands});
  slots_.push_back(std::move(slot));
}

ControllerManager::Slot& ControllerManager::slot(const std::string& name) {
  std::vector<std::string> names;
  for (Slot& slot : slots_) {
    if (slot.name == name) return slot;
    names.push_back(slot.name);
  }
  throw Error("unknown-controller", "there is no controller '" + name + "'" + did_you_mean(name, names), {});
}

void ControllerManager::activate(const std::string& name, const hardware::Cycle& cycle) {
  Slot& wanted = slot(name);
  if (wanted.state == LifecycleState::active) return;
  for (const std::size_t command : wanted.commands)
    if (const int holder = table_.claims()[command]; holder >= 0)
      throw Error("claimed",
                  "the controller '" + name + "' needs '" + table_.command_names()[command] +
                      "', which the active controller '" + name_of(holder) + "' holds",
                  "deactivate that one first");
  if (!hardware_.perform_mode_switch(wanted.command_names, {}))
    throw Error("mode-refused", "the hardware refuses the commands of the controller '" + name + "'",
                "it cannot take these command interfaces together");
  for (const std::size_t command : wanted.commands)
    table_.claims()[command] = static_cast<int>(&wanted - slots_.data());
  if (wanted.controller->on_activate(cycle) != controllers::CallbackReturn::success) {
    for (const std::size_t command : wanted.commands) table_.claims()[command] = -1;
    throw Error("controller-failed", "the controller '" + name + "' could not be activated", {});
  }
  wanted.state = LifecycleState::active;
}

void ControllerManager::deactivate(const std::string& name, const hardware::Cycle& cycle) {
  Slot& wanted = slot(name);
  if (wanted.state != LifecycleState::active) return;
  wanted.controller->on_deactivate(cycle);
  for (const std::size_t command : wanted.commands) table_.claims()[command] = -1;
  wanted.state = LifecycleState::inactive;
  hardware_.perform_mode_switch({}, wanted.command_names);
}

void ControllerManager::update(const hardware::Cycle& cycle, const controllers::Verdict& verdict) noexcept {
  failed_ = -1;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    if (slot.state != LifecycleState::active || cycle.index % slot.divisor != 0) continue;
    if (slot.controller->update(cycle, verdict) == controllers::ReturnType::ok) continue;
    slot.controller->on_deactivate(cycle);
    for (const std::size_t command : slot.commands) table_.claims()[command] = -1;
    slot.state = LifecycleState::inactive;
    failed_ = static_cast<int>(i);
  }
}

bool ControllerManager::standing() const noexcept {
  for (const Slot& slot : slots_)
    if (slot.state == LifecycleState::active && !slot.controller->standing()) return false;
  return true;
}

controllers::Controller* ControllerManager::find(const std::string& name) const {
  for (const Slot& slot : slots_)
    if (slot.name == name) return slot.controller.get();
  return nullptr;
}

std::vector<ControllerManager::Listed> ControllerManager::list() const {
  std::vector<Listed> out;
  for (const Slot& slot : slots_) out.push_back({slot.name, {}, slot.state});
  return out;
}

}  // namespace polyarm::control
