#include "polyarm/vm/interpreter.hpp"

#include <algorithm>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/vm/task.hpp"

namespace polyarm::program {

static_assert(kDeepestCalls == bounds::kCallNesting);

const char* name(TaskState state) {
  static constexpr const char* kNames[] = {"running", "waiting", "finished", "failed", "stopped"};
  return kNames[static_cast<int>(state)];
}

Interpreter::Interpreter(Program program, Host& host, std::optional<std::size_t> test)
    : Interpreter(std::make_shared<Compiled>(std::move(program)), host, test) {}

Interpreter::Interpreter(std::shared_ptr<Compiled> compiled, Host& host, std::optional<std::size_t> test)
    : compiled_{std::move(compiled)},
      program_{compiled_->program},
      code_{compiled_->code},
      host_{host},
      random_{host.seed()},
      began_{host.now()},
      test_{test},
      has_moves_{std::any_of(code_.steps.begin(), code_.steps.end(),
                             [](const Step& step) { return step.op == Op::move; })} {
  Slot empty;
  empty.set = false;
  globals_.assign(code_.globals.size(), empty);
  add_task("main", 0, true);
}

Interpreter::~Interpreter() = default;

Interpreter::Task& Interpreter::add_task(std::string name, int entry, bool shown) {
  auto task = std::make_unique<Task>();
  task->id = ++last_id_;
  task->name = std::move(name);
  task->pc = static_cast<std::size_t>(entry);
  task->shown = shown;
  task->stack.resize(static_cast<std::size_t>(code_.registers));
  tasks_.push_back(std::move(task));
  return *tasks_.back();
}

Interpreter::Task* Interpreter::task_of(std::uint64_t id) const {
  const auto at =
      std::find_if(tasks_.begin(), tasks_.end(), [&](const auto& task) { return task->id == id; });
  return at == tasks_.end() ? nullptr : at->get();
}

// State of the program.

bool Interpreter::ended() const {
  return outcome_ && (cleaned_up_ || code_.on_stop < 0);
}

TaskState Interpreter::state() const {
  if (ended()) return *outcome_;
  const bool any = std::any_of(tasks_.begin(), tasks_.end(), [](const auto& task) {
    return task->shown && task->state == TaskState::running;
  });
  return any ? TaskState::running : TaskState::waiting;
}

/// The part of a task's `together` that is running; else null.
const Interpreter::Task* Interpreter::working_child_of(const Task& task) const {
  const Task* out = nullptr;
  for (const auto& other : tasks_) {
    if (other->parent != task.id || other->over()) continue;
    const auto keeps_going = [&](const Task::Asked& move) { return host_.under_way(move.handle); };
    if (std::any_of(other->moves.begin(), other->moves.end(), keeps_going)) return other.get();
    if (!out) out = other.get();
  }
  return out;
}

/// The present line. Moves are queued ahead of the robot: then it is the line of the move that the robot
/// executes.
Place Interpreter::place_of(const Task& task) const {
  const Place next = code_.sources[task.pc].line;
  if (paused_ == task.id) return next;
  if (task.ended_in) return *task.ended_in;
  if (task.over()) return task.handles.empty() ? next : task.line;
  const WaitKind kind = task.waiting.kind;
  if (kind == WaitKind::together)
    if (const Task* child = working_child_of(task)) return place_of(*child);
  const bool of_motion = kind == WaitKind::none || kind == WaitKind::move || kind == WaitKind::arrival ||
                         kind == WaitKind::room || kind == WaitKind::until;
  for (std::size_t i = 0; of_motion && i < task.moves.size(); ++i)
    if (host_.under_way(task.moves[i].handle)) return task.moves[i].line;
  const bool waits = task.state == TaskState::waiting && kind != WaitKind::turn;
  return waits || !task.handles.empty() ? task.line : next;
}

Place Interpreter::position() const {
  return place_of(shown_task());
}

void Interpreter::forget_arrived(Task& task) const {
  const auto is_open = [&](const Task::Asked& move) {
    return host_.under_way(move.handle) || host_.given_up(move.handle);
  };
  while (!task.moves.empty() && !is_open(task.moves.front())) task.moves.pop_front();
}

/// Of a `together`, the wait is that of one of its parts: a question, or the part that works.
void Interpreter::status_of(const Task& task, TaskStatus& out) const {
  const Place place = place_of(task);
  const auto part_of = [this](const Task& whole) -> const Task* {
    for (const auto& other : tasks_)
      if (other->parent == whole.id && !other->over() && other->waiting.kind == WaitKind::user)
        return other.get();
    return working_child_of(whole);
  };
  const Task* waits = &task;
  while (waits->waiting.kind == WaitKind::together) {
    const Task* const part = part_of(*waits);
    if (!part || part->waiting.kind == WaitKind::none) break;
    waits = part;
  }
  out.name = task.name;
  out.state = task.state;
  out.where.file = program_.file_of(place);
  out.where.line = place.line;
  out.where.column = place.column;
  out.source = program_.line_of(place);
  out.waiting = waits->waiting;
  out.passes = task.passes;
  out.cycles = cycles_of(task);
  out.problem = task.problem;
  out.paused = paused_ == task.id;
}

/// A pass counts when the robot has finished it: while a move is under way, or was given up, only the passes
/// before the one that requested it.
std::uint64_t Interpreter::cycles_of(const Task& task) const {
  if (task.ended_cycles) return *task.ended_cycles;
  for (const Task::Asked& move : task.moves)
    if (host_.under_way(move.handle) || host_.given_up(move.handle)) return move.passes;
  return task.passes;
}

/// Passes of a task that only watches or switches are no cycles beside those of tasks that move robots.
std::uint64_t Interpreter::cycles() const {
  std::uint64_t out = 0;
  const auto moves = [](const auto& task) { return !task->commanded.empty(); };
  const bool moved = std::any_of(tasks_.begin(), tasks_.end(), moves);
  if (!moved && tasks_.size() > 1 && has_moves_) return 0;
  for (const auto& task : tasks_)
    if (!moved || moves(task)) out = std::max(out, cycles_of(*task));
  return out;
}

std::vector<TaskStatus> Interpreter::status() const {
  std::vector<TaskStatus> out;
  for (const auto& task : tasks_)
    if (task->shown) status_of(*task, out.emplace_back());
  return out;
}

/// The paused task; else one that has failed; else the first that is running.
const Interpreter::Task& Interpreter::shown_task() const {
  if (const Task* const paused = paused_ && !outcome_ ? task_of(paused_) : nullptr) return *paused;
  const Task* shown = tasks_.front().get();
  for (const auto& task : tasks_) {
    const bool first = task->shown && shown->over() && !task->over() && shown->state != TaskState::failed;
    if (first || (task->state == TaskState::failed && shown->state != TaskState::failed)) shown = task.get();
  }
  return *shown;
}

TaskStatus Interpreter::overview() const {
  TaskStatus out;
  overview(out);
  return out;
}

void Interpreter::overview(TaskStatus& out) const {
  status_of(shown_task(), out);
  out.state = state();
  for (const auto& task : tasks_) out.passes = std::max(out.passes, task->passes);
  out.cycles = cycles();
}

// Running.

StepResult Interpreter::step(int budget) {
  const int given = budget;
  if (paused_ && !outcome_) return {state(), 0};
  const data::Remains::Keeping keeping(remains_);
  if (!remains_.empty()) budget -= remains_.free(budget * kStepsOfAStatement / 2) / kStepsOfAStatement;
  if (!outcome_ && looked_at_ != host_.now()) {
    looked_at_ = host_.now();
    end_pulses();
    step_whens();
    spring_traps();
    check_watches();
  }
  std::size_t idle = 0;
  while (budget > 0 && !outcome_ && !paused_ && idle < tasks_.size()) {
    if (turn_ >= tasks_.size()) turn_ = 0;
    if (turn_left_ <= 0) turn_left_ = kTurn;
    int turn = std::min(budget, turn_left_);
    const int before = turn;
    const bool more = run_task(*tasks_[turn_], turn);
    budget -= before - turn;
    turn_left_ -= before - turn;
    idle = before == turn ? idle + 1 : 0;
    if (!more || turn_left_ <= 0) ++turn_, turn_left_ = 0;
  }
  remove_children();
  if (!outcome_) finish_when_all_have();
  if (!outcome_ && !paused_) fail_for_deadlock();
  if (outcome_) step_clean_up(budget);
  return {state(), given - budget};
}

/// Runs `task` until it waits, has ended, or the budget is used up; true only in the last case.
bool Interpreter::run_task(Task& task, int& budget) {
  if (task.over() || is_frozen(task)) return false;
  try {
    const WaitKind waited = task.waiting.kind;
    forget_arrived(task);
    if (task.state == TaskState::waiting) {
      if (!poll(task)) return false;
      if (wait_over_ && task.shown) wait_over_();
    }
    // These wait before their step, which has already begun.
    const bool again = waited == WaitKind::arrival || waited == WaitKind::room || waited == WaitKind::lock;
    if (again) execute(task);
    return task.state == TaskState::running && run(task, budget);
  } catch (const Ended& end) {
    budget -= kStatementsOfAnError;
    raise(task, end.problem, false);
  } catch (const Error& error) {
    budget -= kStatementsOfAnError;
    raise(task, error.problems().empty() ? Problem{"failed", {}, error.what(), {}} : error.problems().front(),
          true);
  }
  return task.state == TaskState::running;
}

/// Checks each `when` once in every tick, and runs its block if the condition has become true.
void Interpreter::step_whens() {
  constexpr int kMostStatements = bounds::kStatementsATick;
  int budget = kMostStatements;  // for all of them
  for (std::size_t i = 0; i < tasks_.size() && !outcome_; ++i) {
    Task& task = *tasks_[i];
    if (task.waiting.kind != WaitKind::turn) continue;
    go_on(task);
    while (run_task(task, budget)) {  // an error that it caught pauses it
      if (budget > 0) continue;
      raise(task,
            {"too-long", {}, "this 'when' does not come to its end", "it runs within one cycle of the cell"},
            false);
    }
  }
}

void Interpreter::finish_when_all_have() {
  const bool all = std::all_of(tasks_.begin(), tasks_.end(),
                               [](const auto& task) { return !task->shown || task->over(); });
  if (!all || !watches_.empty() || !pulses_.empty()) return;
  const bool beside = std::any_of(tasks_.begin(), tasks_.end(), [](const auto& task) {
    return task->apart && !task->shown && !task->over();
  });
  if (!beside || !host_.keeps_events()) end_program(TaskState::finished);
}

void Interpreter::end_program(TaskState outcome) {
  if (outcome_) return;
  const auto loops = [](const Step& step) { return step.op == Op::pass; };
  if (outcome == TaskState::finished && std::none_of(code_.steps.begin(), code_.steps.end(), loops))
    tasks_.front()->passes = 1;  // a program without a loop is one pass
  for (const auto& task : tasks_) {
    if (outcome != TaskState::finished) task->ended_cycles = cycles_of(*task);
    if (task->interrupts && (!task->over() || outcome != TaskState::finished)) host_.abandon(task->stopped_robots);
    if (task->over()) continue;
    task->ended_in = place_of(*task);
    task->state = TaskState::stopped;
    task->waiting = {};
  }
  outcome_ = outcome;
  for (Pulse& pulse : pulses_) pulse.until = 0;
  end_pulses();
  watches_.clear();
  paused_ = 0;
}

void Interpreter::stop() {
  end_program(TaskState::stopped);
}

namespace {
/// The number of `use` lines outside of blocks that `main` has executed, and that are in front of `on stop`.
template <typename Task>
std::size_t uses_outside_blocks(const Code& code, const Task& main) {
  const std::size_t at = main.frames.size() > 1 ? main.frames[1].return_to - 1 : main.pc;
  int out = 0;
  for (const StartingPoint& each : code.starts) {
    if (!each.top) continue;
    if (static_cast<std::size_t>(each.begin) > at) break;
    const bool used =
        each.statement->kind == Statement::Kind::use && static_cast<std::size_t>(each.end) <= at;
    out = each.uses + (used ? 1 : 0);
    if (each.statement->kind == Statement::Kind::on_stop) break;
  }
  return std::min(main.uses.size(), static_cast<std::size_t>(out));
}
}  // namespace

/// Runs the block `on stop` once after any end of the program, when its robots are at standstill.
void Interpreter::step_clean_up(int& budget) {
  if (ended() || !host_.standing()) return;
  Task* task = tasks_.back()->apart && tasks_.back()->shown ? tasks_.back().get() : nullptr;
  if (!task) {
    task = &add_task("on stop", code_.on_stop, true);
    task->uses = tasks_.front()->uses;
    task->uses.resize(uses_outside_blocks(code_, *tasks_.front()));
    task->frames.front().uses = task->uses.size();
  }
  task->apart = true;
  run_task(*task, budget);
  if (task->state == TaskState::waiting)
    raise(*task, {"waits", {}, "an 'on stop' block cannot wait", {}}, false);
  cleaned_up_ = task->over();
  if (task->state == TaskState::failed) outcome_ = TaskState::failed;
}

// Errors.

namespace {
/// The kinds of errors that programs can distinguish.
const char* kind_of(const std::string& code) {
  if (code == "expect") return "user";
  for (const char* kind : {"timeout", "unreachable", "limit", "signal", "missed", "user"})
    if (code == kind) return kind;
  if (code == "singular" || code == "jump" || code == "refused") return "unreachable";
  if (code == "link" || code == "stale") return "signal";
  return "value";
}

/// `robot` is that of the task, unless the problem names its own.
Value as_value(const Problem& problem, std::string robot) {
  for (const Fact& fact : problem.facts)
    if (const auto* name = std::get_if<std::string>(&fact.value); name && fact.name == "robot") robot = *name;
  return data::Record{{"kind", "text", "line", "robot"},
                      {Value(kind_of(problem.code)), Value(problem.what),
                       Value(static_cast<double>(problem.where.line)), Value(robot)}};
}

/// Robots that still execute moves of `from` belong to `to` from now on, whose lines wait for them as usual.
template <typename Task>
void keep_robots(const Host& host, const Task& from, Task& to) {
  std::vector<std::string> robots = from.robots;
  for (const auto& move : from.moves)
    if (host.under_way(move.handle)) robots.push_back(move.robot);
  for (const std::string& robot : robots)
    if (std::find(to.robots.begin(), to.robots.end(), robot) == to.robots.end()) to.robots.push_back(robot);
}

/// While robots of a part of `together` still move, its locks belong to the task of the `together`.
template <typename Task>
void keep_locks(std::map<std::string, std::uint64_t>& owners, Task& from, Task& to) {
  if (to.robots.empty()) return;
  for (const std::string& name : from.locks)
    if (const auto owner = owners.find(name); owner != owners.end() && owner->second == from.id) {
      owner->second = to.id;
      to.locks.push_back(name);
    }
  from.locks.clear();
}
}  // namespace

void Interpreter::raise(Task& task, Problem problem, bool catchable) {
  if (problem.where.file.empty() && problem.where.line == 0)
    problem.where = program_.at(code_.sources[task.pc].line);
  end_children(task.id);
  end_watched_move(task);
  task.work.reset();
  task.waiting = {};
  task.handles.clear();
  task.deadline.reset();
  task.met = false;
  for (auto& [name, come] : meetings_) std::erase(come, task.id);
  keep_robots(host_, task, task);
  if (catchable && !task.handlers.empty()) {
    host_.caught(problem);
    return unwind(task, problem);
  }
  Task* parent = task.parent ? task_of(task.parent) : nullptr;
  if (parent) keep_robots(host_, task, *parent);
  if (!catchable && parent && !parent->over()) {  // no handler around its `together` sees it, either
    task.state = TaskState::failed;
    keep_locks(locks_, task, *parent);
    give_back_locks(task, 0);
    return raise(*parent, std::move(problem), false);
  }
  fail(task, std::move(problem));
}

/// Stops the move of an `until` that is no longer looked at, or the move in step of a part that has ended.
void Interpreter::end_watched_move(Task& task) {
  if (!task.measured) return;
  const Handle move = *task.measured;
  task.measured.reset();
  try {
    host_.end_move(move, program_.at(task.line));
  } catch (const Error&) {  // a host without it has refused the program already
  }
}

void Interpreter::unwind(Task& task, const Problem& problem) {
  const Handler handler = task.handlers.back();
  const std::string robot = task.uses.empty() ? std::string{} : task.uses.back().robot;
  task.handlers.pop_back();
  task.stack.resize(handler.stack);
  task.frames.resize(handler.frames);
  task.stack.resize(task.frame().base + static_cast<std::size_t>(code_.registers));
  task.stack[handler.stack].fill(as_value(problem, robot));
  task.uses.resize(handler.uses);
  if (task.robots.empty())
    give_back_locks(task, handler.locks);  // else the handler does it when they have arrived
  task.pc = handler.step;
  task.state = TaskState::running;
  std::erase_if(task.moves, [&](const Task::Asked& move) { return host_.given_up(move.handle); });
}

/// The calls that led to the task's line, as a suffix of messages; empty outside functions.
std::string Interpreter::called_from(const Task& task) const {
  constexpr std::size_t kMost = 3;
  std::string out;
  for (std::size_t i = task.frames.size(), told = 0; i-- > 1; ++told) {
    if (told == kMost) return out + " …";
    const Location at = program_.at(code_.sources[task.frames[i].return_to - 1].line);
    const std::size_t name = at.file.rfind('/') + 1;  // 0 if there is none
    out += (told == 0 ? "; called from line " : ", from line ") + std::to_string(at.line) +
           (at.file == program_.file ? "" : " of " + at.file.substr(name));
  }
  return out;
}

void Interpreter::fail(Task& task, Problem problem) {
  const Location line = program_.at(task.line);
  if (problem.where.line == line.line && problem.where.file == line.file && !task.parent)
    problem.what += called_from(task);
  task.state = TaskState::failed;
  Task* parent = task.parent ? task_of(task.parent) : nullptr;
  if (parent && !parent->over()) keep_locks(locks_, task, *parent);
  give_back_locks(task, 0);
  if (parent && !parent->over()) return raise(*parent, std::move(problem), true);
  task.problem = std::move(problem);
  end_program(TaskState::failed);
}

void Interpreter::end_children(std::uint64_t parent) {
  for (const auto& task : tasks_) {
    if (task->parent != parent || task->over()) continue;
    task->state = TaskState::stopped;
    // A move in step would wait for ever for the part that has failed, or go on without it.
    if (task->step.members > 1 && !task->moves.empty()) task->measured = task->moves.front().handle;
    end_watched_move(*task);
    end_children(task->id);
    if (Task* whole = task_of(parent)) {
      keep_robots(host_, *task, *whole);
      keep_locks(locks_, *task, *whole);
    }
    give_back_locks(*task, 0);
  }
}

void Interpreter::remove_children() {
  const auto gone = [](const auto& task) {
    return (task->parent != 0 || task->interrupts != 0) && task->over();
  };
  if (outcome_ || std::none_of(tasks_.begin(), tasks_.end(), gone)) return;
  std::erase_if(tasks_, gone);
  turn_ = 0, turn_left_ = 0;
}

void Interpreter::give_back_locks(Task& task, std::size_t keep) {
  for (; task.locks.size() > keep; task.locks.pop_back()) {
    const auto at = locks_.find(task.locks.back());
    if (at != locks_.end() && at->second == task.id) locks_.erase(at);
  }
}

}  // namespace polyarm::program
