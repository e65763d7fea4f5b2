/// Requests about parameters, messages to controllers, and what comes out of them.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"
#include "polyarm/cell/worker.hpp"
#include "polyarm/controllers/joint_trajectory_controller.hpp"
#include "polyarm/ros_files/json_trajectory.hpp"
#include "polyarm/ros_files/message_forms.hpp"

namespace polyarm::cell {

namespace {

const controllers::Parameters& parameters_of(Cell& cell, const std::string& name) {
  const controllers::ControllerContext* context = cell.loop().controllers().context(name);
  if (!context)
    throw Error(
        "unknown-controller",
        "there is no controller '" + name + "'" + did_you_mean(name, cell.loop().controllers().names()),
        "there are: " + join(cell.loop().controllers().names(), ", "));
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

struct Ports {
  std::string controller;
  std::vector<std::string> names;
};

std::string listed(const std::vector<Address>& addresses) {
  std::vector<std::string> out;
  for (const Address& a : addresses) out.push_back(a.controller + "/" + a.port);
  return join(out, ", ");
}

bool ends_with_words(const std::vector<std::string>& words, const std::vector<std::string>& ending) {
  return words.size() >= ending.size() && std::equal(ending.rbegin(), ending.rend(), words.rbegin());
}

/// Where a name leads: "controller" (its first port), "controller/port", "/namespace/controller/port", or
/// "/port" where only one controller has it. Topics of an action end in "/goal" in ROS 1.
Address resolve(const std::string& given, const std::vector<Ports>& all, const char* kind) {
  std::vector<std::string> words = split_words(given, "/");
  if (words.size() > 1 && words.back() == "goal") words.pop_back();
  std::vector<Address> by_port, by_name;
  std::vector<std::string> known, hints;
  for (const Ports& ports : all) {
    if (!ports.names.empty()) hints.push_back(ports.controller);
    const std::vector<std::string> own = split_words(ports.controller, "/");
    for (const std::string& port : ports.names) {
      known.push_back(ports.controller + "/" + port);
      if (ends_with_words(words, split_words(known.back(), "/"))) return {ports.controller, port};
      if (words == split_words(port, "/")) by_port.push_back({ports.controller, port});
    }
    if (!ports.names.empty() && ends_with_words(words, own))
      by_name.push_back({ports.controller, ports.names.front()});
  }
  if (by_name.size() == 1) return by_name.front();
  if (by_port.size() == 1) return by_port.front();
  if (by_port.size() > 1)
    throw Error("which-controller", "several controllers have '" + given + "'",
                "name one of them: " + listed(by_port));
  hints.insert(hints.end(), known.begin(), known.end());
  throw Error("unknown-name",
              std::string("nothing ") + kind + " is called '" + given + "'" + did_you_mean(given, hints),
              known.empty() ? "" : "there are: " + join(known, ", "));
}

Address input_address(Cell& cell, const std::string& given) {
  std::vector<Ports> all;
  for (const std::string& name : cell.loop().controllers().names()) {
    Ports& ports = all.emplace_back(Ports{name, {}});
    for (const controllers::InputPort& port : cell.loop().controllers().find(name)->inputs())
      ports.names.push_back(port.name);
  }
  return resolve(given, all, "that takes messages");
}

Address output_address(Cell& cell, const std::string& given) {
  std::vector<Ports> all;
  for (const std::string& name : cell.loop().controllers().names()) {
    Ports& ports = all.emplace_back(Ports{name, {}});
    for (const auto& output : cell.loop().controllers().find(name)->outputs())
      ports.names.push_back(output->name());
  }
  return resolve(given, all, "that puts messages out");
}

/// What nobody listens to is refused, not swallowed.
void require_active(Cell& cell, const std::string& controller) {
  for (const control::ListedController& c : cell.loop().controllers().list())
    if (c.name == controller && c.state != hardware::LifecycleState::active)
      throw Error(
          "not-active",
          "the controller '" + controller + "' is " + hardware::name(c.state) + " and takes no messages",
          "start it: polyarm control state " + controller + " active");
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
  if (event.gripper) {
    out["position"] = event.gripper->position;
    out["effort"] = event.gripper->effort;
    out["stalled"] = event.gripper->stalled;
    out["reached_goal"] = event.gripper->reached_goal;
  }
  if (event.joint >= 0) {
    const auto j = static_cast<std::size_t>(event.joint);
    std::string joint = j < controller.command_interfaces().size() ? controller.command_interfaces()[j] : "";
    joint = joint.substr(0, joint.rfind('/'));
    out["joint"] = joint;
    out["off_by"] = event.error;
    out["tolerance"] = event.tolerance;
    if (event.outcome == controllers::GoalOutcome::succeeded && !event.gripper)
      out["note"] = joint + " is " + format_number(event.error) +
                    " off its goal; no goal tolerance is set for it (constraints." +
                    joint.substr(joint.rfind('/') + 1) + ".goal), so the goal counts as reached";
  }
  return out;
}

/// Parameter of controllers that take goals.
constexpr const char* kRejectWhenHeld = "reject_goals_when_held";

/// Of ros2_control's action servers, where a controller says nothing else.
constexpr double kFeedbackRate = 20;

/// How often a goal under way is told of.
Nanoseconds feedback_period(Cell& cell, const std::string& controller) {
  const controllers::Declared* declared =
      parameters_of(cell, controller).find_declared("action_monitor_rate");
  const double rate = declared ? parse_number(declared->value).value_or(kFeedbackRate) : kFeedbackRate;
  return nanoseconds(1 / (rate > 0 ? rate : kFeedbackRate));
}

/// Follows a goal: feedback as often as its controller says, its result last.
Poll follow_goal(const Address& to, const std::string& feedback, std::uint64_t goal, Nanoseconds every) {
  return [to, feedback, goal, every, told = Nanoseconds{0}, sample = Nanoseconds{-1},
          accepted = false](Cell& cell) mutable {
    controllers::Controller* controller = cell.loop().controllers().find(to.controller);
    if (!controller) throw Error("unloaded", "the controller was taken away");
    for (const controllers::GoalEvent& event : cell.goal_events(to.controller)) {
      if (event.goal != goal) continue;
      const bool first = event.outcome == controllers::GoalOutcome::accepted;
      if (first && std::exchange(accepted, true)) continue;
      Json out = json_of(event, *controller);
      if (out.contains("note"))
        cell.observer().on_problem(cell.now(), {"far-from-goal",
                                                {},
                                                to.controller + ": goal " + std::to_string(goal) +
                                                    " succeeded, but " + out["note"].get<std::string>(),
                                                "set the tolerance, or send goal_tolerance with the goal",
                                                Severity::warning});
      return first ? Progress::more(std::move(out)) : Progress::done(std::move(out));
    }
    // It ended between the message and its first look at it: the goal is not begun any more.
    if (!accepted) require_active(cell, to.controller);
    controllers::Output* state = controller->find_output(feedback);
    if (!accepted || !state || cell.now() - told < every) return Progress{};
    state->fetch();
    if (state->value().time == sample) return Progress{};
    sample = state->value().time;
    told += cell.now() - told < 2 * every ? every : cell.now() - told;  // no less often than asked for
    return Progress::more({{"goal", goal}, {"feedback", Json::parse(ros_files::message_json(*state))}});
  };
}

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
    values.emplace_back(key, value.is_string() ? value.get<std::string>()
                                               : value.dump(-1, ' ', false, Json::error_handler_t::replace));
  const auto job = cell.loop().controllers().begin_change(text_argument(arguments, "name"), values);
  return [job, count = values.size()](Cell&) {
    return job->done() ? Progress::done({{"changed", count}}) : Progress{};
  };
}

/// A goal for a cell that is held moves nothing: a person is told so, or the goal is refused where the
/// controller's parameter says that.
void look_at_state(Cell& cell, const std::string& controller) {
  const control::RunState state = cell.snapshot().state;
  if (state == control::RunState::running) return;
  const std::string while_held = std::string(" while the cell is ") + control::name(state) + " (" +
                                 control::name(cell.snapshot().cause) + ")";
  const std::string advice =
      state == control::RunState::fault ? "polyarm control recover" : "polyarm control resume";
  const controllers::Declared* reject = parameters_of(cell, controller).find_declared(kRejectWhenHeld);
  if (reject && reject->value == "true")
    throw Error("held", "a goal for '" + controller + "' is refused" + while_held, advice);
  cell.observer().on_problem(cell.now(), {"held",
                                          {},
                                          "a goal for '" + controller + "' comes" + while_held +
                                              "; nothing moves before the cell runs",
                                          advice,
                                          Severity::warning});
}

/// The input that is meant, what it takes, and whether it is an action. A goal goes to the first action.
controllers::InputPort port_of(const controllers::Controller& controller, Address& to, bool goal) {
  const std::vector<controllers::InputPort> inputs = controller.inputs();
  const auto named =
      std::find_if(inputs.begin(), inputs.end(), [&](const auto& p) { return p.name == to.port; });
  if (!goal || named->action) return *named;
  for (const controllers::InputPort& port : inputs)
    if (port.action) {
      to.port = port.name;
      return port;
    }
  throw Error("no-action", "'" + to.controller + "' takes no goals", "send it without a goal");
}

/// A message being read by the worker: a long one takes longer than a tick may.
struct Reading {
  std::optional<controllers::Input> message;
  std::exception_ptr failed;
  std::atomic<bool> done{false};
};

/// What is no finite number stays visible in the text: JSON would write null, which means "not stated".
void spell_out(Json& value) {
  if (value.is_structured())
    for (Json& item : value) spell_out(item);
  else if (value.is_number_float() && !std::isfinite(value.get<double>()))
    value = std::isnan(value.get<double>()) ? ".nan" : value.get<double>() > 0 ? ".inf" : "-.inf";
}

std::string text_of(Json message) {
  if (message.is_string()) return message.get<std::string>();
  spell_out(message);
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::shared_ptr<Reading> begin_reading(Cell& cell, const Json& given, std::vector<std::string> types) {
  constexpr std::size_t kShort = 4096;
  auto out = std::make_shared<Reading>();
  out->message = ros_files::read_json_trajectory(given, "the message", types);
  out->done = out->message.has_value();
  if (out->done) return out;
  std::string text = text_of(given);
  const bool is_short = text.size() <= kShort;
  const auto read = [out, text = std::move(text), types = std::move(types)] {
    try {
      out->message = ros_files::read_message(text, "the message", types);
    } catch (...) {
      out->failed = std::current_exception();
    }
    out->done.store(true, std::memory_order_release);
  };
  if (is_short)
    read();
  else
    cell.worker().post(read);
  return out;
}

Poll send_message(Cell& cell, const Json& arguments) {
  Address to = input_address(cell, text_argument(arguments, "to"));
  require_active(cell, to.controller);
  const controllers::InputPort port =
      port_of(*cell.loop().controllers().find(to.controller), to, flag_argument(arguments, "goal"));
  const auto reading = begin_reading(cell, arguments["message"], port.types);
  return [to, action = port.action, feedback = port.feedback, reading, follow = Poll{}](Cell& c) mutable {
    if (follow) return follow(c);
    if (!reading->done.load(std::memory_order_acquire)) return Progress{};
    if (reading->failed) std::rethrow_exception(reading->failed);
    require_active(c, to.controller);
    controllers::Controller* controller = c.loop().controllers().find(to.controller);
    if (!controller) throw Error("unloaded", "the controller was taken away");
    if (action) look_at_state(c, to.controller);
    const std::uint64_t id = controller->receive(to.port, *reading->message, action);
    reading->message.reset();
    if (!action) return Progress::done({{"to", to.controller + "/" + to.port}});
    follow = follow_goal(to, feedback, id, feedback_period(c, to.controller));
    return follow(c);
  };
}

/// Where a trajectory controller's trajectory will be at `at` s of cell time.
Poll query_state(Cell& cell, const Json& arguments) {
  const std::string name = text_argument(arguments, "name");
  const Nanoseconds at = nanoseconds(number_argument(arguments, "at", seconds(cell.now())));
  controller_state(cell, name);  // it is known
  return [name, at, asked = false](Cell& c) mutable {
    auto* controller =
        dynamic_cast<controllers::JointTrajectoryController*>(c.loop().controllers().find(name));
    if (!controller)
      throw Error("no-trajectories", "'" + name + "' follows no trajectories", "ask a trajectory controller");
    if (controller_state(c, name) != hardware::LifecycleState::active) {
      if (asked) controller->forget_sample();
      throw Error("not-active", "the controller '" + name + "' is not active",
                  "start it, and give it a goal");
    }
    asked = asked || controller->ask_sample(at);
    const auto* sampled = asked ? controller->sampled() : nullptr;
    if (!sampled) return Progress{};
    const Json out{{"joints", controller->told_joints()},
                   {"found", sampled->found},
                   {"position", sampled->position},
                   {"velocity", sampled->velocity},
                   {"acceleration", sampled->acceleration}};
    controller->forget_sample();
    if (!out["found"].get<bool>())
      throw Error("no-trajectory", "no trajectory leads all joints of '" + name + "' at that time",
                  "ask for a time between the start and the end of one that is under way");
    return Progress::done(out);
  };
}

Poll goal_cancel(Cell& cell, const Json& arguments) {
  const Address to = input_address(cell, text_argument(arguments, "to"));
  const double number = number_argument(arguments, "goal", 0);
  const bool whole = number >= 1 && number < 9e15 && number == std::floor(number);
  if (!whole || !cell.loop().controllers().find(to.controller)->cancel(static_cast<std::uint64_t>(number)))
    throw Error("no-goal", "there is no goal " + format_number(number) + " under way");
  return at_once({{"asked", "cancel"}});
}

/// Told to a watcher once, until the next message comes.
Json why_nothing_comes(Cell& cell, const Address& from, bool never) {
  const hardware::LifecycleState state = controller_state(cell, from.controller);
  const std::string name = from.controller + "/" + from.port;
  const bool active = state == hardware::LifecycleState::active;
  return {{"waiting", name},
          {"state", hardware::name(state)},
          {"what", "'" + name + "' has put out nothing " + (never ? "yet" : "more") + ": its controller is " +
                       hardware::name(state) + (active ? ", and is not updated" : "")},
          {"advice", active ? "look at the cell's state: polyarm health"
                            : "start it: polyarm control state " + from.controller + " active"}};
}

Poll watch_output(Cell& cell, const Json& arguments) {
  const Address from = output_address(cell, text_argument(arguments, "name"));
  const double rate = number_argument(arguments, "rate", 10);
  if (!(rate >= 0.001 && rate <= 10'000))
    throw Error("bad-argument", "'rate' is " + format_number(rate) + " Hz", "it may be 0.001 to 10000");
  const Nanoseconds every = nanoseconds(1 / rate);
  const Nanoseconds patience =
      nanoseconds(std::clamp(number_argument(arguments, "patience", 0), 0.0, 3600.0));
  return [from, every, patience, told = Nanoseconds{-1}, sample = Nanoseconds{0}, fresh = cell.now(),
          patient = patience > 0](Cell& c) mutable {
    controllers::Controller* controller = c.loop().controllers().find(from.controller);
    controllers::Output* output = controller ? controller->find_output(from.port) : nullptr;
    if (!output) throw Error("unloaded", "the controller was taken away");
    output->fetch();
    if (output->value().time == sample) {
      if (!patient || c.now() - fresh < patience) return Progress{};
      patient = false;
      return Progress::more(why_nothing_comes(c, from, sample == 0));
    }
    fresh = c.now();
    patient = patience > 0;
    if (told >= 0 && c.now() - told < every) return Progress{};
    sample = output->value().time;
    told = told < 0 ? c.now() : told + every * ((c.now() - told) / every);
    return Progress::more(Json::parse(ros_files::message_json(*output)));
  };
}

}  // namespace

const std::vector<RequestRow>& message_rows() {
  static const std::vector<RequestRow> table = {
      {{"param.list", kName, "[{key, type, value, default, changeable, text, choices}]",
        "the parameters of a controller", false},
       param_list},
      {{"param.get",
        {{"name", kText, true}, {"key", kText, true}},
        "{key, type, value, default, changeable, text, choices}",
        "one parameter",
        false},
       param_get},
      {{"param.set",
        {{"name", kText, true}, {"values", kMap, true}},
        "{changed}",
        "change parameters between two cycles, all or none",
        true},
       param_set},
      {{"send",
        {{"to", kText, true}, {"message", ArgumentType::message, true}, {"goal", kFlag}},
        "{to}; of a goal {goal, status, error_code, error, joint, off_by, tolerance, note}, of a gripper's "
        "also "
        "{position, effort, stalled, reached_goal}, and between {goal, feedback}",
        "give a message to a controller; a goal is followed to its end",
        true},
       send_message},
      {{"goal.cancel",
        {{"to", kText, true}, {"goal", kNumber, true}},
        "{asked}",
        "end a goal that is under way",
        true},
       goal_cancel},
      {{"query",
        {{"name", kText, true}, {"at", kNumber}},
        "{joints, found, position, velocity, acceleration}",
        "where the trajectory of a controller will be at a cell time, s; now without one",
        false},
       query_state},
      {{"watch",
        {{"name", kText, true}, {"rate", kNumber}, {"patience", kNumber}},
        "the message in its ROS shape; {waiting, state, what, advice} where nothing comes",
        "tell what a controller puts out, `rate` times a second (10); with `patience` it is told once why "
        "nothing has come for so many seconds",
        false},
       watch_output},
  };
  return table;
}

}  // namespace polyarm::cell
