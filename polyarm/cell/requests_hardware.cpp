/// Requests about hardware components, and arming.
#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

using hardware::LifecycleState;

namespace {

std::size_t component_argument(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  hardware::Hardware& hardware = cell.loop().hardware();
  std::vector<std::string> known;
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    for (std::string& own : names_of_component(cell.robots(), hardware.component_name(i))) {
      if (own == name) return i;
      known.push_back(std::move(own));
    }
  }
  throw Error("unknown-component",
              "there is no hardware component '" + name + "'" + did_you_mean(name, known));
}

/// Active controllers that command a component; with `readers_too`, those that read it as well.
std::vector<std::string> users_of(Cell& cell, std::size_t component, bool readers_too) {
  const hardware::HostedInfo info = cell.loop().hardware().diagnostics().info(component);
  const auto uses = [](const std::vector<std::string>& wanted, const std::vector<std::string>& offered) {
    return std::any_of(wanted.begin(), wanted.end(), [&](const std::string& name) {
      return std::find(offered.begin(), offered.end(), name) != offered.end();
    });
  };
  std::vector<std::string> out;
  for (const control::ListedController& c : cell.loop().controllers().list())
    if (c.state == LifecycleState::active &&
        (uses(c.required_commands, info.commands) || (readers_too && uses(c.required_states, info.states))))
      out.push_back(c.name);
  return out;
}

Poll wait_for(std::shared_ptr<realtime::Job> job) {
  return [job](Cell&) { return job->done() ? Progress::done(nullptr) : Progress{}; };
}

/// A callback of the component, on a thread of its own where the cell has one.
Poll follow(Cell& cell, std::shared_ptr<hardware::Transition> transition) {
  cell.hardware_calls().start(transition);
  return [transition](Cell& c) mutable {
    return c.hardware_calls().advance(c.loop().hardware(), transition, c.now()) ? Progress::done(nullptr)
                                                                                : Progress{};
  };
}
Poll follow(Cell& cell, std::size_t i, hardware::Step step) {
  return follow(cell, cell.loop().hardware().begin(i, step));
}

/// Waits a little for a callback that somebody else has asked for; then what follows is refused.
Poll wait_until_idle(Cell& cell, std::size_t i) {
  constexpr Nanoseconds kPatience = 1'000'000'000;
  return [i, until = cell.now() + kPatience](Cell& c) {
    return !c.loop().hardware().pending(i) || c.now() > until ? Progress::done(nullptr) : Progress{};
  };
}

/// One transition after the other until the component is where it shall be.
Poll walk(Cell& cell, std::size_t i, LifecycleState wanted, Json answer) {
  using hardware::Step;
  hardware::Hardware& hardware = cell.loop().hardware();
  const LifecycleState now = hardware.state_of(i);
  answer["state"] = hardware::name(now);
  if (now == wanted) return at_once(std::move(answer));
  const auto on = [i, wanted, answer](Cell& c) { return walk(c, i, wanted, answer); };
  const auto called = [i, on](Step step) {
    return [i, on, step](Cell& c) { return then(follow(c, i, step), on); };
  };
  if (now == LifecycleState::finalized)
    throw Error("finalized", "the component is finalized and comes back only by a reload",
                "polyarm hardware reload NAME");
  if (wanted == LifecycleState::finalized)
    return then(wait_for(hardware.begin_cleanup(i)), called(Step::shutdown));
  if (now == LifecycleState::active)
    return then(wait_for(hardware.begin_deactivate(i)), called(Step::deactivate));
  if (now == LifecycleState::inactive && wanted == LifecycleState::unconfigured)
    return then(wait_for(hardware.begin_cleanup(i)), called(Step::cleanup));
  return called(now == LifecycleState::unconfigured ? Step::configure : Step::activate)(cell);
}

}  // namespace

Poll take_to(Cell& cell, std::size_t i, LifecycleState wanted) {
  cell.loop().hardware().require_idle(i);
  const LifecycleState now = cell.loop().hardware().state_of(i);
  const bool goes_down = wanted == LifecycleState::finalized || wanted < now;
  // An inactive component is still read.
  const std::vector<std::string> users =
      goes_down ? users_of(cell, i, wanted != LifecycleState::inactive) : std::vector<std::string>{};
  Json answer{{"name", cell.loop().hardware().component_name(i)}, {"stopped", Json::array()}};
  if (users.empty()) return walk(cell, i, wanted, std::move(answer));
  const control::SwitchRequest stop{{}, users, control::Strictness::automatic};
  answer["stopped"] = cell.loop().controllers().plan(stop).stop;  // with those that work through them
  return then(switch_controllers(cell, stop, Json::object()),
              [i, wanted, answer](Cell& c) { return walk(c, i, wanted, answer); });
}

namespace {

/// Of the interfaces of physics, those of the joints of one <ros2_control>.
std::vector<std::string> of_block(const Cell& cell, const std::string& name,
                                  const std::vector<std::string>& interfaces) {
  std::vector<std::string> out;
  for (const std::string& interface : interfaces)
    for (const PlayedBlock& played : played_by_physics(cell.robots())) {
      if (played.info->name != name) continue;
      const std::vector<description::ComponentInfo>& parts = played.info->components;
      if (std::any_of(parts.begin(), parts.end(), [&](const description::ComponentInfo& part) {
            return interface.starts_with(played.robot->entry.name + "/" + part.name + "/");
          }))
        out.push_back(interface);
    }
  return out;
}

const description::HardwareInfo* block_called(const Cell& cell, const std::string& name) {
  for (const PlayedBlock& played : played_by_physics(cell.robots()))
    if (played.info->name == name) return played.info;
  return nullptr;
}

Json listed(Cell& cell, const hardware::HostedInfo& info, const hardware::Transition* pending) {
  Json commands = Json::array();
  for (const std::string& command : info.commands)
    commands.push_back({{"name", command}, {"claimed_by", cell.loop().controllers().holder_of(command)}});
  return {{"name", info.name},
          {"type", info.type},
          {"plugin", info.plugin},
          {"group", info.group},
          {"state", hardware::name(info.state)},
          {"being", pending ? hardware::done_word(pending->step()) : ""},
          {"rate", rate_of(cell, info)},
          {"async", info.async},
          {"missed", info.missed},
          {"states", info.states},
          {"commands", commands}};
}

/// What physics plays is listed by the names of its descriptions, each with its own interfaces; the rest of
/// them (tools, the scene) stand with the first.
Poll hardware_list(Cell& cell, const Json&) {
  Json out = Json::array();
  hardware::Hardware& hardware = cell.loop().hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    hardware::HostedInfo info = hardware.diagnostics().info(i);
    const std::vector<std::string> names = names_of_component(cell.robots(), info.name);
    Json others = Json::array();
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
    for (Json& other : others) out.push_back(std::move(other));
  }
  return at_once(std::move(out));
}

/// After the reload: back to where the component was.
Poll put_anew(Cell& cell, const Remaking& remade, std::size_t i, LifecycleState wanted, Json answer) {
  answer["warnings"] = Json::array();
  const auto transition = cell.begin_reload(remade);
  for (const Problem& warning : remade.made.warnings.list()) answer["warnings"].push_back(warning.text());
  return then(follow(cell, transition), [i, wanted, answer](Cell& c) mutable {
    c.look_for_real_hardware();
    const bool waits = wanted == LifecycleState::active && !c.arming().may_be_enabled(i);
    answer["next"] = waits ? "it is real hardware: polyarm control arm"
                           : "start its controllers: polyarm control switch --start NAME";
    return walk(c, i, waits ? LifecycleState::inactive : wanted, std::move(answer));
  });
}

/// The files are read elsewhere: a disk that takes its time does not keep the cell thread.
Poll make_anew(Cell& cell, std::size_t i, LifecycleState wanted, Json answer) {
  const auto remaking = cell.remake(answer["name"]);
  const Poll read = [remaking](Cell&) { return remaking->done ? Progress::done(nullptr) : Progress{}; };
  return then(read,
              [i, wanted, answer, remaking](Cell& c) { return put_anew(c, *remaking, i, wanted, answer); });
}

Poll hardware_state(Cell& cell, const Json& arguments) {
  const std::size_t i = component_argument(cell, arguments);
  const LifecycleState wanted = state_argument(arguments);
  if (wanted == LifecycleState::active) cell.arming().require_armed(i);
  const std::string asked = text_argument(arguments, "name");
  return then(wait_until_idle(cell, i), [i, wanted, asked](Cell& c) {
    return then_with(take_to(c, i, wanted), [asked](Cell& cell, Json answer) {
      const std::vector<std::string> names =
          names_of_component(cell.robots(), answer["name"].get<std::string>());
      answer["name"] = asked;
      for (const std::string& other : names)
        if (other != asked) answer["with"].push_back(other);
      return at_once(std::move(answer));
    });
  });
}

Poll reload(Cell& cell, std::size_t i) {
  cell.loop().hardware().require_idle(i);
  const LifecycleState was = cell.loop().hardware().state_of(i);
  if (was == LifecycleState::unconfigured || was == LifecycleState::finalized)
    return make_anew(cell, i, LifecycleState::unconfigured,
                     {{"name", cell.loop().hardware().component_name(i)}, {"stopped", Json::array()}});
  return then_with(take_to(cell, i, LifecycleState::unconfigured),
                   [i, was](Cell& c, Json answer) { return make_anew(c, i, was, std::move(answer)); });
}

Poll hardware_reload(Cell& cell, const Json& arguments) {
  const std::size_t i = component_argument(cell, arguments);
  return then(wait_until_idle(cell, i), [i](Cell& c) { return reload(c, i); });
}

Poll hardware_recover(Cell& cell, const Json& arguments) {
  const std::size_t i = component_argument(cell, arguments);
  cell.arming().require_armed(i);
  cell.tell_loop_events();
  const std::string name = cell.loop().hardware().component_name(i);
  const Json answer{{"name", name},
                    {"fallen", cell.take_fallen(name)},
                    {"next", cell.snapshot().state == control::RunState::fault
                                 ? "control recover, then start its controllers and resume"
                                 : "start its controllers"}};
  return then(wait_until_idle(cell, i),
              [i, answer](Cell& c) { return walk(c, i, LifecycleState::active, answer); });
}

/// The components one after the other, then the controllers, then the programs may begin.
Poll arm_from(Cell& cell, std::size_t next) {
  const std::vector<std::size_t>& real = cell.arming().components();
  if (next < real.size())
    return then(walk(cell, real[next], LifecycleState::active, Json::object()),
                [next](Cell& c) { return arm_from(c, next + 1); });
  std::vector<std::string> idle;
  for (const std::string& name : cell.chosen_controllers())  // one may have been unloaded since
    if (cell.loop().controllers().find(name) && controller_state(cell, name) == LifecycleState::inactive)
      idle.push_back(name);
  const auto finish = [](Cell& c, const Json& switched) {
    for (const Json& reason : switched.value("left_out", Json::array()))
      c.tell(reason.get<std::string>() + "; it stays inactive");
    c.set_armed();
    return at_once({{"armed", true}, {"started", switched.value("start", Json::array())}});
  };
  if (idle.empty()) return finish(cell, Json::object());
  return then_with(switch_controllers(cell, {idle, {}, control::Strictness::best_effort}, Json::object()),
                   finish);
}

Poll control_arm(Cell& cell, const Json& arguments) {
  Json seen = Json::array();
  for (const Arming::Expected& joint : cell.arming().expected_positions(cell.snapshot().states))
    seen.push_back({{"joint", joint.joint},
                    {"measured", finite_or_null(joint.measured)},
                    {"expected", finite_or_null(joint.expected)}});
  if (!cell.arming().needed())
    throw Error("not-real", "nothing in this cell is real hardware that could be armed",
                "polyarm run --real drives what the cell declares as real");
  if (!flag_argument(arguments, "confirmed"))
    return at_once({{"armed", cell.arming().armed()}, {"joints", seen}});
  if (cell.arming().armed()) return at_once({{"armed", true}, {"started", Json::array()}});
  cell.arming().require_verified();
  const control::RunState state = cell.snapshot().state;
  if (state != control::RunState::running && state != control::RunState::held)
    throw Error("wrong-state", std::string("the loop is at ") + control::name(state),
                "polyarm control recover, then arm");
  return arm_from(cell, 0);
}

}  // namespace

const std::vector<RequestRow>& hardware_rows() {
  static const std::vector<RequestRow> table = {
      {{"control.arm",
        {{"confirmed", kFlag}},
        "{armed, joints: [{joint, measured, expected}], started}",
        "without 'confirmed': where real joints are measured and expected; with it: a person at a terminal "
        "has "
        "compared them, the hardware is activated and its controllers start",
        true},
       control_arm},
      {{"hardware.list",
        {},
        "[{name, type, plugin, group, state, being, rate, async, missed, states, commands: [{name, "
        "claimed_by}]}]",
        "the hardware components, their states and interfaces",
        false},
       hardware_list},
      {{"hardware.state",
        {{"name", kText, true}, {"state", kText, true}},
        "{name, state, stopped, with}",
        "take a component to unconfigured, inactive, active or finalized; controllers that use it are "
        "stopped first, with their chains; `with` names the components that are one with it in physics",
        true},
       hardware_state},
      {{"hardware.recover", kName, "{name, state, fallen, next}",
        "bring a component back that has failed; the controllers that fell with it are named, not started",
        true},
       hardware_recover},
      {{"hardware.reload", kName, "{name, state, stopped, warnings, next}",
        "make a component anew from its description as it is now, with the same interfaces; controllers that "
        "use it are stopped and not started again",
        true},
       hardware_reload},
  };
  return table;
}

}  // namespace polyarm::cell
