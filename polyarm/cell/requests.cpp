#include "polyarm/cell/requests.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/cell/requests_work.hpp"

namespace polyarm::cell {

namespace {

using Row = RequestRow;

Poll help(Cell&, const Json&) {
  Json out = Json::array();
  for (const RequestInfo& info : request_table()) {
    Json arguments = Json::array();
    for (const RequestArgument& a : info.arguments)
      arguments.push_back({{"name", a.name}, {"type", name(a.type)}, {"needed", a.needed}});
    out.push_back({{"request", info.name},
                   {"arguments", arguments},
                   {"result", info.result},
                   {"text", info.text},
                   {"moves", info.moves}});
  }
  return at_once(std::move(out));
}

constexpr auto kText = ArgumentType::text;
constexpr auto kNumber = ArgumentType::number;
constexpr auto kFlag = ArgumentType::flag;
constexpr auto kNames = ArgumentType::names;
constexpr auto kMap = ArgumentType::map;

const std::vector<RequestArgument> kName = {{"name", kText, true}};

const char* const kJogState =
    "{session, robot, model, tool, names, slides, joints, limits, position, rpy, orientation, speed, moving, "
    "held_back, reason, profile, control}; "
    "of a step also {done}";

const char* const kProgram =
    "{state, control, cause, holder, folder, robots, held, events, file, paused, where: {file, line}, "
    "source, "
    "sentence, passes, breakpoints, question, problem, tasks: [{name, state, where, source, waits_for, "
    "names, "
    "text, passes, paused, calls, variables: [{name, value}], robot, tool, frame, problem}]}";

const char* const kRecord = "{recording, file, seconds, rate, messages, bytes, lost, problem}";

const std::vector<Row>& running_rows() {
  static const std::vector<Row> table = {
      {{"help", {}, "[{request, arguments, result, text, moves}]", "this table", false}, help},
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
        "auto "
        "or force; with `dry` it is only said what would happen, or why not",
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
      {{"control.hold", {}, "{asked}", "stop on the path", true}, control_hold},
      {{"control.arm",
        {{"confirmed", kFlag}},
        "{armed, joints: [{joint, measured, expected}], started}",
        "without 'confirmed': where real joints are measured and expected; with it: a person at a terminal "
        "has "
        "compared them, the hardware is activated and its controllers start",
        true},
       control_arm},
      {{"control.stop",
        {{"category", kNumber}},
        "{asked, category, inactive}",
        "stop at once, on the path as hard as the joints can; category 1 then switches the drives off, 2 "
        "(otherwise) holds",
        true},
       control_stop},
      {{"control.resume",
        {{"anyway", kFlag}},
        "{asked}",
        "go on along the path after a hold; refused where the robot was moved meanwhile, unless `anyway`",
        true},
       control_resume},
      {{"control.back",
        {{"time", kNumber}, {"distance", kNumber}},
        "{asked, state, joints}",
        "from a hold, slowly back along the planned path: by `time` s of the plan (1) or `distance` along "
        "the "
        "path, then held again",
        true},
       control_back},
      {{"control.override",
        {{"percent", kNumber}},
        "{asked, percent, allowed}",
        "how much of the planned speed is used, 0 to 100; without `percent` it is only told",
        true},
       control_override},
      {{"control.discard", {}, "{asked}", "forget what is left of a motion that is held", true},
       control_discard},
      {{"control.recover", {}, "{asked}", "leave the fault state for held; nothing moves", true},
       control_recover},
      {{"tags.list",
        {{"names", kNames}},
        "{tags: [{name, type, unit, value, text, direction, source, quality, forced, changed_s, changed_by, "
        "output, "
        "rules}], links: [{name, address, up, reason, losses, exchanges, round_ms, on_loss, tags}]}",
        "every tag, or those named (variables of data, too), and the links",
        false},
       tags_list},
      {{"tags.set",
        {{"name", kText, true}, {"value", ArgumentType::any, true}},
        "{name, value, …}, as in tags.list",
        "change a tag or variable once, as a person",
        true},
       tags_set},
      {{"tags.force",
        {{"name", kText, true}, {"value", ArgumentType::any, true}},
        "{name, value, …} again and again",
        "the tag keeps the value whatever is set meanwhile, for as long as the asker is there",
        true},
       tags_force},
      {{"hardware.list",
        {},
        "[{name, type, plugin, group, state, being, rate, async, missed, states, commands: [{name, "
        "claimed_by}]}]",
        "the hardware components, their states and interfaces",
        false},
       hardware_list},
      {{"hardware.state",
        {{"name", kText, true}, {"state", kText, true}},
        "{name, state, stopped}",
        "take a component to unconfigured, inactive, active or finalized; controllers that use it are "
        "stopped first, with their chains",
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
      {{"interfaces",
        {},
        "{states: [{name, value}], commands: [{name, value, claimed_by}]}",
        "every state and command interface",
        false},
       interfaces_list},
      {{"health",
        {},
        "{state, cause, standing, time_s, rate_hz, cycles, late, cost, wake_up, period, clamps, parts: "
        "[{component or controller, rate_hz, turns, cost, period}], threads: [{component or controller, "
        "rate_hz, own_clock, runs, late, missed, cost, wake_up, period}], fallen: [{component, cause}]}",
        "how the control loop is doing",
        false},
       health},
      {{"limits",
        {},
        "[{interface, limit, count, asked, given, time_s}]",
        "which limits took hold of commands, how often, and the last time",
        false},
       limits_list},
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
        "{to}; of a goal {goal, status, error_code, error, joint, off_by, tolerance}, of a gripper's also "
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
      {{"watch",
        {{"name", kText, true}, {"rate", kNumber}},
        "the message in its ROS shape",
        "tell what a controller puts out, `rate` times a second (10)",
        false},
       watch_output},
      {{"jog",
        {{"robot", kText},
         {"joints", kMap},
         {"tcp", kMap},
         {"frame", kText},
         {"by", kFlag},
         {"speed", kNumber},
         {"hold", kNumber},
         {"session", kNumber},
         {"end", kFlag}},
        kJogState,
        "move joints or the TCP by hand: with velocities {elbow_joint: 0.1} or {z: 0.02} in `frame` (base, "
        "world, tool or a point's name) for `hold` seconds (0.25) unless it comes again with the `session` "
        "of "
        "the answer; with `by` by so much, answered until it is done; with `end` no more",
        true},
       jog},
      {{"jog.state", {{"robot", kText}}, kJogState, "where a robot is, and what holds it back", false},
       jog_state},
      {{"target",
        {{"robot", kText},
         {"joints", kMap},
         {"pose", kMap},
         {"frame", kText},
         {"speed", kNumber},
         {"hold", kNumber},
         {"session", kNumber}},
        kJogState,
        "go to joints or a pose {position, orientation or rpy}, again and again with the `session` of the "
        "answer: what a sensor or a hand streams becomes smooth motion, which ends `hold` seconds (0.25) "
        "after the last one",
        true},
       target},
      {{"profile",
        {{"name", kText}},
        "{profile, joint_speed, tcp_speed}",
        "the limits profile of the cell, or another: reduced (teaching) or full",
        true},
       profile},
      {{"move",
        {{"points", ArgumentType::message, true},
         {"robot", kText},
         {"kind", kText},
         {"pace", kNumber},
         {"speed", kNumber},
         {"rests", kFlag}},
        "{robot, cell, cause, elapsed_s, left_s, left_m}; at the end also {done}",
        "to points, one path through all of them (with `rests` it comes to rest at each); a point is a name "
        "of the cell's data, {joints: …} or {pose: {position, rpy or orientation}}, with a `duration` of the "
        "way to it if it is to take at least that long; `kind` is joint (default) or line, `pace` s for each "
        "rad of the way, `speed` a share of the limits. When nobody follows it any more it stops on the path",
        true},
       move},
      {{"events",
        {{"since", kNumber}},
        "[{number, event, time_s, …}]",
        "tell what happens: lines, logs, questions, tags, states, stops, problems and notes, those after "
        "number `since` (0: all that are kept) first",
        false},
       events},
      {{"program",
        {{"data", kFlag}},
        kProgram,
        "where the program stands (none, ready, running, waiting, finished, stopped or failed): tasks, "
        "calls, "
        "variables, what moves use; with `data` also every value that it can read",
        false},
       program_state},
      {{"program.load",
        {{"file", kText, true}},
        "as of program, and {warnings}",
        "read a script, or a data file that names one, with its data as the files are now, and check it; the "
        "program that there is has not begun or has ended. It stands ready, and the cell goes on when it has "
        "ended",
        false},
       program_load},
      {{"program.start",
        {{"passes", kNumber}, {"paused", kFlag}},
        kProgram,
        "begin the program that stands ready; `passes` ends its outermost while after so many, `paused` in "
        "front of its first line",
        true},
       program_start},
      {{"program.answer", {{"text", kText}}, "{asked}", "answer what the program asks", false},
       program_answer},
      {{"program.watch",
        {{"rate", kNumber}},
        kProgram,
        "the same whenever it has changed, at most `rate` times a second (10)",
        false},
       program_watch},
      {{"program.pause",
        {{"at_once", kFlag}},
        kProgram,
        "pause in front of the next statement; motion that is queued goes on; answered when it stands, or "
        "`at_once`",
        true},
       program_pause},
      {{"program.go", {}, kProgram, "go on after a pause", true}, program_go},
      {{"program.step",
        {{"how", kText}, {"at_once", kFlag}},
        kProgram,
        "one statement of the task that is paused: `into` functions, `over` them (otherwise) or `out` of "
        "this "
        "one; answered when it stands again, or `at_once`",
        true},
       program_step},
      {{"program.break",
        {{"at", kNames}, {"clear", kFlag}},
        "{breakpoints: [{file, line}]}",
        "pause in front of these lines, LINE or FILE:LINE, besides those there are; with `clear` of those no "
        "more",
        false},
       program_break},
      {{"program.from",
        {{"line", kNumber}, {"program", kText}, {"confirmed", kFlag}},
        "{where, source, robot, tool, frame, last_point, sets, reads, variables, held, next}",
        "a program that has ended or is paused begins anew at `line` (1), read from its file: told is what "
        "it takes for "
        "given; it waits for program.go unless `confirmed`",
        true},
       program_from},
      {{"program.stop",
        {},
        kProgram,
        "end the program where it is: moves end on their paths, and its `on stop` is done",
        true},
       program_stop},
      {{"record", {}, kRecord, "whether the cell is recorded, and what that has come to", false},
       record_state},
      {{"record.start",
        {{"file", kText}, {"rate", kNumber}},
        kRecord,
        "record into a file of this name in .state/recordings of the cell, `rate` times a second (100)",
        false},
       record_start},
      {{"record.stop", {}, kRecord, "close the recording", false}, record_stop},
  };
  return table;
}

/// The whole table.
const std::vector<Row>& rows() {
  static const std::vector<Row> table = [] {
    std::vector<Row> out = running_rows();
    out.insert(out.end(), project_rows().begin(), project_rows().end());
    return out;
  }();
  return table;
}

Json error_json(const Error& error) {
  Json all = Json::array();
  for (const Problem& problem : error.problems())
    all.push_back({{"code", problem.code},
                   {"what", problem.what},
                   {"advice", problem.advice},
                   {"where", problem.where.text()}});
  Json out = all.front();
  if (all.size() > 1) out["all"] = all;
  return out;
}

}  // namespace

const std::vector<RequestInfo>& request_table() {
  static const std::vector<RequestInfo> table = [] {
    std::vector<RequestInfo> out;
    for (const Row& row : rows()) out.push_back(row.info);
    return out;
  }();
  return table;
}

const char* name(ArgumentType type) {
  constexpr const char* kTypes[] = {"text", "number", "flag", "names", "map", "message", "any"};
  return kTypes[static_cast<std::size_t>(type)];
}

std::string request_reference() {
  std::string out = "| request | arguments | result | what it does | may move |\n|---|---|---|---|---|\n";
  for (const RequestInfo& info : request_table()) {
    std::vector<std::string> arguments;
    for (const RequestArgument& a : info.arguments)
      arguments.push_back("`" + std::string(a.name) + "`" + (a.needed ? "" : "?") + ": " + name(a.type));
    out += "| `" + std::string(info.name) + "` | " + join(arguments, ", ") + " | `" + info.result + "` | " +
           info.text + " | " + (info.moves ? "yes" : "") + " |\n";
  }
  return out;
}

std::string text_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || !found->is_string())
    throw Error("bad-argument", std::string("the request needs the text '") + name + "'");
  return found->get<std::string>();
}

std::string text_argument(const Json& arguments, const char* name, const std::string& fallback) {
  return arguments.contains(name) ? text_argument(arguments, name) : fallback;
}

std::vector<std::string> list_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || found->is_null()) return {};
  std::vector<std::string> out;
  if (found->is_string()) out.push_back(found->get<std::string>());
  if (found->is_array())
    for (const Json& item : *found)
      if (item.is_string()) out.push_back(item.get<std::string>());
  if (out.size() != (found->is_array() ? found->size() : 1))
    throw Error("bad-argument", std::string("'") + name + "' is no list of names");
  return out;
}

bool flag_argument(const Json& arguments, const char* name) {
  const auto found = arguments.find(name);
  return found != arguments.end() && found->is_boolean() && found->get<bool>();
}

double number_argument(const Json& arguments, const char* name, double fallback) {
  const auto found = arguments.find(name);
  if (found == arguments.end() || found->is_null()) return fallback;
  if (!found->is_number()) throw Error("bad-argument", std::string("'") + name + "' is no number");
  return found->get<double>();
}

Poll then_with(Poll first, std::function<Poll(Cell&, Json)> second) {
  return [first = std::move(first), second = std::move(second), next = Poll{}](Cell& cell) mutable {
    if (next) return next(cell);
    Progress progress = first(cell);
    if (!progress.over) return Progress{};
    next = second(cell, progress.answer ? std::move(*progress.answer) : Json());
    return next(cell);
  };
}

Poll then(Poll first, std::function<Poll(Cell&)> second) {
  return then_with(std::move(first),
                   [second = std::move(second)](Cell& cell, const Json&) { return second(cell); });
}

namespace {

/// Brackets outside texts nested deeper than anything a request has: copying and printing JSON recurses.
bool too_deep(const std::string& line) {
  constexpr int kDeepest = 64;
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kDeepest) return true;
  }
  return false;
}

bool fits(const Json& value, ArgumentType type) {
  const auto is_text = [](const Json& item) { return item.is_string(); };
  switch (type) {
    case ArgumentType::text:
      return value.is_string();
    case ArgumentType::number:
      return value.is_number() && std::isfinite(value.get<double>());
    case ArgumentType::flag:
      return value.is_boolean();
    case ArgumentType::names:
      return value.is_string() || (value.is_array() && std::all_of(value.begin(), value.end(), is_text));
    case ArgumentType::map:
      return value.is_object();
    case ArgumentType::message:
      return value.is_string() || value.is_structured() || value.is_number();
    case ArgumentType::any:
      return true;
  }
  return false;
}

/// Every argument must be one that the request has, of its type, and none that is needed may be missing.
void check_arguments(const Json& request, const RequestInfo& info) {
  std::vector<std::string> known;
  for (const RequestArgument& a : info.arguments) {
    known.emplace_back(a.name);
    const auto found = request.find(a.name);
    if (found == request.end() || found->is_null()) {
      if (!a.needed) continue;
      throw Error("bad-argument", std::string(info.name) + " needs '" + a.name + "' (" + name(a.type) + ")");
    }
    if (!fits(*found, a.type))
      throw Error("bad-argument", std::string("'") + a.name + "' of " + info.name + " is no " + name(a.type));
  }
  for (const auto& [key, value] : request.items())
    if (key != "request" && key != "id" && std::find(known.begin(), known.end(), key) == known.end())
      throw Error("bad-argument",
                  std::string(info.name) + " has no argument '" + key + "'" + did_you_mean(key, known),
                  known.empty() ? "it takes none" : "it takes " + join(known, ", "));
}

Json parse_request(const std::string& line) {
  const char* example = "for example {\"request\": \"control.list\"}";
  if (too_deep(line)) throw Error("bad-request", "the request is nested more than 64 deep", example);
  Json request = Json::parse(line, nullptr, false);
  if (request.is_discarded() || !request.is_object())
    throw Error("bad-request", "a request is one JSON object a line", example);
  return request;
}

const Row& row_of(const Json& request) {
  const std::string wanted = text_argument(request, "request");
  std::vector<std::string> known;
  for (const Row& row : rows()) {
    if (wanted == row.info.name) return row;
    known.emplace_back(row.info.name);
  }
  throw Error("unknown-request", "there is no request '" + wanted + "'" + did_you_mean(wanted, known),
              "`help` lists them");
}

}  // namespace

class Requests::Work {
 public:
  explicit Work(Cell& cell) : cell_(cell) {}

  void handle(const std::string& line, Answer answer, const void* from) {
    Open open;
    open.answer = std::move(answer);
    open.from = from;
    guarded(open, [&] {
      open.request = parse_request(line);
      if (const auto id = open.request.find("id"); id != open.request.end()) open.id = *id;
      open.row = &row_of(open.request);
      check_arguments(open.request, open.row->info);
      if (open_.size() >= kMostOpen)
        throw Error("busy", "more than " + std::to_string(kMostOpen) + " requests are open",
                    "wait for answers, or end what goes on");
    });
    // A refusal waits for its turn, too; a stop never waits.
    const bool urgent = open.row && (open.row->handler == control_hold || open.row->handler == control_stop);
    if (!urgent && open_.size() < 2 * kMostOpen && must_wait(open_.size(), from))
      return open_.push_back(std::move(open));
    if (!advance(open)) open_.push_back(std::move(open));
  }

  void tick() {
    for (std::size_t i = 0; i < open_.size(); ++i)
      if (open_[i].begun || !must_wait(i, open_[i].from)) open_[i].over = advance(open_[i]);
    std::erase_if(open_, [](const Open& open) { return open.over; });
  }

  std::size_t open() const { return open_.size(); }

 private:
  struct Open {
    Json id, request;
    const Row* row = nullptr;
    Answer answer;
    const void* from = nullptr;
    Poll poll;
    std::optional<Json> refused;  // to be told when it is its turn
    bool begun = false, answered = false, over = false;
  };

  /// Has somebody before place `i` from the same asker not been answered yet?
  bool must_wait(std::size_t i, const void* from) const {
    if (!from) return false;
    for (std::size_t k = 0; k < i; ++k)
      if (open_[k].from == from && !open_[k].answered && !open_[k].over) return true;
    return false;
  }

  /// Runs `step`; what it throws becomes the refusal of the request.
  template <typename Step>
  static void guarded(Open& open, Step step) {
    try {
      step();
    } catch (const Error& e) {
      open.refused = error_json(e);
    } catch (...) {
      open.refused = error_json(Error("internal", "unexpected: " + what_was_thrown()));
    }
  }

  static bool send(Open& open, Json line) {
    open.answered = true;
    if (!open.id.is_null()) line["id"] = open.id;
    return open.answer(line.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  /// True when it is over.
  bool advance(Open& open) {
    Progress progress;
    guarded(open, [&] {
      if (open.refused) return;
      if (!std::exchange(open.begun, true)) open.poll = open.row->handler(cell_, open.request);
      progress = open.poll(cell_);
    });
    if (open.refused) {
      send(open, {{"ok", false}, {"error", *open.refused}});
      return true;
    }
    if (!progress.answer) return progress.over;
    Json line{{"ok", true}, {"result", std::move(*progress.answer)}};
    if (!progress.over) line["more"] = true;
    return !send(open, std::move(line)) || progress.over;
  }

  Cell& cell_;
  std::vector<Open> open_;
};

Requests::Requests(Cell& cell) : work_(std::make_unique<Work>(cell)) {}
Requests::~Requests() = default;
void Requests::handle(const std::string& line, Answer answer, const void* from) {
  work_->handle(line, std::move(answer), from);
}
void Requests::tick() {
  work_->tick();
}
std::size_t Requests::open() const {
  return work_->open();
}

}  // namespace polyarm::cell
