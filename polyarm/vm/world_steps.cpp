#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/vm/task.hpp"

/// Steps that wait, ask, report, and meet other tasks.
namespace polyarm::program {

namespace {
/// The value as displayed to the user.
std::string told(const Value& value) {
  constexpr std::size_t kMost = 500;
  return value.as_text() ? *value.as_text() : value.excerpt(kMost);
}
}  // namespace

void Interpreter::execute_world(Task& task, const Step& step) {
  const Statement& s = *source(step).statement;
  switch (step.op) {
    case Op::arrive:
      if (!arrived(task)) return;
      break;
    case Op::load_file: {
      if (!arrived(task)) return;
      const LoadForm form = s.kind == Statement::Kind::import ? LoadForm::import : LoadForm::load;
      wait_for(task, WaitKind::load, s.name);
      task.handles = {host_.start_load(s.name, form, program_.at(s.place))};
      break;
    }
    case Op::move:
      return move(task, step);
    case Op::use:
      return use(task, step);
    case Op::until:
      return until_step(task, step);
    case Op::deadline:
      task.deadline = host_.now() + time(take_value(task, step.b, step), source(step).place, false);
      break;
    case Op::wait:
      return wait_step(task, step);
    case Op::wait_time: {
      const Nanoseconds until = host_.now() + time(take_value(task, step.b, step), source(step).place, true);
      wait_for(task, WaitKind::time);
      task.waiting.until = until;
      break;
    }
    case Op::ask:
      return ask(task, step);
    case Op::log: {
      std::string text;
      require_values(task, step, step.b, step.c);
      if (!write(task, step.b, step.c, " ", text)) return;
      release_now(task, step.b, step.c);
      host_.log(text, program_.at(source(step).line));
      break;
    }
    case Op::hold: {
      if (task.apart) wait_for(task, WaitKind::user);
      if (!arrived(task)) return;
      const std::string reason = step.b != kNone ? told(take_value(task, step.b, step)) : "the program holds";
      wait_for(task, WaitKind::time);  // in this line, until the cell goes on
      task.waiting.until = host_.now() + 1;
      ++task.pc;
      charge(kStepsOfAStatement * 100'000);  // nothing else runs in this tick
      return host_.hold(reason, program_.at(source(step).line));
    }
    case Op::ask_value: {
      if (!arrived(task)) return;
      const std::string text = told(take_value(task, step.b, step));
      const Value& like = value_of(task, step.a, step);
      const bool has_usual = !like.as_text() || !like.as_text()->empty();
      wait_for(task, WaitKind::user, text);
      task.waiting.note = !task.refused.empty() ? std::exchange(task.refused, {})
                          : has_usual           ? "Enter alone means " + like.excerpt(60)
                                                : std::string{};
      task.handles = {host_.start_ask(text, program_.at(source(step).line))};
      break;
    }
    case Op::run:
      host_.run_program(s.name, program_.at(s.place));
      break;
    case Op::expect:
      return expect(task, step);
    case Op::unmet:
      return report_unmet(task, step);
    case Op::meet:
      return meet(task, step);
    case Op::pulse:
      pulse(task, step);
      break;
    default:
      return lock(task, step);
  }
  ++task.pc;
}

/// True now, or before its timeout; else continues where the failure is reported.
void Interpreter::expect(Task& task, const Step& step) {
  const bool met = take_boolean(task, step.d, step, "expect");
  const bool looks_again = !met && task.deadline && !deadline_passed(task);
  if (looks_again) return begin_look(task, step, WaitKind::condition);
  task.deadline.reset();
  task.pc = met ? task.pc + 1 : static_cast<std::size_t>(step.c);
}

void Interpreter::report_unmet(Task& task, const Step& step) {
  const Statement& s = *source(step).statement;
  const auto& spellings = at(code_.name_lists, step.d);
  std::vector<std::string> values;
  require_values(task, step, step.b, step.c);
  for (int i = 0; i < step.c; ++i) values.push_back(task.local(step.b + i).value.excerpt(200));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = spellings[i] + " is " + values[i];
  std::string what = "expected " + spelled(*s.expression);
  if (s.second) what += " within " + spelled(*s.second);
  fail_at(source(step).line, "expect", what + (values.empty() ? "" : "; " + join(values, ", ")));
}

/// A number is a time to wait, a boolean a condition to wait for.
void Interpreter::wait_step(Task& task, const Step& step) {
  const Value value = take_value(task, step.d, step);
  if (value.as_number() && source(step).statement->kind == Statement::Kind::wait) {
    if (task.deadline)
      fail_at(source(step).statement->second->place, "bad-type", "a wait for a time has no timeout");
    const Nanoseconds until = host_.now() + time(value, source(step).place, false);
    wait_for(task, WaitKind::time);
    task.waiting.until = until;
    ++task.pc;
    return;
  }
  const bool* truth = value.as_boolean();
  if (!truth)
    fail_at(source(step).place, "bad-type",
            std::string("the condition of 'wait' is ") + data::name(value.kind()) + " (" + value.excerpt(60) +
                "), True or False was expected");
  if (!*truth) {
    begin_look(task, step, WaitKind::condition);
    if (deadline_passed(task)) time_out(task);
    return;
  }
  task.deadline.reset();
  ++task.pc;
}

/// True: the move ends here. If the move reaches its end first, the block after `else` runs.
void Interpreter::until_step(Task& task, const Step& step) {
  measure(task);
  if (take_boolean(task, step.d, step, "until")) {
    task.until_met = true;
    host_.end_move(task.handles.back(), program_.at(source(step).line));
    wait_for(task, WaitKind::move, "its end");
    ++task.pc;
    return;
  }
  begin_look(task, step, WaitKind::until);
  const std::vector<Handle> handles = task.handles;
  const WaitKind kind = std::exchange(task.waiting.kind, WaitKind::move);
  if (!poll_handles(task)) {
    task.handles = handles;
    task.waiting.kind = kind;
    return;
  }
  task.travelled = task.whole;
  task.measured.reset();
  task.until_met = host_.supposes_met(program_.at(source(step).line), step.c >= 0);
  task.pc = step.c >= 0 && !task.until_met ? static_cast<std::size_t>(step.c) : task.pc + 1;
}

void Interpreter::ask(Task& task, const Step& step) {
  const Statement& s = *source(step).statement;
  if (step.d >= 0 && host_.find(s.second->name)) {
    task.pc = static_cast<std::size_t>(step.d);
    return;
  }
  if (!arrived(task)) return;
  const std::string text = told(take_value(task, step.b, step));
  wait_for(task, WaitKind::user, text);
  task.handles = {host_.start_ask(text, program_.at(s.place))};
  ++task.pc;
}

// Interaction between tasks.

/// Passed when all tasks that mention it have arrived.
void Interpreter::meet(Task& task, const Step& step) {
  const std::string& name = code_.texts[static_cast<std::size_t>(step.a)];
  if (task.interrupts)
    fail_at(source(step).place, "deadlock",
            "a trap cannot come to '" + name + "': the task that it interrupts would be missing",
            "set a tag here and let the task come to the meeting");
  const auto parties = code_.meetings.find(name);
  if (parties == code_.meetings.end() || parties->second.size() < 2)
    fail_at(source(step).place, "no-meeting", "no other task reaches '" + name + "'",
            "use `meet` in two or more tasks");
  auto& come = meetings_[name];
  come.push_back(task.id);
  if (come.size() < parties->second.size()) {
    wait_for(task, WaitKind::meet, name);
    task.waiting.until = task.deadline;
    return;
  }
  for (const std::uint64_t id : come)
    if (Task* other = task_of(id)) other->met = true;
  come.clear();
  task.met = false;
  task.deadline.reset();
  ++task.pc;
}

void Interpreter::lock(Task& task, const Step& step) {
  const std::string& name = code_.texts[static_cast<std::size_t>(step.a)];
  const auto owner = locks_.find(name);
  if (owner != locks_.end() && owner->second == task.id)
    fail_at(source(step).place, "locked", "this task has '" + name + "' already", {});
  if (const Task* has = owner == locks_.end() ? nullptr : task_of(owner->second); has && is_frozen(*has))
    for (const Task* block = &task; block; block = block->parent ? task_of(block->parent) : nullptr)
      if (block->interrupts && (block->interrupts == has->id || block->interrupts == has->parent))
        fail_at(source(step).place, "deadlock",
                "'" + has->name + "', which this trap interrupts, has the lock '" + name + "' and cannot give it back",
                "take the lock before the trap can spring, or leave it out of the trap");
  if (owner != locks_.end()) {
    wait_for(task, WaitKind::lock, name);
    task.waiting.until = task.deadline;
    return;
  }
  locks_[name] = task.id;
  task.locks.push_back(name);
  task.deadline.reset();
  ++task.pc;
}

/// Each statement of the block begins immediately, with the present names.
void Interpreter::together(Task& task, const Step& step) {
  if (!arrived(task)) return;
  const auto& entries = code_.entries[static_cast<std::size_t>(step.a)];
  const CallFrame frame = task.frame();
  for (const int entry : entries) {
    Task& child = add_task(task.name, entry, false);
    child.parent = task.id;
    const auto first = task.stack.begin() + static_cast<std::ptrdiff_t>(frame.base);
    child.stack.assign(first, first + code_.registers);
    child.uses = task.uses;
    child.frames.front().uses = child.uses.size();
    if (step.b) child.step = {groups_ + 1, entries.size()};
  }
  if (step.b) ++groups_;
  ++task.pc;
  wait_for(task, WaitKind::together);
}

}  // namespace polyarm::program
