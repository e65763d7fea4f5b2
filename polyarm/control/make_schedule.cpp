/// Creates the schedule of the controller manager: order of updates, and what stops together with what.
#include <algorithm>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "polyarm/control/schedule.hpp"

namespace polyarm::control {

using hardware::LifecycleState;

std::unique_ptr<ControllerManager::Commit> ControllerManager::commit_of(const SwitchPlan& plan) const {
  auto commit = std::make_unique<Commit>();
  for (const std::string& name : plan.stop) commit->stop.push_back(&slot(name));
  for (const std::string& name : plan.start) commit->start.push_back(&slot(name));
  for (const std::string& name : plan.chained) commit->chains.emplace_back(&slot(name), true);
  for (const std::string& name : plan.unchained) commit->chains.emplace_back(&slot(name), false);
  const auto taken_over = [&](std::size_t command) {
    return std::any_of(commit->start.begin(), commit->start.end(), [&](const Slot* s) {
      return std::find(s->commands.begin(), s->commands.end(), command) != s->commands.end();
    });
  };
  for (const Slot* s : commit->stop)
    for (const std::size_t command : s->pushes)
      if (!taken_over(command)) commit->left.push_back(command);
  commit->start_interfaces = plan.start_interfaces;
  commit->stop_interfaces = plan.stop_interfaces;
  return commit;
}

namespace {
std::vector<ControllerView> some_of(std::span<const ControllerView> views,
                                    std::span<const std::size_t> which) {
  std::vector<ControllerView> out;
  for (const std::size_t i : which) out.push_back(views[i]);
  return out;
}

/// Stops all controllers of the given chains; controllers in no chain with them are not affected.
SwitchPlan plan_of_failure(std::span<const ControllerView> chains) {
  SwitchRequest request;
  for (const ControllerView& view : chains) request.deactivate.push_back(view.name);
  return plan_switch(chains, request, [](const std::string&, bool) { return std::string{}; });
}
}  // namespace

std::unique_ptr<ControllerManager::Commit> ControllerManager::failure_commit_of(const std::vector<Slot*>& slots,
                                                                      std::span<const ControllerView> views,
                                                                      std::span<const ControllerView> chain,
                                                                      std::size_t who) const {
  if (!slots[who]->options.fallback.empty()) {
    SwitchRequest request;
    for (const ControllerView& view : chain) request.deactivate.push_back(view.name);
    request.activate = slots[who]->options.fallback;
    const SwitchPlan plan = plan_switch(views, request, [this](const std::string& interface, bool command) {
      return why_unavailable(interface, command);
    });
    if (plan.ok) return commit_of(plan);
  }  // otherwise its fallbacks cannot take over in the present state
  return commit_of(plan_of_failure(chain));
}

/// A component of the only group that these controllers command or, if they command none, read; -1 if there
/// is none or several.
int ControllerManager::home_of(std::span<const ControllerView> chain) const {
  int home = -1;
  for (const bool commands : {true, false}) {
    for (const ControllerView& view : chain)
      for (const std::string& claim : commands ? view.commands : view.states) {
        const auto index = commands ? table_.find_command(claim) : table_.find_state(claim);
        const int component = !index     ? -1
                              : commands ? hardware_.component_of_command(*index)
                                         : hardware_.component_of_state(*index);
        if (component < 0) continue;  // offered by another controller
        if (home < 0) home = component;
        const std::string& group = hardware_.group(static_cast<std::size_t>(home));
        if (component != home &&
            (group.empty() || hardware_.group(static_cast<std::size_t>(component)) != group))
          return -1;
      }
    if (home >= 0) break;
  }
  return home;
}

/// True if the controller commands a component that does not fail together with this one.
bool ControllerManager::commands_beyond(const ControllerView& view, std::size_t component) const {
  return std::any_of(view.commands.begin(), view.commands.end(), [&](const std::string& claim) {
    const auto index = table_.find_command(claim);
    const int other = index ? hardware_.component_of_command(*index) : -1;
    if (other < 0 || other == static_cast<int>(component)) return false;
    const std::string& group = hardware_.group(component);
    return group.empty() || hardware_.group(static_cast<std::size_t>(other)) != group;
  });
}

std::set<std::size_t> ControllerManager::components_of(const ControllerView& view) const {
  std::set<std::size_t> out;
  const auto add = [&](int component) {
    if (component >= 0) out.insert(static_cast<std::size_t>(component));
  };
  for (const std::string& claim : view.commands)
    if (const auto index = table_.find_command(claim)) add(hardware_.component_of_command(*index));
  for (const std::string& read : view.states)
    if (const auto index = table_.find_state(read)) add(hardware_.component_of_state(*index));
  return out;
}

std::unique_ptr<ControllerManager::Schedule> ControllerManager::make_schedule(
    const std::vector<std::string>& names) const {
  std::vector<Slot*> slots;
  std::vector<ControllerView> all;
  for (const auto& s : slots_)
    if (s->state.load() == LifecycleState::inactive || s->state.load() == LifecycleState::active) {
      slots.push_back(s.get());
      all.push_back(view(*s));
    }
  std::vector<bool> active(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    active[i] = std::find(names.begin(), names.end(), slots[i]->name) != names.end();
    all[i].state = active[i] ? LifecycleState::active : LifecycleState::inactive;
  }
  auto out = std::make_unique<Schedule>();
  std::vector<std::set<std::size_t>> falling(hardware_.size());  // controllers that stop if a component fails
  for (const std::size_t i : update_order(all)) {
    const std::vector<std::size_t> linked = chain_of(all, i, active);
    const std::vector<ControllerView> chain = some_of(all, linked);
    out->entries.push_back({slots[i], slots[i]->controller.get(), slots[i]->options.divisor,
                            slots[i]->options.period, active[i] ? failure_commit_of(slots, all, chain, i) : nullptr,
                            active[i] ? home_of(chain) : -1});
    if (!active[i]) continue;
    for (const std::size_t component : components_of(all[i]))
      falling[component].insert(linked.begin(), linked.end());
  }
  std::vector<char> tied;
  for (std::size_t c = 0; c < hardware_.size(); ++c) {
    const std::vector<std::size_t> falls(falling[c].begin(), falling[c].end());
    tied.push_back(
        std::any_of(falls.begin(), falls.end(), [&](std::size_t i) { return commands_beyond(all[i], c); }));
    out->component_failures.push_back(commit_of(plan_of_failure(some_of(all, falls))));
  }
  out->contained = contained_components(tied);
  return out;
}

/// The components whose faults affect their group only. `tied`: a controller that stops with the component
/// also commands components outside its group.
std::vector<char> ControllerManager::contained_components(std::span<const char> tied) const {
  std::set<std::string> tied_groups;
  for (std::size_t c = 0; c < tied.size(); ++c)
    if (tied[c] && !hardware_.group(c).empty()) tied_groups.insert(hardware_.group(c));
  std::vector<char> out;
  for (std::size_t c = 0; c < tied.size(); ++c)
    out.push_back(hardware_.contained(c) && !tied[c] && !tied_groups.contains(hardware_.group(c)));
  return out;
}

}  // namespace polyarm::control
