/// Requests about parameters, messages to controllers, and what comes out of them.
#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/message_forms.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

namespace {

const controllers::Parameters& parameters_of(Cell& cell, const std::string& name) {
  const controllers::ControllerContext* context = cell.loop().controllers().context(name);
  if (!context)
    throw Error("unknown-controller", "there is no controller '" + name + "'" +
                                          did_you_mean(name, cell.loop().controllers().names()));
  return context->parameters;
}

Json json_of(const controllers::Declared& d) {
  Json out{{"key", d.key},          {"type", controllers::name(d.type)}, {"value", d.value},
           {"default", d.fallback}, {"changeable", d.cell != nullptr},   {"text", d.note.text}};
  if (!d.note.choices.empty()) out["choices"] = d.note.choices;
  return out;
}

/// A controller and one of its inputs or outputs.
struct Address {
  std::string controller, port;
};

/// Where a name leads: "controller", "controller/port", "/namespace/controller/port", or "/port" where only
/// one controller has it.
template <typename Has>
Address resolve(Cell& cell, const std::string& given, const char* kind, Has ports_of) {
  std::vector<std::string> words = split_words(given, "/");
  std::vector<std::string> known;
  std::vector<Address> by_port;
  for (const std::string& name : cell.loop().controllers().names()) {
    const std::vector<std::string> ports = ports_of(*cell.loop().controllers().find(name));
    if (ports.empty()) continue;
    for (const std::string& port : ports) {
      known.push_back(name + "/" + port);
      const bool named = words.size() >= 2 && words.back() == port &&
                         (words[words.size() - 2] == name || given == name + "/" + port);
      if (named) return {name, port};
      if (words.size() == 1 && words.back() == port) by_port.push_back({name, port});
    }
    if (!words.empty() && (words.back() == name || given == name)) return {name, ports.front()};
  }
  if (by_port.size() == 1) return by_port.front();
  if (by_port.size() > 1)
    throw Error("which-controller", "several controllers have '" + given + "'",
                "name one of them: " + by_port[0].controller + "/" + by_port[0].port);
  throw Error("unknown-name",
              std::string("nothing ") + kind + " is called '" + given + "'" + did_you_mean(given, known),
              known.empty() ? "" : "there are: " + join(known, ", "));
}

Address input_address(Cell& cell, const std::string& given) {
  return resolve(cell, given, "that takes messages", [](const controllers::Controller& c) {
    std::vector<std::string> out;
    for (const controllers::InputPort& port : c.inputs()) out.push_back(port.name);
    return out;
  });
}

const char* outcome_name(controllers::GoalOutcome outcome) {
  constexpr const char* kNames[] = {"accepted", "succeeded", "aborted", "canceled"};
  return kNames[static_cast<std::size_t>(outcome)];
}

std::string code_text(int code) {
  switch (code) {
    case 0:
      return "SUCCESSFUL";
    case -1:
      return "INVALID_GOAL";
    case -2:
      return "INVALID_JOINTS";
    case -3:
      return "OLD_HEADER_TIMESTAMP";
    case -4:
      return "PATH_TOLERANCE_VIOLATED";
    case -5:
      return "GOAL_TOLERANCE_VIOLATED";
    default:
      return std::to_string(code);
  }
}

Json json_of(const controllers::GoalEvent& event, const controllers::Controller& controller) {
  Json out{{"goal", event.goal}, {"status", outcome_name(event.outcome)}};
  if (event.outcome == controllers::GoalOutcome::accepted) return out;
  out["error_code"] = event.code;
  out["error"] = code_text(event.code);
  if (event.joint >= 0) {
    const auto j = static_cast<std::size_t>(event.joint);
    std::string joint = j < controller.command_interfaces().size() ? controller.command_interfaces()[j] : "";
    joint = joint.substr(0, joint.rfind('/'));
    out["joint"] = joint;
    out["off_by"] = event.error;
    out["tolerance"] = event.tolerance;
  }
  return out;
}

/// Follows a goal: feedback ten times a second, its result last.
Poll follow_goal(const Address& to, std::uint64_t goal) {
  return [to, goal, told = Nanoseconds{0}, accepted = false](Cell& cell) mutable {
    controllers::Controller* controller = cell.loop().controllers().find(to.controller);
    if (!controller) throw Error("unloaded", "the controller was taken away");
    for (const controllers::GoalEvent& event : cell.goal_events(to.controller)) {
      if (event.goal != goal) continue;
      const bool first = event.outcome == controllers::GoalOutcome::accepted;
      if (first && std::exchange(accepted, true)) continue;
      Json out = json_of(event, *controller);
      return first ? Progress::more(std::move(out)) : Progress::done(std::move(out));
    }
    controllers::Output* state = controller->find_output("controller_state");
    if (!state || cell.now() - told < 100'000'000 || !state->fetch()) return Progress{};
    told = cell.now();
    return Progress::more({{"goal", goal}, {"feedback", Json::parse(message_json(*state))}});
  };
}

}  // namespace

Poll param_list(Cell& cell, const Json& arguments) {
  Json out = Json::array();
  for (const controllers::Declared& d : parameters_of(cell, text_argument(arguments, "name")).declared())
    out.push_back(json_of(d));
  return at_once(std::move(out));
}

Poll param_get(Cell& cell, const Json& arguments) {
  const controllers::Parameters& parameters = parameters_of(cell, text_argument(arguments, "name"));
  const std::string key = text_argument(arguments, "key");
  if (const controllers::Declared* declared = parameters.find_declared(key))
    return at_once(json_of(*declared));
  std::vector<std::string> known;
  for (const controllers::Declared& d : parameters.declared()) known.push_back(d.key);
  throw Error("unknown-parameter", "there is no parameter '" + key + "'" + did_you_mean(key, known));
}

Poll param_set(Cell& cell, const Json& arguments) {
  std::vector<std::pair<std::string, std::string>> values;
  const auto found = arguments.find("values");
  if (found == arguments.end() || !found->is_object() || found->empty())
    throw Error("bad-argument", "'values' is no map of parameters");
  for (const auto& [key, value] : found->items())
    values.emplace_back(key, value.is_string() ? value.get<std::string>() : value.dump());
  const auto job = cell.loop().controllers().begin_change(text_argument(arguments, "name"), values);
  return [job, count = values.size()](Cell&) {
    return job->done() ? Progress::done({{"changed", count}}) : Progress{};
  };
}

Poll send_message(Cell& cell, const Json& arguments) {
  Address to = input_address(cell, text_argument(arguments, "to"));
  controllers::Controller& controller = *cell.loop().controllers().find(to.controller);
  const bool goal = flag_argument(arguments, "goal");
  std::vector<std::string> types;
  bool action = false;
  for (const controllers::InputPort& port : controller.inputs()) {
    if (goal && port.action && !action) to.port = port.name;
    if (port.name != to.port) continue;
    types = port.types;
    action = port.action;
  }
  if (goal && !action) throw Error("no-action", "'" + to.controller + "' takes no goals");
  const controllers::Input message = read_message(text_argument(arguments, "message"), "the message", types);
  const std::uint64_t id = controller.receive(to.port, message, action);
  if (!action) return at_once({{"to", to.controller + "/" + to.port}});
  return then(at_once(nullptr), [to, id](Cell&) { return follow_goal(to, id); });
}

Poll goal_cancel(Cell& cell, const Json& arguments) {
  const Address to = input_address(cell, text_argument(arguments, "to"));
  const auto goal = static_cast<std::uint64_t>(number_argument(arguments, "goal", 0));
  if (!cell.loop().controllers().find(to.controller)->cancel(goal))
    throw Error("no-goal", "there is no goal " + std::to_string(goal) + " under way");
  return at_once({{"asked", "cancel"}});
}

Poll watch_output(Cell& cell, const Json& arguments) {
  const Address from = resolve(cell, text_argument(arguments, "name"), "that puts messages out",
                               [](const controllers::Controller& c) {
                                 std::vector<std::string> out;
                                 for (const auto& output : c.outputs()) out.push_back(output->name());
                                 return out;
                               });
  const double rate = number_argument(arguments, "rate", 10);
  const Nanoseconds every = rate > 0 ? nanoseconds(1 / rate) : 0;
  return [from, every, told = Nanoseconds{-1}, sample = Nanoseconds{-1}](Cell& c) mutable {
    controllers::Controller* controller = c.loop().controllers().find(from.controller);
    controllers::Output* output = controller ? controller->find_output(from.port) : nullptr;
    if (!output) throw Error("unloaded", "the controller was taken away");
    output->fetch();
    const bool due = told < 0 || c.now() - told >= every;
    if (!due || output->value().time == sample) return Progress{};
    sample = output->value().time;
    told = told < 0 || every == 0 ? c.now() : told + every * ((c.now() - told) / every);
    return Progress::more(Json::parse(message_json(*output)));
  };
}

}  // namespace polyarm::cell
