/// Requests about the program of a cell: where it stands, and stepping it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/problem_json.hpp"
#include "polyarm/cell/program_hash.hpp"
#include "polyarm/cell/requests_later.hpp"
#include "polyarm/cell/requests_work.hpp"
#include "polyarm/cell/ways.hpp"
#include "polyarm/program/lexer.hpp"

namespace polyarm::cell {

namespace {

Task& program_of(Cell& cell) {
  if (!cell.program()) throw Error("no-program", "this cell has no program");
  return *cell.program();
}

Json shown_place(const Location& where) {
  return {{"file", where.file}, {"line", where.line}};
}

Json shown_places(const std::vector<Location>& places) {
  Json out = Json::array();
  for (const Location& each : places) out.push_back(shown_place(each));
  return out;
}

const char* waits_for(program::WaitKind kind) {
  static constexpr const char* kNames[] = {"",     "time",   "condition", "move",  "person",
                                           "load", "motion", "room",      "until", "meet",
                                           "lock", "tasks",  "next turn"};
  return kNames[static_cast<std::size_t>(kind)];
}

Json task_json(const program::Interpreter& interpreter, const program::TaskStatus& status) {
  Json variables = Json::array(), calls = Json::array();
  for (const program::VariableValue& each : interpreter.variables(status.name))
    variables.push_back({{"name", each.name}, {"value", each.value.text()}});
  for (const Location& call : interpreter.calls(status.name)) calls.push_back(shown_place(call));
  const program::MoveDefaults use = interpreter.uses(status.name);
  Json out{{"name", status.name},
           {"state", program::name(status.state)},
           {"where", shown_place(status.where)},
           {"source", status.source},
           {"waits_for", waits_for(status.waiting.kind)},
           {"names", status.waiting.names},
           {"text", status.waiting.text},
           {"passes", status.cycles},
           {"paused", status.paused},
           {"calls", calls},
           {"variables", variables},
           {"robot", use.robot},
           {"tool", use.tool},
           {"frame", use.frame}};
  if (status.problem) out["problem"] = status.problem->text();
  return out;
}

/// Of the cell, whether it has a program or not.
Json surroundings(Cell& cell) {
  Json robots = Json::array();
  for (const auto& robot : cell.robots()) robots.push_back(robot->entry.name);
  return {{"state", "none"},
          {"control", control::name(cell.snapshot().state)},
          {"cause", control::name(cell.snapshot().cause)},
          {"holder", cell.control_holder()},
          {"folder", std::filesystem::weakly_canonical(cell.file().folder).string()},
          {"robots", robots},
          {"held", cell.held_parts()},
          {"events", cell.events().last()},
          {"file", ""},
          {"hash", ""},
          {"paused", false},
          {"where", shown_place({})},
          {"source", ""},
          {"sentence", ""},
          {"passes", 0},
          {"breakpoints", shown_places(cell.breakpoints())},
          {"tasks", Json::array()},
          {"question", Json()},
          {"problem", Json()}};
}

}  // namespace

Json program_json(Cell& cell) {
  Json out = surroundings(cell);
  if (!cell.program()) return out;
  const Task& task = program_of(cell);
  const program::Interpreter& interpreter = task.interpreter();
  Json tasks = Json::array();
  for (const program::TaskStatus& status : interpreter.status())
    tasks.push_back(task_json(interpreter, status));
  const program::TaskStatus& status = task.status();
  const bool asks = cell.program_begun() && status.waiting.kind == program::WaitKind::user;
  out.update({{"file", interpreter.program().file},
              {"hash", cell.program_begun() ? "" : program_hash(interpreter.program())},
              {"state", cell.program_begun() ? program::name(interpreter.state()) : "ready"},
              {"paused", interpreter.paused()},
              {"where", shown_place(status.where)},
              {"source", status.source},
              {"sentence", task.sentence()},
              {"passes", status.cycles},
              {"tasks", tasks},
              {"question", asks ? Json(status.waiting.text) : Json()},
              {"problem", status.problem ? problem_json(*status.problem) : Json()}});
  return out;
}

namespace {

void require_running(Cell& cell, const Task& task) {
  if (!cell.program_begun()) throw Error("not-begun", "the program has not begun", "begin it: program.start");
  if (task.ended())
    throw Error("has-ended", std::string("the program has ended: ") + program::name(task.status().state),
                "polyarm control from LINE begins it anew");
}

/// Until it stands in front of a statement, or has ended; with `at_once` nobody waits for that.
Poll until_paused(const Json& arguments) {
  return [at_once = flag_argument(arguments, "at_once")](Cell& cell) {
    Task& task = program_of(cell);
    const bool on_its_way = !task.interpreter().paused() && !task.ended();
    if (!at_once && on_its_way && !why_no_statement(cell)) return Progress{};
    return Progress::done(program_json(cell));
  };
}

}  // namespace

Json assumed(Cell& cell, const program::StartReport& report) {
  const auto valued = [&](const std::vector<std::string>& names) {
    Json out = Json::array();
    for (const std::string& name : names)
      if (const data::Value* value = cell.store().find(name))
        if (!value->is_place()) out.push_back({{"name", name}, {"value", value->text()}});
    return out;
  };
  Json variables = Json::array();
  for (const program::VariableValue& each :
       program_of(cell).interpreter().variables(program_of(cell).status().name))
    variables.push_back({{"name", each.name}, {"value", each.value.text()}});
  return {{"where", shown_place(report.where)},
          {"source", program_of(cell).status().source},
          {"robot", report.robot},
          {"tool", report.tool},
          {"frame", report.frame},
          {"last_point", report.last_point},
          {"sets", valued(report.sets)},
          {"reads", valued(report.reads)},
          {"variables", variables},
          {"held", cell.held_parts()}};
}

namespace {

Poll program_state(Cell& cell, const Json& arguments) {
  Json out = program_json(cell);
  if (!flag_argument(arguments, "data")) return at_once(std::move(out));
  Json data = Json::object();
  for (const std::string& name : cell.store().names()) data[name] = cell.store().find(name)->text();
  out["data"] = std::move(data);
  return at_once(std::move(out));
}

Poll program_watch(Cell& cell, const Json& arguments) {
  const double rate = number_argument(arguments, "rate", 10);
  if (!(rate > 0)) throw Error("bad-argument", "'rate' must be above 0");
  const auto between = static_cast<Nanoseconds>(1e9 / std::min(rate, 500.0));
  return [between, next = Nanoseconds{0}, told = std::string{}](Cell& c) mutable {
    if (c.now() < next) return Progress{};
    next = c.now() + between;
    Json now = program_json(c);
    std::string text = now.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text == told) return Progress{};
    told = std::move(text);
    return Progress::more(std::move(now));
  };
}

Poll program_pause(Cell& cell, const Json& arguments) {
  Task& task = program_of(cell);
  require_running(cell, task);
  if (!task.interpreter().paused()) task.interpreter().pause();
  return until_paused(arguments);
}

Poll program_go(Cell& cell, const Json&) {
  Task& task = program_of(cell);
  require_running(cell, task);
  if (!task.interpreter().paused())
    throw Error("not-paused", "the program is not paused", "a hold is left by polyarm control resume");
  if (const auto why = why_no_statement(cell)) throw Error(*why);
  task.interpreter().resume();
  return at_once(program_json(cell));
}

Poll program_step(Cell& cell, const Json& arguments) {
  Task& task = program_of(cell);
  require_running(cell, task);
  const std::string how = text_argument(arguments, "how", "over");
  const std::vector<std::string> known = {"into", "over", "out"};
  const auto at = std::find(known.begin(), known.end(), how);
  if (at == known.end())
    throw Error("bad-argument", "there is no step '" + how + "'" + did_you_mean(how, known),
                "into, over or out");
  if (!task.interpreter().paused())
    throw Error("not-paused", "the program is not paused", "polyarm control pause, or a breakpoint");
  if (const auto why = why_no_statement(cell)) throw Error(*why);
  task.interpreter().resume_for(static_cast<program::StepKind>(at - known.begin()));
  return until_paused(arguments);
}

/// LINE of the program there is, or FILE:LINE.
Location breakpoint_at(Cell& cell, const std::string& text) {
  const auto colon = text.rfind(':');
  const std::string number = colon == std::string::npos ? text : text.substr(colon + 1);
  const auto line = parse_number(number);
  if (!line || *line < 1 || *line > 1e6 || *line != std::floor(*line))
    throw Error("bad-argument", "'" + text + "' is no line", "write LINE or FILE:LINE");
  const std::string file =
      colon == std::string::npos ? program_of(cell).interpreter().program().file : text.substr(0, colon);
  return {file, static_cast<int>(*line), 0};
}

/// The lines of the text that an argument holds; none where it is not there.
std::optional<TextLines> lines_argument(const Json& arguments, const char* name) {
  if (!arguments.contains(name)) return {};
  return program::split_lines(text_argument(arguments, name));
}

Poll program_break(Cell& cell, const Json& arguments) {
  std::vector<Location> added, dropped;
  const std::optional<TextLines> text = lines_argument(arguments, "text");
  for (const std::string& at : list_argument(arguments, "at")) added.push_back(breakpoint_at(cell, at));
  for (const std::string& off : list_argument(arguments, "off")) dropped.push_back(breakpoint_at(cell, off));
  if (cell.breakpoints().size() + added.size() > bounds::kBreakpoints)
    throw Error("too-many", "there may be " + std::to_string(bounds::kBreakpoints) + " breakpoints",
                "drop some first: program.break with 'off' or 'clear'");
  for (const Location& each : dropped) cell.drop_breakpoint(each, text);
  if (flag_argument(arguments, "clear")) cell.clear_breakpoints();
  for (const Location& each : added) cell.add_breakpoint(each, text);
  return at_once({{"breakpoints", shown_places(cell.breakpoints())}});
}

Poll program_edited(Cell& cell, const Json& arguments) {
  const std::string text = text_argument(arguments, "text");
  std::optional<std::vector<int>> lines;
  if (arguments.contains("lines")) {
    lines.emplace();
    for (const Json& each : arguments["lines"]) {
      const double line = each.is_number() ? each.get<double>() : 0;
      if (line < 1 || line > 1e6 || line != std::floor(line))
        throw Error("bad-argument", "'lines' is no list of lines", "numbers from 1 on");
      lines->push_back(static_cast<int>(line));
    }
  }
  cell.edit_breakpoints(text_argument(arguments, "name"), program::split_lines(text), lines);
  return at_once({{"breakpoints", shown_places(cell.breakpoints())}});
}

Error changed_since_shown(const std::string& name) {
  return Error("program-changed", "'" + name + "' was changed since it was shown", "look at it, and start it then");
}

/// What somebody was shown of the script that is to begin: its file and lines.
struct Shown {
  std::filesystem::path file;
  TextLines lines;
};

/// Where its `hash`, as files.read told it, is given. Throws Error where the file has changed since.
std::optional<Shown> as_shown(Cell& cell, const Json& arguments) {
  const std::string hash = text_argument(arguments, "hash", "");
  if (hash.empty()) return {};
  const std::string name = text_argument(arguments, "program", "");
  Shown out{project_file(cell.file().folder, name), {}};
  const std::string text = read_file(out.file);
  if (content_hash(text) != hash) throw changed_since_shown(name);
  out.lines = program::split_lines(text);
  return out;
}

/// It was read after it was looked at: another text stands paused, and goes nowhere.
void require_read_as_shown(const Shown& shown, const program::Program& read) {
  std::error_code error;
  if (std::filesystem::equivalent(shown.file, read.file, error) && read.lines != shown.lines)
    throw changed_since_shown(shown.file.filename().string());
}

Poll program_from(Cell& cell, const Json& arguments) {
  const double line = number_argument(arguments, "line", 0);
  if (!cell.arming().armed())  // else it would begin by itself as soon as somebody arms the cell
    throw Error("disarmed", "no program begins: real hardware that nobody has armed", "polyarm control arm");
  const Task* const task = cell.program();
  const bool runs = task && cell.program_begun() && !task->ended() && !task->interpreter().paused();
  if (const auto why = why_no_statement(cell); why && (runs || !cell.all_idle()))  // neither pauses nor arrives
    throw Error(why->code, why->what,
                why->code == "held" ? "polyarm control resume, then polyarm control pause; or end it: program.stop"
                                    : why->advice);
  if (runs)
    throw Error("still-running", "the program is running: " + task->sentence(), "polyarm control pause");
  if (!cell.snapshot().standing || !cell.all_idle())
    throw Error("moving", "a robot still moves", "wait until it has arrived");
  const std::optional<Shown> shown = as_shown(cell, arguments);
  const program::StartReport report =
      cell.prepare_program(text_argument(arguments, "program", ""), static_cast<int>(line));
  if (shown) require_read_as_shown(*shown, cell.program()->interpreter().program());
  Json out = assumed(cell, report);
  if (!flag_argument(arguments, "confirmed"))
    out["next"] = "the program stands in front of this line: program.go";
  if (flag_argument(arguments, "confirmed")) cell.program()->interpreter().resume();
  if (const auto why = why_no_statement(cell)) out["next"] = why->what + ": " + why->advice;
  return at_once(std::move(out));
}

Poll program_stop(Cell& cell, const Json&) {
  Task& task = program_of(cell);
  require_running(cell, task);
  cell.end_program();
  return [asked = cell.now()](Cell& c) {  // what it does on stop waits until its robots stand
    constexpr Nanoseconds kPatience = 2'000'000'000;
    Task& ending = program_of(c);
    const bool held = c.snapshot().state != control::RunState::running;
    if (held && !ending.ended()) ending.tick();  // a cell that is held does not, and nothing else is left
    const bool waits = !ending.ended() && c.now() - asked < kPatience;
    return waits ? Progress{} : Progress::done(program_json(c));
  };
}

}  // namespace

const std::vector<RequestRow>& program_rows() {
  static const std::vector<RequestRow> table = {
      {{"program",
        {{"data", kFlag}},
        kProgram,
        "where the program stands (none, ready, running, waiting, finished, stopped or failed): tasks, "
        "calls, "
        "variables, what moves use; with `data` also every value that it can read",
        false},
       program_state},
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
        {{"at", kNames}, {"off", kNames}, {"clear", kFlag}, {"text", kText}},
        "{breakpoints: [{file, line}]}",
        "pause in front of the lines `at`, LINE or FILE:LINE, besides those there are, and no more at those "
        "of "
        "`off`, or with `clear` at none before; a script of the cell that is not begun yet keeps its own for "
        "its start; `text`: what the lines are lines of, where that is not what the program has read",
        false},
       program_break},
      {{"program.edited",
        {{"name", kText, true}, {"text", kText, true}, {"lines", kAny}},
        "{breakpoints: [{file, line}]}",
        "the script `name` reads `text` now, saved or not: its breakpoints go with their lines, or stand at "
        "`lines` of it; a program that runs keeps its text and pauses at the same lines in there",
        false},
       program_edited},
      {{"program.from",
        {{"line", kNumber}, {"program", kText}, {"confirmed", kFlag}, {"hash", kText}},
        "{where, source, robot, tool, frame, last_point, sets, reads, variables, held, next}",
        "a program that has ended or is paused begins anew at `line` (its first), read from its file: told "
        "is "
        "what it takes for given; it waits for program.go unless `confirmed`. Refused as program-changed where "
        "`program`, a script, has not the `hash` that `files.read` told",
        true},
       program_from},
      {{"program.stop",
        {},
        kProgram,
        "end the program where it is: moves end on their paths, and its `on stop` is done",
        true},
       program_stop},
  };
  return table;
}

}  // namespace polyarm::cell
