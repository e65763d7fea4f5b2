#include "polyarm/operation/program_status.hpp"

#include <filesystem>

#include "polyarm/operation/jog_commands.hpp"
#include "polyarm/tasks/program_hash.hpp"

namespace polyarm::cell {

using namespace protocol;

FileLine file_line(const Location& where) {
  return {where.file, where.line};
}

std::vector<FileLine> file_lines(const std::vector<Location>& places) {
  std::vector<FileLine> out;
  for (const Location& each : places) out.push_back(file_line(each));
  return out;
}

std::vector<NamedText> named_texts(const std::vector<program::VariableValue>& values) {
  std::vector<NamedText> out;
  for (const program::VariableValue& each : values) out.push_back({each.name, each.value.text()});
  return out;
}

namespace {

/// The link whose first connection all programs wait for; empty if they may run.
std::string awaited_link(const CellData& data) {
  if (data.links_ready()) return {};
  for (const CellLinks::Status& link : data.links().status())
    if (!link.state.was_up && link.entry->on_loss == signals::LinkEntry::OnLoss::hold)
      return link.entry->name;
  return {};
}

/// What a program that has begun shows while it waits for its links.
const char* const kWaiting = program::name(program::TaskState::waiting);

const char* waits_for(program::WaitKind kind) {
  static constexpr const char* kNames[] = {"",     "time",   "condition", "move",  "person",
                                           "load", "motion", "room",      "until", "meet",
                                           "lock", "tasks",  "next turn"};
  return kNames[static_cast<std::size_t>(kind)];
}

TaskFacts facts_of(const program::Interpreter& interpreter, const program::TaskStatus& status) {
  const program::MoveDefaults use = interpreter.uses(status.name);
  TaskFacts out{.name = status.name,
                .state = program::name(status.state),
                .where = file_line(status.where),
                .source = status.source,
                .waits_for = waits_for(status.waiting.kind),
                .names = status.waiting.names,
                .text = status.waiting.text,
                .passes = status.cycles,
                .paused = status.paused,
                .calls = file_lines(interpreter.calls(status.name)),
                .variables = named_texts(interpreter.variables(status.name)),
                .robot = use.robot,
                .tool = use.tool,
                .frame = use.frame,
                .problem = {}};
  if (status.problem) out.problem = status.problem->text();
  return out;
}

/// The part of the status that also applies to a cell without a program.
ProgramStatus surroundings(const StatusOwners& cell) {
  ProgramStatus out;
  out.state = "none";
  out.control = control::name(cell.machine.snapshot().state);
  out.cause = control::name(cell.machine.snapshot().cause);
  out.holder = control_holder(cell.programs, cell.jogging);
  out.folder = std::filesystem::weakly_canonical(cell.setup.file.folder).string();
  for (const auto& robot : cell.setup.robots) out.robots.push_back(robot->entry.name);
  out.held = cell.programs.held_parts();
  out.events = cell.events.last();
  out.breakpoints = file_lines(cell.programs.breakpoints());
  return out;
}

}  // namespace

namespace {
/// Path relative to the cell's folder if the file is inside it; otherwise unchanged.
std::string name_in(const std::filesystem::path& folder, const std::string& file) {
  const auto inside = std::filesystem::path(file).lexically_relative(folder);
  return inside.empty() || inside.string().starts_with("..") ? file : inside.generic_string();
}
}  // namespace

ProgramOverview program_overview(const CellSetup& setup, const Task& task, bool begun, const CellData& data) {
  const program::Interpreter& interpreter = task.interpreter();
  const program::TaskStatus& status = task.status();
  ProgramOverview out;
  out.state = begun ? program::name(interpreter.state()) : "ready";
  out.file = interpreter.program().file;
  out.name = name_in(setup.file.folder, out.file);
  if (!begun) out.hash = program_hash(interpreter.program());
  out.paused = interpreter.paused();
  out.ended = task.ended();
  out.where = file_line(status.where);
  out.source = status.source;
  out.sentence = task.sentence();
  out.passes = status.cycles;
  if (const auto took = task.last_pass()) out.last_pass_s = seconds(*took);
  if (const auto& problem = status.problem)
    out.problem.emplace(problem_facts(*problem));
  if (const std::string link = awaited_link(data); begun && !out.ended && !link.empty())
    out.state = kWaiting, out.sentence = "waits for the link '" + link + "'";
  return out;
}

ProgramStatus program_status(const StatusOwners& cell) {
  ProgramStatus out = surroundings(cell);
  if (!cell.programs.program()) return out;
  const Task& task = *cell.programs.program();
  static_cast<ProgramOverview&>(out) = program_overview(cell.setup, task, cell.programs.begun(), cell.data);
  for (const program::TaskStatus& each : task.interpreter().status())
    out.tasks.push_back(facts_of(task.interpreter(), each));
  if (const std::string link = awaited_link(cell.data); cell.programs.begun() && !link.empty())
    for (TaskFacts& each : out.tasks)
      if (each.state == program::name(program::TaskState::running))
        each.state = kWaiting, each.waits_for = "link", each.text = link;
  const program::Waiting& waiting = task.status().waiting;
  if (cell.programs.begun() && waiting.kind == program::WaitKind::user)
    out.question = waiting.text + (waiting.note.empty() ? "" : "\n" + waiting.note);
  return out;
}

}  // namespace polyarm::cell
