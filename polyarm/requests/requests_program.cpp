/// Requests about the program of a cell: its status, pausing, stepping and starting at a line.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/inside/requests_later.hpp"
#include "polyarm/inside/requests_work.hpp"
#include "polyarm/inside/ways.hpp"
#include "polyarm/language/lexer.hpp"
#include "polyarm/operation/program_status.hpp"
#include "polyarm/requests/families.hpp"

namespace polyarm::cell {

namespace {

using namespace protocol;

/// The parts of the cell that requests about the program need.
struct ProgramOwners {
  const CellSetup& setup;
  Machine& machine;
  const CellData& data;
  Motions& motions;
  Programs& programs;
  const Jogging& jogging;
  const Arming& arming;
  const LifeCycle& life;
  const EventLog& events;
};

Task& program_of(const ProgramOwners& cell) {
  if (!cell.programs.program()) throw Error("no-program", "this cell has no program");
  return *cell.programs.program();
}

void require_running(const ProgramOwners& cell, const Task& task) {
  if (!cell.programs.begun())
    throw Error("not-begun", "the program has not begun", "begin it: program.start");
  if (task.ended())
    throw Error("has-ended", std::string("the program has ended: ") + program::name(task.status().state),
                "polyarm control from LINE starts it again");
}

/// Waits until the program has paused before a statement or has ended; with `at_once` it does not wait.
Poll<ProgramStatus> until_paused(const ProgramOwners& cell, bool at_once) {
  return [cell, at_once] {
    const Task& task = program_of(cell);
    const bool on_its_way = !task.interpreter().paused() && !task.ended();
    if (!at_once && on_its_way && !why_no_statement(cell.machine, cell.arming, cell.life))
      return Progress<ProgramStatus>{};
    return Progress<ProgramStatus>::done(
        program_status({cell.setup, cell.machine, cell.programs, cell.jogging, cell.events, cell.data}));
  };
}

/// What a program that starts in the middle assumes.
ProgramFrom::Answer assumed(const ProgramOwners& cell, const program::StartReport& report) {
  const Task& task = program_of(cell);
  const auto valued = [&](const std::vector<std::string>& names) {
    std::vector<NamedText> out;
    for (const std::string& name : names)
      if (const data::Value* value = cell.data.store.find(name))
        if (!value->is_place()) out.push_back({name, value->text()});
    return out;
  };
  return {.where = file_line(report.where),
          .source = task.status().source,
          .robot = report.robot,
          .tool = report.tool,
          .frame = report.frame,
          .last_point = report.last_point,
          .sets = valued(report.sets),
          .reads = valued(report.reads),
          .variables = named_texts(task.interpreter().variables(task.status().name)),
          .held = cell.programs.held_parts(),
          .next = {}};
}

ProgramState::Answer program_state(const ProgramOwners& cell, const ProgramState& request) {
  ProgramState::Answer out{
      program_status({cell.setup, cell.machine, cell.programs, cell.jogging, cell.events, cell.data}), {}};
  if (!request.data) return out;
  out.data.emplace();
  for (const std::string& name : cell.data.store.names())
    (*out.data)[name] = cell.data.store.find(name)->text();
  return out;
}

Poll<ProgramStatus> program_watch(const ProgramOwners& cell, const ProgramWatch& request) {
  const double rate = request.rate.value_or(10);
  if (!(rate > 0)) throw Error("bad-argument", "'rate' must be above 0");
  const auto between = static_cast<Nanoseconds>(1e9 / std::min(rate, 500.0));
  return [cell, between, next = Nanoseconds{0}, reported = Any{}]() mutable {
    if (cell.machine.now() < next) return Progress<ProgramStatus>{};
    next = cell.machine.now() + between;
    ProgramStatus now =
        program_status({cell.setup, cell.machine, cell.programs, cell.jogging, cell.events, cell.data});
    Any as_any = any_of(now);
    if (as_any == reported) return Progress<ProgramStatus>{};
    reported = std::move(as_any);
    return Progress<ProgramStatus>::more(std::move(now));
  };
}

Poll<ProgramStatus> program_pause(const ProgramOwners& cell, const ProgramPause& request) {
  Task& task = program_of(cell);
  require_running(cell, task);
  if (!task.interpreter().paused()) task.interpreter().pause();
  return until_paused(cell, request.at_once);
}

ProgramStatus program_go(const ProgramOwners& cell, const ProgramGo&) {
  Task& task = program_of(cell);
  require_running(cell, task);
  if (!task.interpreter().paused())
    throw Error("not-paused", "the program is not paused", "a hold is left by polyarm control resume");
  if (const auto why = why_no_statement(cell.machine, cell.arming, cell.life)) throw Error(*why);
  task.interpreter().resume();
  return program_status({cell.setup, cell.machine, cell.programs, cell.jogging, cell.events, cell.data});
}

Poll<ProgramStatus> program_step(const ProgramOwners& cell, const ProgramStep& request) {
  Task& task = program_of(cell);
  require_running(cell, task);
  if (!task.interpreter().paused())
    throw Error("not-paused", "the program is not paused", "polyarm control pause, or a breakpoint");
  if (const auto why = why_no_statement(cell.machine, cell.arming, cell.life)) throw Error(*why);
  switch (request.how.value_or(StepHow::over)) {
    case StepHow::into:
      task.interpreter().resume_for(program::StepKind::into);
      break;
    case StepHow::over:
      task.interpreter().resume_for(program::StepKind::over);
      break;
    case StepHow::out:
      task.interpreter().resume_for(program::StepKind::out);
      break;
  }
  return until_paused(cell, request.at_once);
}

/// Parses LINE (in the cell's program) or FILE:LINE.
Location breakpoint_at(const ProgramOwners& cell, const std::string& text) {
  const auto colon = text.rfind(':');
  const std::string number = colon == std::string::npos ? text : text.substr(colon + 1);
  const auto line = parse_number(number);
  if (!line || *line < 1 || *line > 1e6 || *line != std::floor(*line))
    throw Error("bad-argument", "'" + text + "' is not a line", "write LINE or FILE:LINE");
  const std::string file =
      colon == std::string::npos ? program_of(cell).interpreter().program().file : text.substr(0, colon);
  return {file, static_cast<int>(*line), 0};
}

std::optional<TextLines> lines_of(const std::optional<std::string>& text) {
  if (!text) return {};
  return program::split_lines(*text);
}

BreakpointList program_break(const ProgramOwners& cell, const ProgramBreak& request) {
  std::vector<Location> added, dropped;
  const std::optional<TextLines> text = lines_of(request.text);
  for (const std::string& at : request.at.value_or(Names{})) added.push_back(breakpoint_at(cell, at));
  for (const std::string& off : request.off.value_or(Names{})) dropped.push_back(breakpoint_at(cell, off));
  if (cell.programs.breakpoints().size() + added.size() > bounds::kBreakpoints)
    throw Error("too-many", "there may be " + std::to_string(bounds::kBreakpoints) + " breakpoints",
                "drop some first: program.break with 'off' or 'clear'");
  for (const Location& each : dropped) cell.programs.drop_breakpoint(each, text);
  if (request.clear) cell.programs.clear_breakpoints();
  for (const Location& each : added) cell.programs.add_breakpoint(each, text);
  return {file_lines(cell.programs.breakpoints())};
}

BreakpointList program_edited(const ProgramOwners& cell, const ProgramEdited& request) {
  std::optional<std::vector<int>> lines;
  if (request.lines) {
    lines.emplace();
    for (const nlohmann::json& each : request.lines->json()) {
      const double line = each.is_number() ? each.get<double>() : 0;
      if (line < 1 || line > 1e6 || line != std::floor(line))
        throw Error("bad-argument", "'lines' is not a list of lines", "numbers from 1 on");
      lines->push_back(static_cast<int>(line));
    }
  }
  cell.programs.edit_breakpoints(request.name, program::split_lines(request.text), lines);
  return {file_lines(cell.programs.breakpoints())};
}

Error changed_since_shown(const std::string& name) {
  return Error("program-changed", "'" + name + "' was changed since it was shown", "check it, then start it");
}

/// The script as the person saw it before starting it: its file and lines.
struct Shown {
  std::filesystem::path file;
  TextLines lines;
};

/// The script whose `hash`, as files.read reported it, was given; empty without a hash. Throws Error if the
/// file has changed since.
std::optional<Shown> as_shown(const ProgramOwners& cell, const ProgramFrom& request) {
  const std::string hash = request.hash.value_or("");
  if (hash.empty()) return {};
  const std::string name = request.program.value_or("");
  Shown out{project_file(cell.setup.file.folder, name), {}};
  const std::string text = read_file(out.file);
  if (content_hash(text) != hash) throw changed_since_shown(name);
  out.lines = program::split_lines(text);
  return out;
}

/// Throws if the program was read after the file changed again; the program then stays paused.
void require_read_as_shown(const Shown& shown, const program::Program& read) {
  std::error_code error;
  if (std::filesystem::equivalent(shown.file, read.file, error) && read.lines != shown.lines)
    throw changed_since_shown(shown.file.filename().string());
}

ProgramFrom::Answer program_from(const ProgramOwners& cell, const ProgramFrom& request) {
  const double line = request.line.value_or(0);
  if (!cell.arming.armed())  // otherwise it would start by itself as soon as somebody arms the cell
    throw Error("disarmed", "no program begins: the real hardware is not armed", "polyarm control arm");
  const Task* const task = cell.programs.program();
  const bool runs = task && cell.programs.begun() && !task->ended() && !task->interpreter().paused();
  if (const auto why = why_no_statement(cell.machine, cell.arming, cell.life);
      why && (runs || !cell.motions.all_idle()))  // in these states a program neither pauses nor arrives
    throw Error(why->code, why->what,
                why->code == "held" ? "polyarm control resume, then polyarm control pause; or end it: program.stop"
                                    : why->advice);
  if (runs)
    throw Error("still-running", "the program is running: " + task->sentence(), "polyarm control pause");
  if (!cell.machine.snapshot().standing || !cell.motions.all_idle())
    throw Error(
        "moving", "a robot still moves",
        "wait until it has arrived; one that follows a belt, or yields to forces, goes on until the program "
        "ends: program.stop");
  const std::optional<Shown> shown = as_shown(cell, request);
  const program::StartReport report =
      cell.programs.prepare(request.program.value_or(""), static_cast<int>(line));
  if (shown) require_read_as_shown(*shown, cell.programs.program()->interpreter().program());
  ProgramFrom::Answer out = assumed(cell, report);
  if (request.confirmed)
    cell.programs.program()->interpreter().resume();
  else
    out.next = "the program is paused before this line: program.go";
  if (const auto why = why_no_statement(cell.machine, cell.arming, cell.life))
    out.next = why->what + ": " + why->advice;
  return out;
}

Poll<ProgramStatus> program_stop(const ProgramOwners& cell, const ProgramStop&) {
  using Stopped = Progress<ProgramStatus>;
  Task& task = program_of(cell);
  require_running(cell, task);
  cell.programs.end();
  return [cell, asked = cell.machine.now()] {  // once its robots are at rest, its `on stop` runs
    constexpr Nanoseconds kTimeout = 2'000'000'000;
    Task& ending = program_of(cell);
    const bool held = cell.machine.snapshot().state != control::RunState::running;
    if (held && !ending.ended()) ending.tick();  // a held cell does not tick it
    const bool waits = !ending.ended() && cell.machine.now() - asked < kTimeout;
    return waits ? Stopped{}
                 : Stopped::done(program_status(
                       {cell.setup, cell.machine, cell.programs, cell.jogging, cell.events, cell.data}));
  };
}

}  // namespace

std::vector<Handler> program_handlers() {
  return handlers<program_state, program_watch, program_pause, program_go, program_step, program_break, program_edited,
                  program_from, program_stop>();
}

}  // namespace polyarm::cell
