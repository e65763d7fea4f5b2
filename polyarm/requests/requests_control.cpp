/// Requests about controllers.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/operation/point_edits.hpp"
#include "polyarm/plugins/types.hpp"
#include "polyarm/protocol/controllers.hpp"
#include "polyarm/requests/controller_switch.hpp"
#include "polyarm/requests/families.hpp"
#include "polyarm/setup/controllers_start.hpp"

namespace polyarm::cell {

using hardware::LifecycleState;

namespace {

using namespace protocol;

/// The parts of the cell that requests about controllers need.
struct ControllerOwners {
  Machine& machine;
  const CellSetup& setup;
  CellInside& inside;
};

control::Strictness strictness_of(Strictness word) {
  switch (word) {
    case Strictness::strict:
      return control::Strictness::strict;
    case Strictness::best_effort:
    case Strictness::best_effort_ros:
      return control::Strictness::best_effort;
    case Strictness::automatic:
      return control::Strictness::automatic;
    case Strictness::force:
    case Strictness::force_ros:
      return control::Strictness::force;
  }
  return control::Strictness::strict;
}

/// The request's strictness; otherwise that of the controllers' file.
control::Strictness strictness_of(const ControllerOwners& cell, const ControlSwitch& request) {
  if (request.strictness) return strictness_of(*request.strictness);
  const std::string& stated = cell.setup.manager.strictness;
  const auto& words = Words<Strictness>::kWords;
  const auto at = std::find(std::begin(words), std::end(words), lower(stated));
  if (at == std::end(words)) return control::Strictness::strict;
  return strictness_of(static_cast<Strictness>(at - std::begin(words)));
}

/// Flattens {gains: {joint_1: {p: 3}}} to "gains.joint_1.p": 3, as in controllers' files.
void flatten(const nlohmann::json& map, const std::string& prefix, controllers::Parameters& out) {
  const auto text = [](const nlohmann::json& item) {
    return item.is_string() ? item.get<std::string>() : item.dump();
  };
  for (const auto& [key, value] : map.items()) {
    if (value.is_object()) {
      flatten(value, prefix + key + ".", out);
      continue;
    }
    controllers::Parameters::Entry entry;
    entry.list = value.is_array();
    if (entry.list)
      for (const nlohmann::json& item : value) entry.values.push_back(text(item));
    else
      entry.values.push_back(text(value));
    out.entries[prefix + key] = std::move(entry);
  }
}

/// The messages that a controller accepts, with their ROS types.
std::vector<ControllerInput> inputs_of(const ControllerOwners& cell, const std::string& name) {
  std::vector<ControllerInput> out;
  if (const controllers::Controller* controller = cell.machine.controllers().find(name))
    for (const controllers::InputPort& port : controller->inputs()) out.push_back({port.name, port.types});
  return out;
}
}  // namespace

LifecycleState controller_state(const Machine& machine, const std::string& name) {
  for (const control::ListedController& c : machine.controllers().list())
    if (c.name == name) return c.state;
  throw Error("unknown-controller",
              "there is no controller '" + name + "'" + did_you_mean(name, machine.controllers().names()),
              "there are: " + join(machine.controllers().names(), ", "));
}

namespace {

ControlList::Answer control_list(const ControllerOwners& cell, const ControlList&) {
  ControlList::Answer out;
  for (const control::ListedController& c : cell.machine.controllers().list())
    out.push_back({.name = c.name,
                   .type = c.type,
                   .state = hardware::name(c.state),
                   .chained = c.chained,
                   .async = c.async,
                   .stale = c.stale,
                   .rate = rate_of(cell.machine, c),
                   .updates = c.updates,
                   .missed = c.missed,
                   .claimed = c.claimed,
                   .commands = c.required_commands,
                   .states = c.required_states,
                   .references = c.references,
                   .exported_states = c.exported,
                   .fallback = c.fallback,
                   .inputs = inputs_of(cell, c.name)});
  return out;
}

ControlTypes::Answer control_types(const ControllerOwners&, const ControlTypes&) {
  ControlTypes::Answer out;
  for (const controllers::ControllerType& type : controllers::controller_types())
    out.push_back({type.name, type.summary});
  return out;
}

ControlChains::Answer control_chains(const ControllerOwners& cell, const ControlChains&) {
  ControlChains::Answer out;
  const auto all = cell.machine.controllers().list();
  for (const auto& upper : all)
    for (const auto& below : all)
      for (const std::string& reference : below.references)
        if (std::find(upper.required_commands.begin(), upper.required_commands.end(), reference) !=
            upper.required_commands.end())
          out.push_back({upper.name, below.name, reference, upper.state == LifecycleState::active});
  return out;
}

SwitchOutcome outcome_of(const control::SwitchPlan& plan) {
  return {plan.ok, plan.reason, plan.advice, plan.start, plan.stop, plan.left_out, plan.chained, plan.unchained};
}

Poll<SwitchOutcome> control_switch(const ControllerOwners& cell, const ControlSwitch& request) {
  control::SwitchRequest wanted{request.activate.value_or(Names{}), request.deactivate.value_or(Names{}),
                                strictness_of(cell, request)};
  if (wanted.activate.empty() && wanted.deactivate.empty())
    throw Error("bad-argument", "there is nothing to activate or deactivate");
  if (request.dry) return at_once(outcome_of(cell.machine.controllers().plan(wanted)));
  return then(switch_controllers(cell.machine, std::move(wanted)),
              [](const control::SwitchPlan& plan) { return at_once(outcome_of(plan)); });
}

/// A warning if `name` drives a base that the cell moves by no controller: it takes those that are there when
/// it starts, for example not one that was unloaded and loaded again. Empty if not.
std::string base_without_motion(const ControllerOwners& cell, const std::string& name) {
  const control::ControllerManager& manager = cell.machine.controllers();
  for (std::size_t r = 0; r < cell.setup.robots.size(); ++r) {
    const controllers::BaseController* const wheels = base_controller_of(*cell.setup.robots[r], manager);
    if (!wheels || wheels != manager.find(name) || cell.inside.motions->wheels(r)) continue;
    return "'" + name + "' drives the base of '" + cell.setup.robots[r]->entry.name +
           "', but was not there when the cell started: guards do not watch this base, and 'drive' does not "
           "use "
           "it; restart the cell";
  }
  return {};
}

ControlLoad::Answer control_load(const ControllerOwners& cell, const ControlLoad& request) {
  require_short_name(request.name);
  if (const std::size_t loaded = cell.machine.controllers().list().size();
      loaded >= bounds::kLoadedControllers)
    throw Error("too-many", "the cell has " + std::to_string(loaded) + " controllers already",
                "unload one first: control.unload");
  controllers::Parameters parameters;
  for (const auto& [key, value] : request.parameters.value_or(Map{}))
    flatten({{key, value.json()}}, "", parameters);
  const Problems problems = cell.machine.load_controller(request.name, request.type.value_or(""),
                                                         std::move(parameters), request.file.value_or(""));
  ControlLoad::Answer out{request.name, hardware::name(controller_state(cell.machine, request.name)), {}};
  const auto is_late = [](const Problem& problem) { return problem.code == "late-wheels"; };
  for (const Problem& problem : problems.list()) out.warnings.push_back(problem.text());
  if (std::none_of(problems.list().begin(), problems.list().end(), is_late))
    if (std::string text = base_without_motion(cell, request.name); !text.empty())
      out.warnings.push_back("warning: " + text);
  return out;
}

NameAndState control_configure(const ControllerOwners& cell, const ControlConfigure& request) {
  cell.machine.controllers().configure(request.name);
  return {request.name, hardware::name(controller_state(cell.machine, request.name))};
}

NameAndState control_cleanup(const ControllerOwners& cell, const ControlCleanup& request) {
  cell.machine.controllers().cleanup(request.name);
  return {request.name, hardware::name(controller_state(cell.machine, request.name))};
}

JustName control_unload(const ControllerOwners& cell, const ControlUnload& request) {
  cell.inside.unload_controller(request.name);
  return {request.name};
}

Poll<ControlState::Answer> control_state(const ControllerOwners& cell, const ControlState& request) {
  const std::string name = request.name;
  const LifecycleState wanted = state_named(request.state);
  control::ControllerManager& manager = cell.machine.controllers();
  const LifecycleState now = controller_state(cell.machine, name);
  ControlState::Answer answer{name, hardware::name(wanted), {}};
  if (now == wanted) return at_once(answer);
  if (wanted == LifecycleState::finalized)
    throw Error("bad-argument", "a controller cannot be finalized by a request", "unload it");
  const auto with_outcome = [answer](const control::SwitchPlan& plan) {
    ControlState::Answer out = answer;
    out.outcome.emplace(outcome_of(plan));
    return at_once(out);
  };
  if (now == LifecycleState::active) {
    Poll<control::SwitchPlan> stopped = switch_controllers(cell.machine, {{}, {name}});
    if (wanted == LifecycleState::inactive) return then(std::move(stopped), with_outcome);
    return then(std::move(stopped), [&manager, name, answer](const control::SwitchPlan&) {
      manager.cleanup(name);
      return at_once(answer);
    });
  }
  if (wanted == LifecycleState::unconfigured) {
    manager.cleanup(name);
    return at_once(answer);
  }
  if (now == LifecycleState::unconfigured) manager.configure(name);
  if (wanted == LifecycleState::inactive) return at_once(answer);
  return then(switch_controllers(cell.machine, {{name}, {}}), with_outcome);
}

}  // namespace

std::vector<Handler> controller_handlers() {
  return handlers<control_list, control_types, control_chains, control_switch, control_load, control_configure,
                  control_cleanup, control_unload, control_state>();
}

}  // namespace polyarm::cell
