#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/base/unit_advice.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/vm/task.hpp"

namespace polyarm::program {

namespace {
/// What a condition reads, for a message: its names, or the condition itself if it calls functions such as
/// next_part().
std::string read_by(const std::vector<std::string>& names, const Expression* condition) {
  if (!names.empty()) return join(names, ", ");
  return condition ? spelled(*condition) : "nothing that others change";
}
}  // namespace

void Interpreter::wait_for(Task& task, WaitKind kind, std::string_view text) {
  if (task.apart && kind != WaitKind::turn)
    fail_at(code_.sources[task.pc].line, "waits", "a 'when' or 'on stop' block cannot wait or move",
            "set a tag here and let a task do it");
  task.waiting.begin(kind);
  task.waiting.text = text;
  task.state = TaskState::waiting;
}

void Interpreter::go_on(Task& task) {
  task.waiting.begin(WaitKind::none);
  task.state = TaskState::running;
}

/// True if no motion of this task is under way; else the task waits for it, and repeats this step. The condition of
/// an `until` waits for nothing: the other robots of the task may still move.
bool Interpreter::arrived(Task& task) {
  if (task.robots.empty() || task.measured) return true;
  task.handles.clear();
  for (const std::string& robot : task.robots) task.handles.push_back(host_.start_arrival(robot));
  task.robots.clear();
  wait_for(task, WaitKind::arrival);
  return false;
}

/// Checks whether the wait is over; then the task continues.
bool Interpreter::poll(Task& task) {
  switch (task.waiting.kind) {
    case WaitKind::time:
      if (host_.now() < *task.waiting.until) return false;
      go_on(task);
      return true;
    case WaitKind::condition:
      return poll_condition(task);
    case WaitKind::until:
      return poll_until(task);
    case WaitKind::room: {
      const std::string robot = task.waiting.text;
      if (task.waiting.until && host_.now() < *task.waiting.until)
        return false;  // looked at once in each tick
      if (!host_.room_for_move(robot)) return false;
      go_on(task);
      return true;
    }
    case WaitKind::meet:
      return poll_meeting(task);
    case WaitKind::lock:
      return poll_lock(task);
    case WaitKind::together:
      return poll_together(task);
    case WaitKind::turn:
    case WaitKind::none:
      return false;
    default:
      return poll_handles(task);
  }
}

bool Interpreter::poll_handles(Task& task) {
  const WaitKind kind = task.waiting.kind;
  if (task.until_met) measure(task);
  while (!task.handles.empty()) {
    const Handle handle = task.handles.back();
    const Progress progress = kind == WaitKind::load   ? host_.poll_load(handle)
                              : kind == WaitKind::user ? host_.poll_ask(handle)
                                                       : host_.poll_move(handle);
    if (progress.state == Progress::State::running) return false;
    task.handles.pop_back();
    if (progress.state == Progress::State::done) continue;
    Problem problem =
        progress.problem.value_or(Problem{"failed", {}, "'" + program_.source(task.line) + "' failed", {}});
    if (problem.where.file.empty() && problem.where.line == 0) problem.where = program_.at(task.line);
    if (progress.state == Progress::State::ended) {
      // Of moves in step, all are discarded when one of them fails: its failure is the one to report.
      for (const auto& other : tasks_) {
        const bool in_step = task.step.members > 1 && other->parent == task.parent && other->id != task.id;
        for (std::size_t i = 0; in_step && !other->over() && i < other->handles.size(); ++i)
          if (Progress why = host_.poll_move(other->handles[i]);
              why.state == Progress::State::failed && why.problem)
            throw Error(std::move(*why.problem));
      }
      throw Ended{std::move(problem)};
    }
    throw Error(std::move(problem));
  }
  if (task.until_met) task.measured.reset();
  go_on(task);
  return true;
}

/// The condition is checked again when something that it reads may have changed.
bool Interpreter::poll_condition(Task& task) {
  const Step& step = code_.steps[task.pc];
  const bool others = code_.reads[static_cast<std::size_t>(step.b)].others && host_.now() != task.seen_at;
  if (host_.data_version() != task.seen_version || others) {
    task.pc = static_cast<std::size_t>(step.a);
    go_on(task);
    return true;
  }
  if (!deadline_passed(task)) return false;
  time_out(task);
  return true;
}

/// A move that ends early when its condition becomes true.
bool Interpreter::poll_until(Task& task) {
  const Step& step = code_.steps[task.pc];
  if (host_.now() != task.seen_at) {
    task.pc = static_cast<std::size_t>(step.a);
    go_on(task);
    return true;
  }
  return false;
}

bool Interpreter::deadline_passed(const Task& task) const {
  return task.deadline && host_.now() >= *task.deadline;
}

/// Continues with the block after `else`, or fails.
void Interpreter::time_out(Task& task) {
  const Step& step = code_.steps[task.pc];
  const Waiting waiting = task.waiting;
  const Statement* const statement = source(step).statement;
  const bool calls =
      waiting.kind == WaitKind::condition && code_.reads[static_cast<std::size_t>(step.b)].others;
  const Expression* const condition = calls && statement ? statement->expression.get() : nullptr;
  task.deadline.reset();
  if (waiting.kind == WaitKind::meet) std::erase(meetings_[waiting.text], task.id);
  if (step.c < 0) {
    const std::string what = waiting.kind == WaitKind::meet
                                 ? "the time-out passed and not all have come to '" + waiting.text + "'"
                             : waiting.kind == WaitKind::lock
                                 ? "the time-out passed and another task still has '" + waiting.text + "'"
                                 : "the time-out passed and the condition is still false; it reads " +
                                       read_by(waiting.names, condition);
    throw Error(Problem{"timeout", program_.at(source(step).line), what,
                        waiting.kind == WaitKind::lock ? "catch it with `try`"
                                                       : "write `else` after the timeout to handle it"});
  }
  go_on(task);
  task.pc = static_cast<std::size_t>(step.c);
}

bool Interpreter::poll_meeting(Task& task) {
  if (!task.met) {
    if (!deadline_passed(task)) return false;
    time_out(task);
    return true;
  }
  task.met = false;
  task.deadline.reset();
  go_on(task);
  ++task.pc;
  return true;
}

bool Interpreter::poll_lock(Task& task) {
  if (!locks_.contains(task.waiting.text)) {
    go_on(task);
    return true;
  }
  if (!deadline_passed(task)) return false;
  time_out(task);
  return true;
}

bool Interpreter::poll_together(Task& task) {
  const bool at_work = std::any_of(tasks_.begin(), tasks_.end(), [&](const auto& other) {
    return other->parent == task.id && (!other->over() || other->state == TaskState::failed);
  });
  if (at_work) return false;
  go_on(task);
  return true;
}

/// The condition of a wait or of a move's end is false: it will be checked again.
void Interpreter::begin_look(Task& task, const Step& step, WaitKind kind) {
  wait_for(task, kind);
  task.waiting.names = code_.reads[static_cast<std::size_t>(step.b)].names;
  task.waiting.until = task.deadline;
  task.seen_version = host_.data_version();
  task.seen_at = host_.now();
}

Nanoseconds Interpreter::time(const Value& value, Place place, bool bare_seconds) const {
  constexpr double kLongest = 1e9;  // about 30 years, in seconds
  const data::Number* number = value.as_number();
  const bool fits = number && (number->dimension == Dimension::time ||
                               (bare_seconds && number->dimension == Dimension::none));
  if (!fits)
    fail_at(place, "bad-type", "a time was expected, here is " + value.excerpt(60),
            unit_advice(Dimension::time, number && number->dimension == Dimension::none
                                             ? std::optional(number->value)
                                             : std::nullopt));
  if (number->value < 0) fail_at(place, "bad-value", "a time cannot be negative: " + value.text());
  return nanoseconds(std::min(number->value, kLongest));
}

}  // namespace polyarm::program
