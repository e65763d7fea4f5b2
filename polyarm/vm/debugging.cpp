#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "polyarm/vm/task.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

bool before(Place a, Place b) {
  return a.file != b.file ? a.file < b.file : a.line < b.line;
}
}  // namespace

/// True if the program pauses before the next statement of `task`.
bool Interpreter::stops_here(Task& task) {
  if (task.apart || code_.steps[task.pc].op == Op::pace) return false;
  if (std::exchange(resumed_, resumed_ == task.id ? 0 : resumed_) == task.id) return false;
  const Place line = code_.sources[task.pc].line;
  const bool stepped =
      stepping_ && stepping_->task == task.id && task.frames.size() <= stepping_->most_frames;
  const bool marked = std::any_of(breakpoints_.begin(), breakpoints_.end(), [&](const Place& place) {
    return place.line == line.line && place.file == line.file;
  });
  if (!pause_requested_ && !stepped && !marked) return false;
  pause_requested_ = false;
  stepping_.reset();
  paused_ = task.id;
  return true;
}

void Interpreter::pause_here() {
  paused_ = tasks_.front()->id;
}

void Interpreter::resume() {
  resumed_ = std::exchange(paused_, 0);
}

void Interpreter::resume_for(StepKind kind) {
  const Task* task = task_of(paused_);
  if (!task) return;
  const std::size_t frames = task->frames.size();
  const std::size_t most = kind == StepKind::into   ? std::numeric_limits<std::size_t>::max()
                           : kind == StepKind::over ? frames
                                                    : frames - 1;
  stepping_ = Stepping{task->id, most};
  resume();
}

namespace {

/// Matches a file by its path as read, or by the end of the path, as displayed.
bool is_called(const std::string& file, const std::string& name) {
  if (!file.ends_with(name)) return false;
  return file.size() == name.size() || (!name.empty() && file[file.size() - name.size() - 1] == '/');
}

}  // namespace

std::vector<Location> Interpreter::set_breakpoints(const std::vector<Location>& places) {
  breakpoints_.clear();
  std::vector<Location> out;
  for (const Location& wanted : places) {
    std::optional<Place> best;
    for (const Step& step : code_.steps) {
      const Place line = source(step).line;
      const bool fits =
          step.begins && is_called(program_.at(line).file, wanted.file) && line.line >= wanted.line;
      if (fits && (!best || before(line, *best))) best = line;
    }
    const auto same = [&](const Place& place) {
      return place.file == best->file && place.line == best->line;
    };
    if (!best || std::any_of(breakpoints_.begin(), breakpoints_.end(), same)) continue;
    breakpoints_.push_back(*best);
    out.push_back(program_.at(*best));
  }
  return out;
}

const std::vector<std::string>* Interpreter::lines_of(const std::string& name) const {
  if (is_called(program_.file, name)) return &program_.lines;
  const auto at = std::find_if(program_.included.begin(), program_.included.end(),
                               [&](const auto& each) { return is_called(each.file, name); });
  return at == program_.included.end() ? nullptr : &at->lines;
}

std::vector<Location> Interpreter::breakpoints() const {
  std::vector<Location> out;
  for (const Place& place : breakpoints_) out.push_back(program_.at(place));
  return out;
}

std::vector<VariableValue> Interpreter::variables(const std::string& task) const {
  std::vector<VariableValue> out;
  const auto at = std::find_if(tasks_.begin(), tasks_.end(), [&](const auto& t) { return t->name == task; });
  if (at != tasks_.end()) {
    const Task& found = **at;
    const int pc = static_cast<int>(found.pc);
    for (const VariableName& each : code_.variables) {
      const std::size_t slot = found.frames.back().base + static_cast<std::size_t>(each.slot);
      const bool holds = each.begin <= pc && (pc < each.end || each.end < 0) && !each.name.empty();
      if (holds && slot < found.stack.size() && found.stack[slot].set)
        out.push_back({each.name, found.stack[slot].value});
    }
  }
  for (std::size_t i = 0; i < globals_.size(); ++i)
    if (globals_[i].set) out.push_back({code_.globals[i], globals_[i].value});
  return out;
}

std::vector<Location> Interpreter::calls(const std::string& task) const {
  std::vector<Location> out;
  const auto at = std::find_if(tasks_.begin(), tasks_.end(), [&](const auto& t) { return t->name == task; });
  if (at == tasks_.end()) return out;
  const Task& found = **at;
  for (std::size_t i = 1; i < found.frames.size(); ++i)
    out.push_back(program_.at(code_.sources[found.frames[i].return_to - 1].line));
  out.push_back(program_.at(code_.sources[found.pc].line));
  return out;
}

// Start in the middle.

StartReport Interpreter::start_at(int line) {
  const auto here = [&](const StartingPoint& s) {
    return s.statement->place.line == line && s.statement->place.file == 0 && s.end > s.begin;
  };
  const auto start = std::find_if(code_.starts.begin(), code_.starts.end(), here);
  const Location where = program_.at({line, 0, 0});
  if (start == code_.starts.end()) {
    const bool begins = std::any_of(code_.steps.begin(), code_.steps.end(), [&](const Step& step) {
      return step.begins && source(step).line.line == line && source(step).line.file == 0;
    });
    throw Error(
        Problem{"no-start", where,
                begins ? "the program cannot begin here: the block around it makes what this line needs"
                       : "no statement begins in this line",
                begins ? "begin before the for, try, lock or function, or in front of the first `let` of "
                         "the block"
                       : ""});
  }
  StartReport out{where, {}, {}, {}, {}, {}, {}};
  run_prelude(*start);
  Task& task = *tasks_.front();
  if (task.uses.size() != static_cast<std::size_t>(start->uses))
    throw Error(Problem{"no-start", where,
                        "the program cannot begin here: a `use` of the block around it holds here",
                        "begin in front of that `use`"});
  task.pc = static_cast<std::size_t>(start->begin);
  if (!task.uses.empty()) {
    out.robot = task.uses.back().robot;
    out.tool = task.uses.back().tool;
    out.frame = task.uses.back().frame;
  }
  report_assumptions(*start, out);
  return out;
}

/// Executes the lines before `start` that create names, set move defaults, or watch.
void Interpreter::run_prelude(const StartingPoint& start) {
  constexpr int kMostSteps = 100000;
  Task& task = *tasks_.front();
  for (const StartingPoint& each : code_.starts) {
    const Kind kind = each.statement->kind;
    if (each.begin >= start.begin) break;
    const bool watches = kind == Kind::when || kind == Kind::trap || kind == Kind::every;
    if (!each.top || (kind != Kind::let && kind != Kind::use && !watches)) continue;
    task.pc = static_cast<std::size_t>(each.begin);
    for (int steps = 0; task.pc != static_cast<std::size_t>(each.end) || task.frames.size() > 1; ++steps) {
      execute(task);
      if (task.state == TaskState::running && steps < kMostSteps) continue;
      throw Error(Problem{"no-start",
                          program_.at(each.statement->place),
                          "the program cannot begin behind this line: it waits or moves",
                          {}});
    }
  }
}

void Interpreter::report_assumptions(const StartingPoint& start, StartReport& out) const {
  std::set<std::string> sets, reads;
  const auto is_host = [&](const std::string& name) { return host_.find(name) != nullptr; };
  for_each_statement(program_.statements, [&](const Statement& s) {
    const bool apart = s.kind == Kind::function || s.kind == Kind::task;
    if (apart) return;
    const bool skipped = s.place.file == 0 && s.place.line < start.statement->place.line;
    const bool changes = s.kind == Kind::set || s.kind == Kind::set_literal;
    if (skipped && changes && is_host(s.name)) sets.insert(s.name);
    if (skipped && s.kind == Kind::move && !s.moves_base() && !s.arguments.empty())
      out.last_point =
          (s.moves_at_speed() ? std::string(spelling(s.motion)) + " " : "") + spelled(*s.arguments.back());
    if (skipped) return;
    for_each_expression(s, [&](const Expression& e) {
      for (const std::string& name : names_read(e))
        if (is_host(name)) reads.insert(name);
    });
  });
  out.sets.assign(sets.begin(), sets.end());
  out.reads.assign(reads.begin(), reads.end());
}

std::optional<Location> Interpreter::handler() const {
  const Task* task = turn_ < tasks_.size() ? tasks_[turn_].get() : nullptr;
  while (task && task->handlers.empty()) task = task->parent ? task_of(task->parent) : nullptr;
  if (!task) return std::nullopt;
  for (std::size_t i = 0; i < code_.steps.size(); ++i) {
    const Step& step = code_.steps[i];
    if (step.op != Op::try_begin || static_cast<std::size_t>(step.d) != task->handlers.back().step) continue;
    return program_.at(code_.sources[i].statement->handler_place);
  }
  return std::nullopt;
}

}  // namespace polyarm::program
