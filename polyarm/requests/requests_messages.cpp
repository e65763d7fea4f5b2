/// Requests about controllers: parameters, messages sent to them, and messages they publish.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <utility>

#include <nlohmann/json.hpp>

#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/io/worker.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/requests/families.hpp"
#include "polyarm/ros_files/json_trajectory.hpp"
#include "polyarm/ros_files/message_forms.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that messages to controllers need.
struct MessageOwners {
  Machine& machine;
  Worker& worker;
  Observer& events;
};
using Json = nlohmann::json;

const controllers::Parameters& parameters_of(const MessageOwners& cell, const std::string& name) {
  const controllers::ControllerContext* context = cell.machine.controllers().context(name);
  if (!context)
    throw Error(
        "unknown-controller",
        "there is no controller '" + name + "'" + did_you_mean(name, cell.machine.controllers().names()),
        "there are: " + join(cell.machine.controllers().names(), ", "));
  return context->parameters;
}

Parameter parameter_of(const controllers::Declared& d) {
  Parameter out{d.key, controllers::name(d.type), d.value, d.fallback, d.cell != nullptr, d.note.text, {}};
  if (!d.note.choices.empty()) out.choices = {d.note.choices.begin(), d.note.choices.end()};
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

/// Resolves a name: "controller" (its first port), "controller/port", "/namespace/controller/port", or
/// "/port" if only one controller has that port. Action topics end in "/goal" in ROS 1.
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

Address input_address(const MessageOwners& cell, const std::string& given) {
  std::vector<Ports> all;
  for (const std::string& name : cell.machine.controllers().names()) {
    Ports& ports = all.emplace_back(Ports{name, {}});
    for (const controllers::InputPort& port : cell.machine.controllers().find(name)->inputs())
      ports.names.push_back(port.name);
  }
  return resolve(given, all, "that takes messages");
}

Address output_address(const MessageOwners& cell, const std::string& given) {
  std::vector<Ports> all;
  for (const std::string& name : cell.machine.controllers().names()) {
    Ports& ports = all.emplace_back(Ports{name, {}});
    for (const auto& output : cell.machine.controllers().find(name)->outputs())
      ports.names.push_back(output->name());
  }
  return resolve(given, all, "that puts messages out");
}

/// A message for an inactive controller is refused instead of being lost.
void require_active(const MessageOwners& cell, const std::string& controller) {
  for (const control::ListedController& c : cell.machine.controllers().list())
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

SendMessage::Answer answer_of(const controllers::GoalEvent& event, const controllers::Controller& controller) {
  SendMessage::Answer out;
  out.goal = event.goal;
  out.status = outcome_name(event.outcome);
  if (event.outcome == controllers::GoalOutcome::accepted) return out;
  out.error_code = event.code;
  out.error = code_text(event.code);
  if (event.gripper) {
    out.position = event.gripper->position;
    out.effort = event.gripper->effort;
    out.stalled = event.gripper->stalled;
    out.reached_goal = event.gripper->reached_goal;
  }
  if (event.joint < 0) return out;
  const auto j = static_cast<std::size_t>(event.joint);
  std::string joint = j < controller.command_interfaces().size() ? controller.command_interfaces()[j] : "";
  joint = joint.substr(0, joint.rfind('/'));
  out.joint = joint;
  out.off_by = event.error;
  out.tolerance = event.tolerance;
  if (event.outcome == controllers::GoalOutcome::succeeded && !event.gripper)
    out.note = joint + " is " + format_number(event.error) +
               " off its goal; no goal tolerance is set for it (constraints." + joint.substr(joint.rfind('/') + 1) +
               ".goal), so the goal counts as reached";
  return out;
}

/// Parameter of controllers that accept goals.
constexpr const char* kRejectWhenHeld = "reject_goals_when_held";

/// Hz; the default of ros2_control's action servers, used if the controller sets no rate.
constexpr double kFeedbackRate = 20;

/// Interval between feedback messages of an active goal.
Nanoseconds feedback_period(const MessageOwners& cell, const std::string& controller) {
  const controllers::Declared* declared =
      parameters_of(cell, controller).find_declared("action_monitor_rate");
  const double rate = declared ? parse_number(declared->value).value_or(kFeedbackRate) : kFeedbackRate;
  return nanoseconds(1 / (rate > 0 ? rate : kFeedbackRate));
}

/// A controller's output message as JSON, with the fields of its ROS type.
Any message_of(const controllers::Output& output) {
  return Any(Json::parse(ros_files::message_json(output)));
}

/// Reports a goal that succeeded with a large remaining error.
void report_far_from_goal(const MessageOwners& cell, const std::string& controller,
                          const SendMessage::Answer& answer) {
  if (!answer.note) return;
  cell.events.on_problem(cell.machine.now(), {"far-from-goal",
                                              {},
                                              controller + ": goal " + std::to_string(*answer.goal) +
                                                  " succeeded, but " + *answer.note,
                                              "set the tolerance, or send goal_tolerance with the goal",
                                              Severity::warning});
}

/// Follows a goal: sends feedback at the controller's rate, and its result last.
Poll<SendMessage::Answer> follow_goal(const MessageOwners& cell, const Address& to,
                                      const std::string& feedback, std::uint64_t goal, Nanoseconds every) {
  using Followed = Progress<SendMessage::Answer>;
  return [cell, to, feedback, goal, every, reported = Nanoseconds{0}, sample = Nanoseconds{-1},
          accepted = false]() mutable {
    controllers::Controller* controller = cell.machine.controllers().find(to.controller);
    if (!controller) throw Error("unloaded", "the controller was removed");
    for (const controllers::GoalEvent& event : cell.machine.goal_events(to.controller)) {
      if (event.goal != goal) continue;
      const bool first = event.outcome == controllers::GoalOutcome::accepted;
      if (first && std::exchange(accepted, true)) continue;
      SendMessage::Answer answer = answer_of(event, *controller);
      report_far_from_goal(cell, to.controller, answer);
      return first ? Followed::more(std::move(answer)) : Followed::done(std::move(answer));
    }
    // A controller that stopped before it saw the message will never start the goal.
    if (!accepted) require_active(cell, to.controller);
    controllers::Output* state = controller->find_output(feedback);
    if (!accepted || !state || cell.machine.now() - reported < every) return Followed{};
    state->fetch();
    if (state->value().time == sample) return Followed{};
    sample = state->value().time;
    reported += cell.machine.now() - reported < 2 * every
                    ? every
                    : cell.machine.now() - reported;  // keeps the requested rate on average
    SendMessage::Answer answer;
    answer.goal = goal;
    answer.feedback = message_of(*state);
    return Followed::more(std::move(answer));
  };
}

ParamList::Answer param_list(const MessageOwners& cell, const ParamList& request) {
  ParamList::Answer out;
  for (const controllers::Declared& d : parameters_of(cell, request.name).declared()) out.push_back(parameter_of(d));
  return out;
}

Parameter param_get(const MessageOwners& cell, const ParamGet& request) {
  const controllers::Parameters& parameters = parameters_of(cell, request.name);
  if (const controllers::Declared* declared = parameters.find_declared(request.key)) return parameter_of(*declared);
  std::vector<std::string> known;
  for (const controllers::Declared& d : parameters.declared()) known.push_back(d.key);
  throw Error("unknown-parameter",
              "there is no parameter '" + request.key + "'" + did_you_mean(request.key, known));
}

Poll<ParamSet::Answer> param_set(const MessageOwners& cell, const ParamSet& request) {
  using Changed = Progress<ParamSet::Answer>;
  std::vector<std::pair<std::string, std::string>> values;
  if (request.values.empty()) throw Error("bad-argument", "'values' is not a map of parameters");
  for (const auto& [key, value] : request.values) values.emplace_back(key, value.text().value_or(value.dump()));
  const auto job = cell.machine.controllers().begin_change(request.name, values);
  return [job, count = values.size()] { return job->done() ? Changed::done({count}) : Changed{}; };
}

/// A goal for a held cell moves nothing. Reports this, or refuses the goal if the controller's parameter says
/// so.
void look_at_state(const MessageOwners& cell, const std::string& controller) {
  const control::RunState state = cell.machine.snapshot().state;
  if (state == control::RunState::running) return;
  const std::string while_held = std::string(" while the cell is ") + control::name(state) + " (" +
                                 control::name(cell.machine.snapshot().cause) + ")";
  const std::string advice =
      state == control::RunState::fault ? "polyarm control recover" : "polyarm control resume";
  const controllers::Declared* reject = parameters_of(cell, controller).find_declared(kRejectWhenHeld);
  if (reject && reject->value == "true")
    throw Error("held", "a goal for '" + controller + "' is refused" + while_held, advice);
  cell.events.on_problem(cell.machine.now(), {"held",
                                              {},
                                              "a goal for '" + controller + "' comes" + while_held +
                                                  "; nothing moves before the cell runs",
                                              advice,
                                              Severity::warning});
}

/// The input that the address names, with its types and whether it is an action. A goal goes to the first
/// action.
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

/// A message that the worker parses, because parsing a long one takes longer than a tick may.
struct Reading {
  std::optional<controllers::Input> message;
  std::exception_ptr failed;
  std::atomic<bool> done{false};
};

/// Writes NaN and infinity as YAML does, because JSON would write null, which means "not stated".
void spell_out(Json& value) {
  if (value.is_structured())
    for (Json& item : value) spell_out(item);
  else if (value.is_number_float() && !std::isfinite(value.get<double>()))
    value = std::isnan(value.get<double>()) ? ".nan" : value.get<double>() > 0 ? ".inf" : "-.inf";
}

std::string text_of(Json message) {
  if (message.is_string()) return message.get<std::string>();
  spell_out(message);
  return Any(std::move(message)).dump();
}

std::shared_ptr<Reading> begin_reading(const MessageOwners& cell, const Json& given,
                                       std::vector<std::string> types) {
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
    cell.worker.post(read);
  return out;
}

Poll<SendMessage::Answer> send_message(const MessageOwners& cell, const SendMessage& request) {
  using Sent = Progress<SendMessage::Answer>;
  Address to = input_address(cell, request.to);
  require_active(cell, to.controller);
  const controllers::InputPort port =
      port_of(*cell.machine.controllers().find(to.controller), to, request.goal);
  const auto reading = begin_reading(cell, request.message.json(), port.types);
  return [cell, to, action = port.action, feedback = port.feedback, reading,
          follow = Poll<SendMessage::Answer>{}]() mutable {
    if (follow) return follow();
    if (!reading->done.load(std::memory_order_acquire)) return Sent{};
    if (reading->failed) std::rethrow_exception(reading->failed);
    require_active(cell, to.controller);
    controllers::Controller* controller = cell.machine.controllers().find(to.controller);
    if (!controller) throw Error("unloaded", "the controller was removed");
    if (action) look_at_state(cell, to.controller);
    const std::uint64_t id = controller->receive(to.port, *reading->message, action);
    reading->message.reset();
    if (!action) {
      SendMessage::Answer answer;
      answer.to = to.controller + "/" + to.port;
      return Sent::done(std::move(answer));
    }
    follow = follow_goal(cell, to, feedback, id, feedback_period(cell, to.controller));
    return follow();
  };
}

/// Answers with the state of a trajectory controller's trajectory at cell time `at`, s.
Poll<QueryTrajectory::Answer> query_state(const MessageOwners& cell, const QueryTrajectory& request) {
  using Sampled = Progress<QueryTrajectory::Answer>;
  const Nanoseconds at = nanoseconds(request.at.value_or(seconds(cell.machine.now())));
  controller_state(cell.machine, request.name);  // throws if there is no such controller
  return [cell, name = request.name, at, asked = false]() mutable {
    auto* controller =
        dynamic_cast<controllers::JointTrajectoryController*>(cell.machine.controllers().find(name));
    if (!controller)
      throw Error("no-trajectories", "'" + name + "' follows no trajectories", "ask a trajectory controller");
    if (controller_state(cell.machine, name) != hardware::LifecycleState::active) {
      if (asked) controller->forget_sample();
      throw Error("not-active", "the controller '" + name + "' is not active",
                  "start it, and give it a goal");
    }
    asked = asked || controller->ask_sample(at);
    const auto* sampled = asked ? controller->sampled() : nullptr;
    if (!sampled) return Sampled{};
    const auto list = [](const auto& values) { return std::vector<double>(values.begin(), values.end()); };
    const auto joints = controller->told_joints();
    QueryTrajectory::Answer out{{joints.begin(), joints.end()},
                                sampled->found,
                                list(sampled->position),
                                list(sampled->velocity),
                                list(sampled->acceleration)};
    controller->forget_sample();
    if (!out.found)
      throw Error("no-trajectory", "no trajectory leads all joints of '" + name + "' at that time",
                  "ask for a time between its start and its end");
    return Sampled::done(std::move(out));
  };
}

Asked goal_cancel(const MessageOwners& cell, const GoalCancel& request) {
  const Address to = input_address(cell, request.to);
  const double number = request.goal;
  const bool whole = number >= 1 && number < 9e15 && number == std::floor(number);
  if (!whole || !cell.machine.controllers().find(to.controller)->cancel(static_cast<std::uint64_t>(number)))
    throw Error("no-goal", "there is no goal " + format_number(number) + " under way");
  return {"cancel"};
}

/// Reported to a watching client once, until the next message arrives.
NoMessage why_nothing_comes(const MessageOwners& cell, const Address& from, bool never) {
  const hardware::LifecycleState state = controller_state(cell.machine, from.controller);
  const std::string name = from.controller + "/" + from.port;
  const bool active = state == hardware::LifecycleState::active;
  return {name, hardware::name(state),
          "'" + name + "' has sent nothing " + (never ? "yet" : "more") + ": its controller is " +
              hardware::name(state) + (active ? ", and is not updated" : ""),
          active ? "check the cell's state: polyarm health"
                 : "start it: polyarm control state " + from.controller + " active"};
}

Poll<WatchOutput::Answer> watch_output(const MessageOwners& cell, const WatchOutput& request) {
  using Watched = Progress<WatchOutput::Answer>;
  const Address from = output_address(cell, request.name);
  const double rate = request.rate.value_or(10);
  if (!(rate >= 0.001 && rate <= 10'000))
    throw Error("bad-argument", "'rate' is " + format_number(rate) + " Hz", "it may be 0.001 to 10000");
  const Nanoseconds every = nanoseconds(1 / rate);
  const Nanoseconds patience = nanoseconds(std::clamp(request.patience.value_or(0), 0.0, 3600.0));
  return [cell, from, every, patience, reported = Nanoseconds{-1}, sample = Nanoseconds{0},
          fresh = cell.machine.now(), patient = patience > 0]() mutable {
    controllers::Controller* controller = cell.machine.controllers().find(from.controller);
    controllers::Output* output = controller ? controller->find_output(from.port) : nullptr;
    if (!output) throw Error("unloaded", "the controller was removed");
    output->fetch();
    if (output->value().time == sample) {
      if (!patient || cell.machine.now() - fresh < patience) return Watched{};
      patient = false;
      return Watched::more(why_nothing_comes(cell, from, sample == 0));
    }
    fresh = cell.machine.now();
    patient = patience > 0;
    if (reported >= 0 && cell.machine.now() - reported < every) return Watched{};
    sample = output->value().time;
    reported =
        reported < 0 ? cell.machine.now() : reported + every * ((cell.machine.now() - reported) / every);
    return Watched::more(message_of(*output));
  };
}

}  // namespace

std::vector<Handler> message_handlers() {
  return handlers<param_list, param_get, param_set, send_message, goal_cancel, query_state, watch_output>();
}

}  // namespace polyarm::cell
