/// Requests about hardware components, and arming.
#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/protocol/hardware.hpp"
#include "polyarm/requests/component_states.hpp"
#include "polyarm/requests/controller_switch.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

using hardware::LifecycleState;

namespace {

using namespace protocol;

/// The parts of the cell that requests about hardware need.
struct HardwareOwners {
  const CellSetup& setup;
  Machine& machine;
  Arming& arming;
  Worker& worker;
  Observer& events;
  CellInside& inside;
};

std::size_t component_named(const HardwareOwners& cell, const std::string& name) {
  hardware::Hardware& hardware = cell.machine.hardware();
  std::vector<std::string> known;
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    for (std::string& own : names_of_component(cell.setup.robots, hardware.component_name(i))) {
      if (own == name) return i;
      known.push_back(std::move(own));
    }
  }
  throw Error("unknown-component",
              "there is no hardware component '" + name + "'" + did_you_mean(name, known));
}

/// Active controllers that command a component; with `readers_too` also those that read it.
std::vector<std::string> users_of(const Machine& machine, std::size_t component, bool readers_too) {
  const hardware::HostedInfo info = machine.hardware().diagnostics().info(component);
  const auto uses = [](const std::vector<std::string>& wanted, const std::vector<std::string>& offered) {
    return std::any_of(wanted.begin(), wanted.end(), [&](const std::string& name) {
      return std::find(offered.begin(), offered.end(), name) != offered.end();
    });
  };
  std::vector<std::string> out;
  for (const control::ListedController& c : machine.controllers().list())
    if (c.state == LifecycleState::active &&
        (uses(c.required_commands, info.commands) || (readers_too && uses(c.required_states, info.states))))
      out.push_back(c.name);
  return out;
}

Poll<Done> wait_for(std::shared_ptr<realtime::Job> job) {
  return [job] { return job->done() ? Progress<Done>::done({}) : Progress<Done>{}; };
}

/// Runs a callback of the component, on a thread of its own where the cell has one, and waits for it.
Poll<Done> follow(Machine& machine, std::shared_ptr<hardware::Transition> transition) {
  machine.calls().begin(transition);
  return [&machine, transition]() mutable {
    const bool over = machine.calls().advance(machine.hardware(), transition, machine.now());
    return over ? Progress<Done>::done({}) : Progress<Done>{};
  };
}
Poll<Done> follow(Machine& machine, std::size_t i, hardware::Step step) {
  return follow(machine, machine.hardware().begin(i, step));
}

/// Waits up to 1 s for a callback that another client started; after that the next step is refused.
Poll<Done> wait_until_idle(Machine& machine, std::size_t i) {
  constexpr Nanoseconds kTimeout = 1'000'000'000;
  return [&machine, i, until = machine.now() + kTimeout] {
    const bool over = !machine.hardware().pending(i) || machine.now() > until;
    return over ? Progress<Done>::done({}) : Progress<Done>{};
  };
}

/// Performs one transition after the other until the component is in the wanted state.
Poll<Done> walk(Machine& machine, std::size_t i, LifecycleState wanted) {
  using hardware::Step;
  hardware::Hardware& hardware = machine.hardware();
  const LifecycleState now = hardware.state_of(i);
  if (now == wanted) return at_once(Done{});
  const auto on = [&machine, i, wanted](Done) { return walk(machine, i, wanted); };
  const auto called = [&machine, i, on](Step step) {
    return [&machine, i, on, step](Done) { return then(follow(machine, i, step), on); };
  };
  if (now == LifecycleState::finalized)
    throw Error("finalized", "the component is finalized; only a reload brings it back",
                "polyarm hardware reload NAME");
  if (wanted == LifecycleState::finalized)
    return then(wait_for(hardware.begin_cleanup(i)), called(Step::shutdown));
  if (now == LifecycleState::active)
    return then(wait_for(hardware.begin_deactivate(i)), called(Step::deactivate));
  if (now == LifecycleState::inactive && wanted == LifecycleState::unconfigured)
    return then(wait_for(hardware.begin_cleanup(i)), called(Step::cleanup));
  return called(now == LifecycleState::unconfigured ? Step::configure : Step::activate)(Done{});
}

/// The same; answers with the state that the component has then. Once it is active, the controllers that
/// stopped with it are forgotten: whoever wants them has taken them before.
Poll<Taken> walk(Machine& machine, std::size_t i, LifecycleState wanted, std::vector<std::string> stopped) {
  return then(walk(machine, i, wanted), [&machine, i, stopped](Done) {
    const hardware::Hardware& hardware = machine.hardware();
    if (hardware.state_of(i) == LifecycleState::active) machine.take_failed(hardware.component_name(i));
    return at_once(Taken{hardware.component_name(i), hardware::name(hardware.state_of(i)), stopped});
  });
}

}  // namespace

Poll<Taken> take_to(Machine& machine, std::size_t i, LifecycleState wanted) {
  machine.hardware().require_idle(i);
  const LifecycleState now = machine.hardware().state_of(i);
  const bool goes_down = wanted == LifecycleState::finalized || wanted < now;
  // Controllers may still read an inactive component.
  const std::vector<std::string> users =
      goes_down ? users_of(machine, i, wanted != LifecycleState::inactive) : std::vector<std::string>{};
  if (users.empty()) return walk(machine, i, wanted, {});
  const control::SwitchRequest stop{{}, users, control::Strictness::automatic};
  const std::vector<std::string> stopped =
      machine.controllers().plan(stop).stop;  // includes the controllers that work through them
  return then(switch_controllers(machine, stop), [&machine, i, wanted, stopped](const control::SwitchPlan&) {
    return walk(machine, i, wanted, stopped);
  });
}

namespace {

/// Selects the interfaces of physics that belong to the joints of one <ros2_control>.
std::vector<std::string> of_block(const HardwareOwners& cell, const std::string& name,
                                  const std::vector<std::string>& interfaces) {
  std::vector<std::string> out;
  for (const std::string& interface : interfaces)
    for (const PlayedBlock& played : played_by_physics(cell.setup.robots)) {
      if (played.info->name != name) continue;
      const std::vector<description::ComponentInfo>& parts = played.info->components;
      if (std::any_of(parts.begin(), parts.end(), [&](const description::ComponentInfo& part) {
            return interface.starts_with(played.robot->entry.name + "/" + part.name + "/");
          }))
        out.push_back(interface);
    }
  return out;
}

const description::HardwareInfo* block_called(const HardwareOwners& cell, const std::string& name) {
  for (const PlayedBlock& played : played_by_physics(cell.setup.robots))
    if (played.info->name == name) return played.info;
  return nullptr;
}

ListedHardware listed(const HardwareOwners& cell, const hardware::HostedInfo& info,
                      const hardware::Transition* pending) {
  ListedHardware out{.name = info.name,
                     .type = info.type,
                     .plugin = info.plugin,
                     .group = info.group,
                     .state = hardware::name(info.state),
                     .being = pending ? hardware::done_word(pending->step()) : "",
                     .rate = rate_of(cell.machine, info),
                     .async = info.async,
                     .missed = info.missed,
                     .states = info.states,
                     .commands = {}};
  for (const std::string& command : info.commands)
    out.commands.push_back({command, cell.machine.controllers().holder_of(command)});
  return out;
}

/// Hardware simulated by physics is listed under the names of its descriptions, each with its own interfaces;
/// other interfaces (tools, the scene) are listed with the first.
HardwareList::Answer hardware_list(const HardwareOwners& cell, const HardwareList&) {
  HardwareList::Answer out;
  hardware::Hardware& hardware = cell.machine.hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    hardware::HostedInfo info = hardware.diagnostics().info(i);
    const std::vector<std::string> names = names_of_component(cell.setup.robots, info.name);
    std::vector<ListedHardware> others;
    for (std::size_t k = names.size(); k-- > 1;) {
      hardware::HostedInfo part = info;
      const description::HardwareInfo* block = block_called(cell, names[k]);
      part.name = names[k];
      if (block) part.plugin = block->plugin, part.type = block->type;
      part.states = of_block(cell, names[k], info.states);
      part.commands = of_block(cell, names[k], info.commands);
      for (const std::string& state : part.states) std::erase(info.states, state);
      for (const std::string& command : part.commands) std::erase(info.commands, command);
      others.insert(others.begin(), listed(cell, part, hardware.pending(i)));
    }
    if (const description::HardwareInfo* first = names.size() > 1 ? block_called(cell, info.name) : nullptr)
      info.plugin = first->plugin, info.type = first->type;
    out.push_back(listed(cell, info, hardware.pending(i)));
    out.insert(out.end(), others.begin(), others.end());
  }
  return out;
}

/// After the reload: returns the component to its previous state.
Poll<HardwareReload::Answer> begin_again(const HardwareOwners& cell, const Remaking& remade, std::size_t i,
                                         LifecycleState wanted, const std::vector<std::string>& stopped) {
  const auto transition = cell.machine.begin_reload(remade);
  HardwareReload::Answer answer;
  answer.stopped = stopped;
  for (const Problem& warning : remade.made.warnings.list()) answer.warnings.push_back(warning.text());
  return then(follow(cell.machine, transition), [cell, i, wanted, answer](Done) mutable {
    cell.arming.look_again();
    const bool waits = wanted == LifecycleState::active && !cell.arming.may_be_enabled(i);
    answer.next = waits ? "it is real hardware: polyarm control arm"
                        : "start its controllers: polyarm control switch -a NAME";
    return then(walk(cell.machine, i, waits ? LifecycleState::inactive : wanted, answer.stopped),
                [answer](const Taken& taken) mutable {
                  answer.name = taken.name;
                  answer.state = taken.state;
                  return at_once(answer);
                });
  });
}

/// Reads the files on another thread, so a slow disk does not block the cell thread.
Poll<HardwareReload::Answer> make_again(const HardwareOwners& cell, std::size_t i, LifecycleState wanted,
                                        const std::vector<std::string>& stopped) {
  const auto remaking = cell.machine.remake(cell.machine.hardware().component_name(i), cell.worker);
  const Poll<Done> read = [remaking] { return remaking->done ? Progress<Done>::done({}) : Progress<Done>{}; };
  return then(read, [cell, i, wanted, stopped, remaking](Done) {
    return begin_again(cell, *remaking, i, wanted, stopped);
  });
}

Poll<HardwareState::Answer> hardware_state(const HardwareOwners& cell, const HardwareState& request) {
  const std::size_t i = component_named(cell, request.name);
  const LifecycleState wanted = state_named(request.state);
  if (wanted == LifecycleState::active) cell.arming.require_armed(i);
  const std::string asked = request.name;
  return then(wait_until_idle(cell.machine, i), [cell, i, wanted, asked](Done) {
    return then(take_to(cell.machine, i, wanted), [cell, asked](const Taken& taken) {
      HardwareState::Answer answer{asked, taken.state, taken.stopped, {}};
      for (const std::string& other : names_of_component(cell.setup.robots, taken.name)) {
        if (other == asked) continue;
        if (!answer.with) answer.with.emplace();
        answer.with->push_back(other);
      }
      return at_once(answer);
    });
  });
}

Poll<HardwareReload::Answer> reload(const HardwareOwners& cell, std::size_t i) {
  cell.machine.hardware().require_idle(i);
  const LifecycleState was = cell.machine.hardware().state_of(i);
  if (was == LifecycleState::unconfigured || was == LifecycleState::finalized)
    return make_again(cell, i, LifecycleState::unconfigured, {});
  return then(take_to(cell.machine, i, LifecycleState::unconfigured),
              [cell, i, was](const Taken& taken) { return make_again(cell, i, was, taken.stopped); });
}

Poll<HardwareReload::Answer> hardware_reload(const HardwareOwners& cell, const HardwareReload& request) {
  const std::size_t i = component_named(cell, request.name);
  return then(wait_until_idle(cell.machine, i), [cell, i](Done) { return reload(cell, i); });
}

/// The controllers of the cell's beginning that are inactive now; some may have been unloaded since.
std::vector<std::string> idle_controllers(const Machine& machine) {
  std::vector<std::string> out;
  for (const std::string& name : machine.chosen_controllers)
    if (machine.controllers().find(name) && controller_state(machine, name) == LifecycleState::inactive)
      out.push_back(name);
  return out;
}

/// The components that hardware.recover brings back.
std::vector<std::size_t> to_recover(const HardwareOwners& cell, const HardwareRecover& request) {
  if (request.name) return {component_named(cell, *request.name)};
  std::vector<std::size_t> out;
  const hardware::Hardware& hardware = cell.machine.hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i)
    if (hardware.takes_commands(i) && hardware.state_of(i) != LifecycleState::active) out.push_back(i);
  return out;
}

/// Starts the controllers that stopped with the components. If nobody knows them any more, and the request
/// named no component, it starts those of the cell's beginning.
Poll<HardwareRecover::Answer> start_fallen(const HardwareOwners& cell, bool named,
                                           HardwareRecover::Answer answer) {
  std::vector<std::string> wanted;
  for (const std::string& name : answer.fallen)
    if (cell.machine.controllers().find(name) &&
        controller_state(cell.machine, name) == LifecycleState::inactive)
      wanted.push_back(name);
  if (answer.fallen.empty() && !named) wanted = idle_controllers(cell.machine);
  answer.started.emplace();
  if (wanted.empty()) return at_once(answer);
  return then(switch_controllers(cell.machine, {wanted, {}, control::Strictness::best_effort}),
              [cell, answer](const control::SwitchPlan& switched) mutable {
                for (const std::string& reason : switched.left_out)
                  cell.events.on_note(reason + "; it stays inactive");
                answer.started = switched.start;
                return at_once(answer);
              });
}

/// Brings back `components` from the one with the index `next` on.
Poll<HardwareRecover::Answer> recover_from(const HardwareOwners& cell, std::vector<std::size_t> components,
                                           std::size_t next, const HardwareRecover& request,
                                           HardwareRecover::Answer answer) {
  if (next == components.size())
    return request.controllers ? start_fallen(cell, request.name.has_value(), answer) : at_once(answer);
  const std::size_t i = components[next];
  const std::string name = cell.machine.hardware().component_name(i);
  const std::vector<std::string> fallen = cell.machine.take_failed(name);
  answer.name += (answer.name.empty() ? "" : ", ") + name;
  answer.fallen.insert(answer.fallen.end(), fallen.begin(), fallen.end());
  return then(wait_until_idle(cell.machine, i), [cell, components, next, request, answer, i](Done) {
    return then(walk(cell.machine, i, LifecycleState::active, {}),
                [cell, components, next, request, answer](const Taken& taken) mutable {
                  answer.state = taken.state;
                  return recover_from(cell, components, next + 1, request, answer);
                });
  });
}

Poll<HardwareRecover::Answer> hardware_recover(const HardwareOwners& cell, const HardwareRecover& request) {
  const std::vector<std::size_t> components = to_recover(cell, request);
  for (const std::size_t i : components) cell.arming.require_armed(i);
  cell.machine.report_events();
  const bool faults = cell.machine.snapshot().state == control::RunState::fault;
  const char* next = request.controllers ? (faults ? "control recover, then resume" : "")
                     : faults            ? "control recover, then start its controllers and resume"
                                         : "start its controllers";
  HardwareRecover::Answer answer;
  answer.next = next;
  if (components.empty()) answer.state = hardware::name(LifecycleState::active);
  return recover_from(cell, components, 0, request, answer);
}

Poll<ControlArm::Answer> start_armed(const HardwareOwners& cell) {
  const std::vector<std::string> idle = idle_controllers(cell.machine);
  const auto finish = [cell](const control::SwitchPlan& switched) {
    for (const std::string& reason : switched.left_out) cell.events.on_note(reason + "; it stays inactive");
    cell.inside.set_armed();
    return at_once(ControlArm::Answer{true, {}, switched.start});
  };
  if (idle.empty()) return finish({});
  return then(switch_controllers(cell.machine, {idle, {}, control::Strictness::best_effort}), finish);
}

/// Activates the components one after the other, then the controllers; after that programs may start.
Poll<ControlArm::Answer> arm_from(const HardwareOwners& cell, std::size_t next) {
  const std::vector<std::size_t>& real = cell.arming.components();
  if (next == real.size()) return start_armed(cell);
  return then(walk(cell.machine, real[next], LifecycleState::active, {}),
              [cell, next](const Taken&) { return arm_from(cell, next + 1); });
}

OrNull<double> finite_or_null(double value) {
  OrNull<double> out;
  if (std::isfinite(value)) out = value;
  return out;
}

Poll<ControlArm::Answer> control_arm(const HardwareOwners& cell, const ControlArm& request) {
  if (!cell.arming.needed())
    throw Error("not-real", "nothing in this cell is real hardware that could be armed",
                "polyarm run --real drives what the cell declares as real");
  if (!request.confirmed) {
    ControlArm::Answer answer{cell.arming.armed(), std::vector<ExpectedJoint>{}, {}};
    for (const Arming::Expected& joint : cell.arming.expected_positions(cell.machine.snapshot().states))
      answer.joints->push_back({joint.joint, finite_or_null(joint.measured), finite_or_null(joint.expected)});
    return at_once(answer);
  }
  if (cell.arming.armed()) return at_once(ControlArm::Answer{true, {}, std::vector<std::string>{}});
  cell.arming.require_verified();
  const control::RunState state = cell.machine.snapshot().state;
  if (state != control::RunState::running && state != control::RunState::held)
    throw Error("wrong-state", std::string("the control loop is in the state ") + control::name(state),
                "polyarm control recover, then arm");
  return arm_from(cell, 0);
}

}  // namespace

std::vector<Handler> hardware_handlers() {
  return handlers<control_arm, hardware_list, hardware_state, hardware_recover, hardware_reload>();
}

}  // namespace polyarm::cell
