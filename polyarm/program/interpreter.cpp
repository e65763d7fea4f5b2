#include "polyarm/program/interpreter.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::program {

const char* name(TaskState state) {
  static constexpr const char* kNames[] = {"running", "waiting", "finished", "failed", "stopped"};
  return kNames[static_cast<int>(state)];
}

namespace {
bool ended(TaskState state) {
  return state != TaskState::running && state != TaskState::waiting;
}

/// The condition that a wait looks at again and again.
const Expression& condition_of(const Statement& s) {
  return s.kind == Statement::Kind::ask ? *s.second : *s.expression;
}

bool same_type(const Value& a, const Value& b) {
  if (a.is_place() && b.is_place()) return true;
  if (a.kind() != b.kind()) return false;
  return !a.as_number() || a.as_number()->dimension == b.as_number()->dimension;
}
}  // namespace

Interpreter::Interpreter(Program program, Host& host)
    : program_{std::move(program)}, code_{flatten(program_)}, host_{host} {
  tasks_.emplace_back().name = "main";
}

TaskState Interpreter::state() const {
  const auto any = [&](TaskState state) {
    return std::any_of(tasks_.begin(), tasks_.end(), [&](const Task& task) { return task.state == state; });
  };
  for (const TaskState state :
       {TaskState::failed, TaskState::stopped, TaskState::running, TaskState::waiting})
    if (any(state)) return state;
  return TaskState::finished;
}

std::vector<TaskStatus> Interpreter::status() const {
  std::vector<TaskStatus> out;
  for (const Task& task : tasks_) {
    const Place place = code_[task.pc].place;
    out.push_back({task.name, task.state, program_.at(place), program_.source(place.line), task.waiting,
                   task.passes, task.problem});
  }
  return out;
}

void Interpreter::stop() {
  for (Task& task : tasks_) {
    if (!ended(task.state)) task.state = TaskState::stopped;
    task.waiting = {};
  }
}

StepResult Interpreter::step(int budget) {
  const int given = budget;
  for (Task& task : tasks_) {
    while (budget > 0 && !ended(state()) && step_task(task, budget)) {
    }
  }
  return {state(), given - budget};
}

/// False where the task can do nothing more now.
bool Interpreter::step_task(Task& task, int& budget) {
  if (ended(task.state)) return false;
  try {
    if (task.state == TaskState::waiting && !poll(task)) return false;
    if (task.state != TaskState::running) return false;
    --budget;
    execute(task, code_[task.pc]);
  } catch (const Error& error) {
    fail(task, error.problems().empty() ? Problem{"failed", {}, error.what(), {}} : error.problems().front());
  }
  return !ended(task.state);
}

void Interpreter::fail(Task& task, Problem problem) {
  if (problem.where.file.empty() && problem.where.line == 0)
    problem.where = program_.at(code_[task.pc].place);
  task.problem = std::move(problem);
  task.state = TaskState::failed;
  task.waiting = {};
}

void Interpreter::execute(Task& task, const Step& step) {
  const Statement* s = step.statement;
  switch (step.op) {
    case Op::load:
      return begin_load(task, *s);
    case Op::move:
      return begin_move(task, *s);
    case Op::wait_time:
      return begin_wait_time(task, evaluator(task).time(*s->expression, true));
    case Op::wait:
      return begin_wait(task, *s);
    case Op::ask:
      return begin_ask(task, *s);
    case Op::set_literal:
    case Op::set:
      assign(task, *s);
      break;
    case Op::let:
      declare(task, *s);
      break;
    case Op::log:
      write_log(task, *s);
      break;
    case Op::call:
      evaluator(task).value(*s->expression);
      break;
    case Op::for_begin:
      begin_for(task, *s);
      break;
    default:
      return execute_flow(task, step);
  }
  ++task.pc;
}

void Interpreter::execute_flow(Task& task, const Step& step) {
  const auto target = static_cast<std::size_t>(step.target);
  switch (step.op) {
    case Op::jump:
      task.pc = target;
      return;
    case Op::jump_unless: {
      const char* of = step.statement->kind == Statement::Kind::while_loop ? "while" : "if";
      task.pc = evaluator(task).boolean(*step.expression, of) ? task.pc + 1 : target;
      return;
    }
    case Op::for_next:
      return next_of_for(task, step);
    case Op::pass:
      return end_pass(task, step);
    case Op::keep_locals:
      task.frame().locals.resize(static_cast<std::size_t>(step.locals));
      ++task.pc;
      return;
    case Op::stop:
      return stop();
    default:
      task.state = TaskState::finished;
      return;
  }
}

void Interpreter::begin_load(Task& task, const Statement& s) {
  const LoadForm form = s.kind == Statement::Kind::import ? LoadForm::import : LoadForm::load;
  task.handle = host_.start_load(s.name, form, program_.at(s.place));
  task.waiting = {WaitKind::load, {}, {}, s.name};
  task.state = TaskState::waiting;
}

void Interpreter::begin_move(Task& task, const Statement& s) {
  const Expression& point = *s.expression;
  const Value value = evaluator(task).value(point);
  const std::string called = point.kind == Expression::Kind::name ? point.name : value.text();
  if (!value.is_place())
    throw Error(Problem{"bad-type", program_.at(point.place),
                        "'" + called + "' is " + data::name(value.kind()) + ", a point was expected",
                        "moveto goes to a joint state or a pose"});
  Move move;
  move.targets.push_back({value, called});
  move.waits = true;
  task.handle = host_.start_move(move, program_.at(s.place));
  task.waiting = {WaitKind::move, {}, {}, called};
  task.state = TaskState::waiting;
}

void Interpreter::begin_wait_time(Task& task, Nanoseconds duration) {
  task.waiting = {WaitKind::time, host_.now() + duration, {}, {}};
  task.state = TaskState::waiting;
}

void Interpreter::begin_wait(Task& task, const Statement& s) {
  const Expression& condition = condition_of(s);
  const Value first = evaluator(task).value(condition);
  if (s.kind == Statement::Kind::wait && first.as_number()) {
    if (s.second)
      throw Error(Problem{"bad-type", program_.at(s.second->place), "a wait for a time has no timeout", {}});
    return begin_wait_time(task, evaluator(task).time(first, condition.place, false));
  }
  task.waiting = {WaitKind::condition, {}, {}, {}};
  for (const std::string& read : names_read(condition))
    if (!task.frame().find(read)) task.waiting.names.push_back(read);
  if (s.second && s.kind == Statement::Kind::wait)
    task.waiting.until = host_.now() + evaluator(task).time(*s.second, false);
  task.seen_version = host_.data_version() - 1;
  task.state = TaskState::waiting;
}

void Interpreter::begin_ask(Task& task, const Statement& s) {
  if (s.second && (task.frame().find(s.second->name) || host_.find(s.second->name)))
    return begin_wait(task, s);
  const std::string text = s.expression ? evaluator(task).value(*s.expression).text() : std::string{};
  task.handle = host_.start_ask(text, program_.at(s.place));
  task.waiting = {WaitKind::user, {}, {}, text};
  task.state = TaskState::waiting;
}

/// Looks whether the wait is over; then the task runs on behind it.
bool Interpreter::poll(Task& task) {
  const Step& step = code_[task.pc];
  switch (task.waiting.kind) {
    case WaitKind::time:
      if (host_.now() < *task.waiting.until) return false;
      end_wait(task);
      return true;
    case WaitKind::condition:
      return poll_condition(task, step);
    default:
      return poll_handle(task, step);
  }
}

bool Interpreter::poll_condition(Task& task, const Step& step) {
  const std::uint64_t version = host_.data_version();
  if (version != task.seen_version) {
    task.seen_version = version;
    if (evaluator(task).boolean(condition_of(*step.statement), "wait")) {
      end_wait(task);
      return true;
    }
  }
  if (!task.waiting.until || host_.now() < *task.waiting.until) return false;
  time_out(task, step);
  return true;
}

void Interpreter::time_out(Task& task, const Step& step) {
  if (step.target < 0)
    throw Error(Problem{
        "timeout", program_.at(step.place),
        "the time-out passed and the condition is still false; it reads " + join(task.waiting.names, ", "),
        "write `else` after the timeout to handle it"});
  end_wait(task);
  task.pc = static_cast<std::size_t>(step.target);
}

bool Interpreter::poll_handle(Task& task, const Step& step) {
  const WaitKind kind = task.waiting.kind;
  Progress progress = kind == WaitKind::move   ? host_.poll_move(task.handle)
                      : kind == WaitKind::load ? host_.poll_load(task.handle)
                                               : host_.poll_ask(task.handle);
  if (progress.state == Progress::State::running) return false;
  if (progress.state != Progress::State::done)
    throw Error(progress.problem.value_or(
        Problem{"failed", program_.at(step.place), "'" + program_.source(step.place.line) + "' failed", {}}));
  end_wait(task);
  return true;
}

void Interpreter::end_wait(Task& task) {
  task.waiting = {};
  task.state = TaskState::running;
  ++task.pc;
}

void Interpreter::assign(Task& task, const Statement& s) {
  const Evaluator evaluate = evaluator(task);
  if (s.kind == Statement::Kind::set) return assign_checked(task, s, evaluate.value(*s.expression));
  if (Local* local = task.frame().find(s.name)) {
    local->value = s.literal;
  } else {
    host_.set(s.name, s.literal, program_.at(s.place));
  }
}

/// A name keeps its type and unit.
void Interpreter::assign_checked(Task& task, const Statement& s, Value value) {
  Local* local = task.frame().find(s.name);
  const Value* present = local ? &local->value : host_.find(s.name);
  if (!present)
    throw Error(Problem{"unknown-name", program_.at(s.name_place),
                        "there is nothing called '" + s.name + "'" + did_you_mean(s.name, host_.names()),
                        "write `let " + s.name + " = …` to make it"});
  if (!same_type(*present, value))
    throw Error(Problem{"bad-type", program_.at(s.name_place),
                        "'" + s.name + "' is " + data::name(present->kind()) + " (" +
                            present->text().substr(0, 60) + ") and cannot become " +
                            data::name(value.kind()) + " (" + value.text().substr(0, 60) + ")",
                        "a name keeps its type and unit"});
  if (local) {
    local->value = std::move(value);
  } else {
    host_.set(s.name, std::move(value), program_.at(s.place));
  }
}

void Interpreter::declare(Task& task, const Statement& s) {
  if (task.frame().find(s.name) || host_.find(s.name))
    throw Error(Problem{"shadowing", program_.at(s.name_place), "there is a '" + s.name + "' already",
                        "choose another name, or change it with `set`"});
  Value value = evaluator(task).value(*s.expression);
  task.frame().locals.push_back({s.name, std::move(value)});
}

/// Locals of a loop: how far it has come, what it runs over (a list, or the last number), and its name.
void Interpreter::begin_for(Task& task, const Statement& s) {
  const auto fail_at = [&](Place place, std::string what) {
    throw Error(Problem{"bad-type", program_.at(place), std::move(what), {}});
  };
  if (task.frame().find(s.name) || host_.find(s.name))
    throw Error(Problem{"shadowing", program_.at(s.name_place), "there is a '" + s.name + "' already",
                        "choose another name for the loop"});
  Value first = evaluator(task).value(*s.expression);
  Value over = s.second ? evaluator(task).value(*s.second) : first;
  if (!s.second && !over.as_list())
    fail_at(s.expression->place, "a list, or a range such as 1 .. 5, was expected");
  if (s.second && (!first.as_number() || !over.as_number() ||
                   first.as_number()->dimension != over.as_number()->dimension))
    fail_at(s.second->place, "a range goes from one number to another of the same unit");
  constexpr double kLargest = 1e15;  // beyond it a step of one may not count
  if (s.second &&
      (std::abs(first.as_number()->value) > kLargest || std::abs(over.as_number()->value) > kLargest))
    fail_at(s.second->place, "this range is too large to count");
  auto& locals = task.frame().locals;
  locals.push_back({"", Value(0)});
  locals.push_back({"", std::move(over)});
  locals.push_back({s.name, s.second ? std::move(first) : Value(0)});
}

void Interpreter::next_of_for(Task& task, const Step& step) {
  auto& locals = task.frame().locals;
  Local& loop = locals[locals.size() - 1];
  const Value& over = locals[locals.size() - 2].value;
  Value& count = locals[locals.size() - 3].value;
  const double done = count.as_number()->value;
  bool more = false;
  if (const data::List* list = over.as_list()) {
    more = done < static_cast<double>(list->size());
    if (more) loop.value = (*list)[static_cast<std::size_t>(done)];
  } else {
    const data::Number present = *loop.value.as_number();
    const data::Number next{present.value + (done > 0 ? 1 : 0), present.dimension};
    more = next.value <= over.as_number()->value;
    loop.value = next;
  }
  count = done + 1;
  task.pc = more ? task.pc + 1 : static_cast<std::size_t>(step.target);
}

void Interpreter::end_pass(Task& task, const Step& step) {
  ++task.passes;
  if (pass_limit_ == 0 || task.passes < pass_limit_) {
    ++task.pc;
    return;
  }
  const Expression& condition = *step.statement->expression;
  if (condition.kind == Expression::Kind::name) {
    if (Local* local = task.frame().find(condition.name)) {
      local->value = false;
    } else {
      host_.set(condition.name, false, program_.at(step.place));
    }
  }
  task.pc = static_cast<std::size_t>(step.target);
}

void Interpreter::write_log(Task& task, const Statement& s) {
  std::string text;
  for (const ExpressionPtr& argument : s.arguments) {
    text += (text.empty() ? "" : " ") + evaluator(task).value(*argument).text();
  }
  host_.log(text, program_.at(s.place));
}

}  // namespace polyarm::program
