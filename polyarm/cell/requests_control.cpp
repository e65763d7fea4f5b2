/// Requests about controllers, hardware, interfaces and the loop.
#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"
#include "polyarm/controllers/types.hpp"

namespace polyarm::cell {

using hardware::LifecycleState;

namespace {

Json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

Json json_of(const control::SwitchPlan& plan) {
  return {{"ok", plan.ok},           {"reason", plan.reason},      {"advice", plan.advice},
          {"start", plan.start},     {"stop", plan.stop},          {"left_out", plan.left_out},
          {"chained", plan.chained}, {"unchained", plan.unchained}};
}

control::Strictness strictness_of(const std::string& text) {
  using S = control::Strictness;
  const std::vector<std::pair<std::string, S>> known = {{"strict", S::strict},
                                                        {"best_effort", S::best_effort},
                                                        {"best-effort", S::best_effort},
                                                        {"auto", S::automatic},
                                                        {"force", S::force},
                                                        {"force_auto", S::force}};
  std::vector<std::string> names;
  for (const auto& [name, value] : known) {
    if (lower(text) == name) return value;
    names.push_back(name);
  }
  throw Error("bad-argument", "there is no strictness '" + text + "'" + did_you_mean(text, names),
              "strict, best_effort, auto or force");
}

LifecycleState state_argument(const Json& arguments) {
  const std::string text = text_argument(arguments, "state");
  std::vector<std::string> names;
  for (const LifecycleState state : {LifecycleState::unconfigured, LifecycleState::inactive,
                                     LifecycleState::active, LifecycleState::finalized}) {
    if (text == hardware::name(state)) return state;
    names.emplace_back(hardware::name(state));
  }
  throw Error("bad-argument", "there is no state '" + text + "'" + did_you_mean(text, names),
              join(names, ", "));
}

LifecycleState state_of(Cell& cell, const std::string& name) {
  for (const control::ListedController& c : cell.loop().controllers().list())
    if (c.name == name) return c.state;
  throw Error("unknown-controller", "there is no controller '" + name + "'" +
                                        did_you_mean(name, cell.loop().controllers().names()));
}

std::size_t component_argument(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  hardware::Hardware& hardware = cell.loop().hardware();
  std::vector<std::string> known;
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    if (hardware.component_name(i) == name) return i;
    known.push_back(hardware.component_name(i));
  }
  throw Error("unknown-component",
              "there is no hardware component '" + name + "'" + did_you_mean(name, known));
}

/// Active controllers that command a component; with `readers_too`, those that read it as well.
std::vector<std::string> users_of(Cell& cell, std::size_t component, bool readers_too) {
  const hardware::HostedInfo info = cell.loop().hardware().info(component);
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

/// {gains: {joint_1: {p: 3}}} → "gains.joint_1.p": 3, as controllers files have it.
void flatten(const Json& map, const std::string& prefix, controllers::Parameters& out) {
  const auto text = [](const Json& item) { return item.is_string() ? item.get<std::string>() : item.dump(); };
  for (const auto& [key, value] : map.items()) {
    if (value.is_object()) {
      flatten(value, prefix + key + ".", out);
      continue;
    }
    controllers::Parameters::Entry entry;
    entry.list = value.is_array();
    if (entry.list)
      for (const Json& item : value) entry.values.push_back(text(item));
    else
      entry.values.push_back(text(value));
    out.entries[prefix + key] = std::move(entry);
  }
}

}  // namespace

Poll switch_controllers(Cell& cell, control::SwitchRequest request, Json answer) {
  auto job = cell.loop().controllers().begin_switch(request);
  return [job, request, answer, tries = 0](Cell& c) mutable {
    if (!job->done()) return Progress{};
    if (c.loop().controllers().finish(*job)) {
      answer.update(json_of(job->plan()));
      return Progress::done(answer);
    }
    if (++tries > 5)
      throw Error("busy", "the loop keeps changing its controllers by itself", "look at the log");
    c.tell_loop_events();
    job = c.loop().controllers().begin_switch(request);
    return Progress{};
  };
}

namespace {
/// The messages that a controller takes, with the types of ROS.
Json inputs_of(Cell& cell, const std::string& name) {
  Json out = Json::array();
  if (const controllers::Controller* controller = cell.loop().controllers().find(name))
    for (const controllers::InputPort& port : controller->inputs())
      out.push_back({{"name", port.name}, {"types", port.types}});
  return out;
}
}  // namespace

namespace {
/// How often a second the component is read and written, and the controller updated.
double rate_of(Cell& cell, const hardware::HostedInfo& info) {
  return info.period > 0 ? 1 / seconds(info.period)
                         : 1 / seconds(cell.loop().options().period) / info.divisor;
}
double rate_of(Cell& cell, const control::ListedController& controller) {
  return controller.period > 0 ? 1 / seconds(controller.period)
                               : 1 / seconds(cell.loop().options().period) / controller.divisor;
}
}  // namespace

Poll control_list(Cell& cell, const Json&) {
  Json out = Json::array();
  for (const control::ListedController& c : cell.loop().controllers().list())
    out.push_back({{"name", c.name},
                   {"type", c.type},
                   {"state", hardware::name(c.state)},
                   {"chained", c.chained},
                   {"async", c.async},
                   {"stale", c.stale},
                   {"rate", rate_of(cell, c)},
                   {"updates", c.updates},
                   {"missed", c.missed},
                   {"claimed", c.claimed},
                   {"commands", c.required_commands},
                   {"states", c.required_states},
                   {"references", c.references},
                   {"exported_states", c.exported},
                   {"fallback", c.fallback},
                   {"inputs", inputs_of(cell, c.name)}});
  return at_once(std::move(out));
}

Poll control_types(Cell&, const Json&) {
  Json out = Json::array();
  for (const controllers::ControllerType& type : controllers::controller_types())
    out.push_back({{"type", type.name}, {"text", type.summary}});
  return at_once(std::move(out));
}

Poll control_chains(Cell& cell, const Json&) {
  Json out = Json::array();
  const auto all = cell.loop().controllers().list();
  for (const auto& upper : all)
    for (const auto& below : all)
      for (const std::string& reference : below.references)
        if (std::find(upper.required_commands.begin(), upper.required_commands.end(), reference) !=
            upper.required_commands.end())
          out.push_back({{"from", upper.name},
                         {"to", below.name},
                         {"reference", reference},
                         {"active", upper.state == LifecycleState::active}});
  return at_once(std::move(out));
}

Poll control_switch(Cell& cell, const Json& arguments) {
  control::SwitchRequest wanted{list_argument(arguments, "activate"), list_argument(arguments, "deactivate"),
                                strictness_of(text_argument(arguments, "strictness", "strict"))};
  if (wanted.activate.empty() && wanted.deactivate.empty())
    throw Error("bad-argument", "nothing is to be activated and nothing deactivated");
  if (flag_argument(arguments, "dry")) return at_once(json_of(cell.loop().controllers().plan(wanted)));
  return switch_controllers(cell, std::move(wanted), Json::object());
}

Poll control_load(Cell& cell, const Json& arguments) {
  controllers::Parameters parameters;
  if (const auto found = arguments.find("parameters"); found != arguments.end() && found->is_object())
    flatten(*found, "", parameters);
  const std::string name = text_argument(arguments, "name");
  const Problems problems = cell.load_controller(name, text_argument(arguments, "type", ""),
                                                 std::move(parameters), text_argument(arguments, "file", ""));
  Json warnings = Json::array();
  for (const Problem& problem : problems.list()) warnings.push_back(problem.text());
  return at_once({{"name", name}, {"state", hardware::name(state_of(cell, name))}, {"warnings", warnings}});
}

Poll control_configure(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  cell.loop().controllers().configure(name);
  return at_once({{"name", name}, {"state", hardware::name(state_of(cell, name))}});
}

Poll control_cleanup(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  cell.loop().controllers().cleanup(name);
  return at_once({{"name", name}, {"state", hardware::name(state_of(cell, name))}});
}

Poll control_unload(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  cell.unload_controller(name);
  return at_once({{"name", name}});
}

Poll control_state(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  const LifecycleState wanted = state_argument(arguments);
  control::ControllerManager& manager = cell.loop().controllers();
  const LifecycleState now = state_of(cell, name);
  const Json answer{{"name", name}, {"state", hardware::name(wanted)}};
  if (now == wanted) return at_once(answer);
  if (wanted == LifecycleState::finalized)
    throw Error("bad-argument", "a controller is not finalized by hand", "unload it");
  if (now == LifecycleState::active) {
    Poll stopped = switch_controllers(cell, {{}, {name}}, answer);
    if (wanted == LifecycleState::inactive) return stopped;
    return then(stopped, [name, answer](Cell& c) {
      c.loop().controllers().cleanup(name);
      return at_once(answer);
    });
  }
  if (wanted == LifecycleState::unconfigured) {
    manager.cleanup(name);
    return at_once(answer);
  }
  if (now == LifecycleState::unconfigured) manager.configure(name);
  if (wanted == LifecycleState::inactive) return at_once(answer);
  return switch_controllers(cell, {{name}, {}}, answer);
}

Poll hardware_list(Cell& cell, const Json&) {
  Json out = Json::array();
  hardware::Hardware& hardware = cell.loop().hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    const hardware::HostedInfo info = hardware.info(i);
    const hardware::Transition* pending = hardware.pending(i);
    Json commands = Json::array();
    for (const std::string& command : info.commands)
      commands.push_back({{"name", command}, {"claimed_by", cell.loop().controllers().holder_of(command)}});
    out.push_back({{"name", info.name},
                   {"type", info.type},
                   {"plugin", info.plugin},
                   {"group", info.group},
                   {"state", hardware::name(info.state)},
                   {"being", pending ? hardware::done_word(pending->step()) : ""},
                   {"rate", rate_of(cell, info)},
                   {"async", info.async},
                   {"missed", info.missed},
                   {"states", info.states},
                   {"commands", commands}});
  }
  return at_once(std::move(out));
}

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
}  // namespace

Poll hardware_state(Cell& cell, const Json& arguments) {
  const std::size_t i = component_argument(cell, arguments);
  const LifecycleState wanted = state_argument(arguments);
  if (wanted == LifecycleState::active) cell.arming().require_armed(i);
  return then(wait_until_idle(cell, i), [i, wanted](Cell& c) { return take_to(c, i, wanted); });
}

namespace {
Poll reload(Cell& cell, std::size_t i) {
  cell.loop().hardware().require_idle(i);
  const LifecycleState was = cell.loop().hardware().state_of(i);
  if (was == LifecycleState::unconfigured || was == LifecycleState::finalized)
    return make_anew(cell, i, LifecycleState::unconfigured,
                     {{"name", cell.loop().hardware().component_name(i)}, {"stopped", Json::array()}});
  return then_with(take_to(cell, i, LifecycleState::unconfigured),
                   [i, was](Cell& c, Json answer) { return make_anew(c, i, was, std::move(answer)); });
}
}  // namespace

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

namespace {
/// The components one after the other, then the controllers, then the programs may begin.
Poll arm_from(Cell& cell, std::size_t next) {
  const std::vector<std::size_t>& real = cell.arming().components();
  if (next < real.size())
    return then(walk(cell, real[next], LifecycleState::active, Json::object()),
                [next](Cell& c) { return arm_from(c, next + 1); });
  std::vector<std::string> idle;
  for (const std::string& name : cell.wanted_controllers())
    if (state_of(cell, name) == LifecycleState::inactive) idle.push_back(name);
  const Json answer{{"armed", true}, {"started", idle}};
  const auto finish = [answer](Cell& c) {
    c.set_armed();
    return at_once(answer);
  };
  if (idle.empty()) return finish(cell);
  return then(switch_controllers(cell, {idle, {}, control::Strictness::best_effort}, Json::object()), finish);
}
}  // namespace

Poll control_arm(Cell& cell, const Json& arguments) {
  Json seen = Json::array();
  for (const Arming::Expected& joint : cell.arming().expected_positions(cell.snapshot().states))
    seen.push_back(
        {{"joint", joint.joint}, {"measured", number(joint.measured)}, {"expected", number(joint.expected)}});
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

Poll interfaces_list(Cell& cell, const Json&) {
  const hardware::InterfaceTable& table = cell.loop().table();
  const control::Snapshot& seen = cell.snapshot();
  Json states = Json::array(), commands = Json::array();
  for (std::size_t i = 0; i < table.state_names().size(); ++i)
    if (!table.state_names()[i].empty())
      states.push_back({{"name", table.state_names()[i]}, {"value", number(seen.states[i])}});
  for (std::size_t i = 0; i < table.command_names().size(); ++i) {
    const std::string& name = table.command_names()[i];
    if (!name.empty())
      commands.push_back({{"name", name},
                          {"value", number(seen.commands[i])},
                          {"claimed_by", cell.loop().controllers().holder_of(name)}});
  }
  return at_once({{"states", states}, {"commands", commands}});
}

namespace {
Json times(const realtime::Histogram& values) {
  return {{"p50_ns", values.percentile(0.5)}, {"p99_ns", values.percentile(0.99)}, {"max_ns", values.max()}};
}

Json thread_of(const char* what, const std::string& name, double rate, bool own_clock,
               const realtime::ThreadHealth& thread) {
  return {{what, name},
          {"rate_hz", rate},
          {"own_clock", own_clock},
          {"runs", std::uint64_t{thread.runs}},
          {"late", std::uint64_t{thread.late}},
          {"missed", std::uint64_t{thread.missed}},
          {"cost", times(thread.cost)},
          {"wake_up", times(thread.wake_up)},
          {"period", times(thread.period)}};
}

/// What has its turns in the loop, as far as it has had any that were timed.
void add_part(Json& parts, const char* what, const std::string& name, double rate,
              const realtime::PartHealth& part) {
  if (part.cost.count() == 0) return;
  parts.push_back({{what, name},
                   {"rate_hz", rate},
                   {"turns", part.cost.count()},
                   {"cost", times(part.cost)},
                   {"period", times(part.period)}});
}
}  // namespace

Poll health(Cell& cell, const Json&) {
  const control::Health& h = cell.loop().health();
  const control::Snapshot& seen = cell.snapshot();
  Json threads = Json::array(), parts = Json::array(), fallen = Json::array();
  hardware::Hardware& hardware = cell.loop().hardware();
  for (std::size_t i = 0; i < hardware.size(); ++i) {
    const std::string& name = hardware.component_name(i);
    if (i < seen.fallen.size() && seen.fallen[i] != control::StopCause::none)
      fallen.push_back({{"component", name}, {"cause", control::name(seen.fallen[i])}});
    const hardware::HostedInfo info = hardware.info(i);
    if (const realtime::ThreadHealth* thread = hardware.thread_health(i))
      threads.push_back(thread_of("component", name, rate_of(cell, info), info.period > 0, *thread));
    else
      add_part(parts, "component", name, rate_of(cell, info), hardware.part_health(i));
  }
  for (const control::ListedController& c : cell.loop().controllers().list())
    if (c.thread)
      threads.push_back(thread_of("controller", c.name, rate_of(cell, c), false, *c.thread));
    else
      add_part(parts, "controller", c.name, rate_of(cell, c), *c.part);
  return at_once({{"state", control::name(seen.state)},
                  {"cause", control::name(seen.cause)},
                  {"standing", seen.standing},
                  {"parts", parts},
                  {"override_percent", 100 * cell.loop().supervisor().override_share()},
                  {"allowed_percent", 100 * cell.loop().supervisor().share()},
                  {"last_stop", cell.stops().empty() ? Json() : json_of(cell.stops().back())},
                  {"threads", threads},
                  {"fallen", fallen},
                  {"time_s", seconds(seen.cycle.time)},
                  {"rate_hz", 1 / seconds(cell.loop().options().period)},
                  {"cycles", std::uint64_t{h.cycles}},
                  {"late", std::uint64_t{h.late}},
                  {"cost", times(h.cost)},
                  {"wake_up", times(h.wake_up)},
                  {"period", times(h.period)},
                  {"clamps", cell.loop().limits().clamps()}});
}

Poll limits_list(Cell& cell, const Json&) {
  Json out = Json::array();
  const double period = seconds(cell.loop().options().period);
  for (const control::Clamp& clamp : cell.loop().limits().report())
    out.push_back({{"interface", clamp.interface},
                   {"limit", controllers::name(clamp.limit)},
                   {"count", clamp.count},
                   {"asked", number(clamp.asked)},
                   {"given", number(clamp.given)},
                   {"time_s", static_cast<double>(clamp.cycle) * period}});
  return at_once(std::move(out));
}

}  // namespace polyarm::cell
