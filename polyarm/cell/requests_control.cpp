/// Requests about controllers.
#include <algorithm>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/point_edits.hpp"
#include "polyarm/cell/requests_work.hpp"
#include "polyarm/controllers/types.hpp"

namespace polyarm::cell {

using hardware::LifecycleState;

namespace {

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

/// The messages that a controller takes, with the types of ROS.
Json inputs_of(Cell& cell, const std::string& name) {
  Json out = Json::array();
  if (const controllers::Controller* controller = cell.loop().controllers().find(name))
    for (const controllers::InputPort& port : controller->inputs())
      out.push_back({{"name", port.name}, {"types", port.types}});
  return out;
}
}  // namespace

LifecycleState controller_state(Cell& cell, const std::string& name) {
  for (const control::ListedController& c : cell.loop().controllers().list())
    if (c.name == name) return c.state;
  throw Error("unknown-controller",
              "there is no controller '" + name + "'" + did_you_mean(name, cell.loop().controllers().names()),
              "there are: " + join(cell.loop().controllers().names(), ", "));
}

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
  const std::string unsaid = cell.manager().strictness.empty() ? "strict" : cell.manager().strictness;
  control::SwitchRequest wanted{list_argument(arguments, "activate"), list_argument(arguments, "deactivate"),
                                strictness_of(text_argument(arguments, "strictness", unsaid))};
  if (wanted.activate.empty() && wanted.deactivate.empty())
    throw Error("bad-argument", "nothing is to be activated and nothing deactivated");
  if (flag_argument(arguments, "dry")) return at_once(json_of(cell.loop().controllers().plan(wanted)));
  return switch_controllers(cell, std::move(wanted), Json::object());
}

Poll control_load(Cell& cell, const Json& arguments) {
  require_short_name(text_argument(arguments, "name"));
  if (const std::size_t loaded = cell.loop().controllers().list().size();
      loaded >= bounds::kLoadedControllers)
    throw Error("too-many", "the cell has " + std::to_string(loaded) + " controllers already",
                "unload one first: control.unload");
  controllers::Parameters parameters;
  if (const auto found = arguments.find("parameters"); found != arguments.end() && found->is_object())
    flatten(*found, "", parameters);
  const std::string name = text_argument(arguments, "name");
  const Problems problems = cell.load_controller(name, text_argument(arguments, "type", ""),
                                                 std::move(parameters), text_argument(arguments, "file", ""));
  Json warnings = Json::array();
  for (const Problem& problem : problems.list()) warnings.push_back(problem.text());
  return at_once(
      {{"name", name}, {"state", hardware::name(controller_state(cell, name))}, {"warnings", warnings}});
}

Poll control_configure(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  cell.loop().controllers().configure(name);
  return at_once({{"name", name}, {"state", hardware::name(controller_state(cell, name))}});
}

Poll control_cleanup(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  cell.loop().controllers().cleanup(name);
  return at_once({{"name", name}, {"state", hardware::name(controller_state(cell, name))}});
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
  const LifecycleState now = controller_state(cell, name);
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

}  // namespace

const std::vector<RequestRow>& controller_rows() {
  static const std::vector<RequestRow> table = {
      {{"control.list",
        {},
        "[{name, type, state, chained, async, stale, rate, updates, missed, claimed, commands, states, "
        "references, "
        "exported_states, fallback, inputs: [{name, types}]}]",
        "the controllers, their states and what they claim and offer",
        false},
       control_list},
      {{"control.types", {}, "[{type, text}]", "the controller types that there are", false}, control_types},
      {{"control.chains",
        {},
        "[{from, to, reference, active}]",
        "which controllers work through which",
        false},
       control_chains},
      {{"control.switch",
        {{"activate", kNames}, {"deactivate", kNames}, {"strictness", kText}, {"dry", kFlag}},
        "{ok, reason, advice, start, stop, left_out, chained, unchained}",
        "start and stop controllers in one step between two cycles; `strictness` is strict, best_effort, "
        "auto or force (default: as the controllers' file says, else strict); with `dry` it is only said "
        "what would happen, or why not",
        true},
       control_switch},
      {{"control.load",
        {{"name", kText, true}, {"type", kText}, {"file", kText}, {"parameters", kMap}},
        "{name, state, warnings}",
        "make and configure a controller: one of the cell's controllers files, one of `file`, or one of "
        "`type`",
        false},
       control_load},
      {{"control.configure", kName, "{name, state}", "unconfigured → inactive", false}, control_configure},
      {{"control.cleanup", kName, "{name, state}", "inactive → unconfigured", false}, control_cleanup},
      {{"control.unload", kName, "{name}", "take a controller away that is not active", false},
       control_unload},
      {{"control.state",
        {{"name", kText, true}, {"state", kText, true}},
        "{name, state}",
        "take a controller to unconfigured, inactive or active, through all that lies between",
        true},
       control_state},
  };
  return table;
}

}  // namespace polyarm::cell
