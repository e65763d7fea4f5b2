#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/language/rounding.hpp"
#include "polyarm/vm/task.hpp"

/// Steps that control the flow: loops, functions, errors, tasks.
namespace polyarm::program {

namespace {
/// An error that is raised again is still that of its robot.
void keep_robot(const data::Record& error, Problem& problem) {
  const Value* const robot = error.find("robot");
  const std::string* const name = robot ? robot->as_text() : nullptr;
  if (name && !name->empty()) problem.facts.push_back({"robot", *name});
}
}  // namespace

void Interpreter::execute_flow(Task& task, const Step& step) {
  const auto target = static_cast<std::size_t>(step.d);
  switch (step.op) {
    case Op::for_begin:
      begin_for(task, step);
      break;
    case Op::leave: {
      const Depths& to = at(code_.depths, step.a);
      if (task.leaves_block(to) && !arrived(task)) return;
      leave(task, to, step.b);
      break;
    }
    case Op::pass:
      return end_pass(task, step);
    case Op::try_begin:
      task.handlers.push_back({target, task.frame().base + static_cast<std::size_t>(step.a),
                               task.frames.size(), task.uses.size(), task.locks.size()});
      break;
    case Op::try_end:
      if (!arrived(task)) return;
      task.handlers.pop_back();
      break;
    case Op::raise:
    case Op::raise_again:
      return raise_step(task, step);
    case Op::retry:
      return retry(task, step);
    case Op::together:
      return together(task, step);
    case Op::begin_when: {
      Task& when = add_task("when", at(code_.whens, step.a).entry, false);
      when.apart = true;
      when.uses = task.uses;
      when.frames.front().uses = when.uses.size();
      wait_for(when, WaitKind::turn);
      break;
    }
    case Op::begin_trap:
    case Op::begin_every:
      begin_event(task, step);
      break;
    case Op::spring:
      task.sprung = true;
      break;
    case Op::due:
      if (is_due(task, step)) break;
      task.pc = static_cast<std::size_t>(step.a);
      return wait_for(task, WaitKind::turn);
    case Op::edge: {
      const bool now = take_boolean(task, step.b, step, "when");
      if (now && !std::exchange(task.was_true, true)) break;
      task.was_true = now;
      task.pc = static_cast<std::size_t>(step.a);
      return wait_for(task, WaitKind::turn);
    }
    case Op::rest:
      task.pc = static_cast<std::size_t>(step.a);
      return wait_for(task, WaitKind::turn);
    case Op::refuse:
      throw Error(at(code_.problems, step.a));
    case Op::pace:
      break;
    case Op::stop:
      if (!arrived(task)) return;
      task.state = TaskState::stopped;
      return stop();
    default:
      return finish(task);
  }
  ++task.pc;
}

/// Where the text of this line begins: an error that is passed on has kept no column.
Location Interpreter::first_of_line(const std::string& file, double line) const {
  const std::vector<std::string>* const lines = lines_of(file);
  if (!(line >= 1) || !lines || line > static_cast<double>(lines->size()))
    return {file, line >= 1 && line < 1e9 ? static_cast<int>(line) : 0, 0};
  const std::string& text = lines->at(static_cast<std::size_t>(line) - 1);
  const std::size_t first = text.find_first_not_of(" \t");
  return {file, static_cast<int>(line), first == std::string::npos ? 0 : static_cast<int>(first) + 1};
}

void Interpreter::raise_step(Task& task, const Step& step) {
  const Value error = step.op == Op::raise ? take_value(task, step.b, step) : slot(task, step.b).value;
  const data::Record* record = error.as_record();
  const auto part = [&](const char* name) { return record ? record->find(name) : nullptr; };
  Problem problem{
      "user", program_.at(source(step).line), error.as_text() ? *error.as_text() : error.excerpt(500), {}};
  if (const Value* kind = part("kind")) problem.code = kind->text();
  if (const Value* text = part("text")) problem.what = text->text();
  const Value* line = part("line");
  if (line && line->as_number())
    problem.where = first_of_line(problem.where.file, line->as_number()->value);
  if (record) keep_robot(*record, problem);
  throw Error(std::move(problem));
}

void Interpreter::leave(Task& task, const Depths& to, int names) {
  const CallFrame& frame = task.frame();
  release_now(task, to.locals, names - to.locals);
  task.uses.resize(std::min(task.uses.size(), frame.uses + static_cast<std::size_t>(to.uses)));
  task.handlers.resize(
      std::min(task.handlers.size(), frame.handlers + static_cast<std::size_t>(to.handlers)));
  give_back_locks(task, frame.locks + static_cast<std::size_t>(to.locks));
}

namespace {
/// Half a step behind the last number of a range: counting up from a number such as 0.006 rounds, and so does
/// a calculated end. 300mm / 100mm is a bit less than 3.
double end_of_range(double from, double to) {
  const double whole = std::round(to - from);
  const bool rounded = std::abs(from + whole - to) <= rounding_of(from, to);
  return from + (rounded ? whole : std::floor(to - from)) + 0.5;
}
}  // namespace

/// Registers of a loop: the position, the list or the last number, and its names.
void Interpreter::begin_for(Task& task, const Step& step) {
  const Statement& s = *source(step).statement;
  // Else [… for …]. In an included file, names in functions are their own.
  const bool statement = step.d == 1 && s.name_place.file == 0;
  for (const std::string& name : {s.name, s.second_name})
    if (statement && !name.empty() && host_.find(name))
      fail_at(s.name_place, "shadowing", "there is a '" + name + "' already",
              "choose another name for the loop");
  const bool range = step.c == 1;
  const Place place = source(step).place;
  Value over = take_value(task, operand(Where::temporary, step.a + step.c), step);
  Value first = 0;
  if (range) {
    first = take_value(task, operand(Where::temporary, step.a), step);
    const data::Number *from = first.as_number(), *to = over.as_number();
    if (!from || !to || from->dimension != to->dimension)
      fail_at(place, "bad-type", "a range goes from one number to another of the same unit");
    constexpr double kLargest = 1e15;  // beyond it an increment of one may be lost
    if (std::abs(from->value) > kLargest || std::abs(to->value) > kLargest)
      fail_at(place, "bad-type", "this range is too large to count");
    over = data::Number{end_of_range(from->value, to->value), to->dimension};
  } else if (!over.as_list()) {
    fail_at(place, "bad-type", "a list, or a range such as 1 .. 5, was expected");
  }
  task.local(step.a).fill(0);
  task.local(step.a + 1).fill(std::move(over));
  task.local(step.a + 2).fill(0);
  task.local(step.a + 2 + step.b).fill(std::move(first));
}

/// At the top for the first value, at the end of a pass for the next.
void Interpreter::next_of_for(Task& task, const Step& step) {
  const Slot& over = task.local(step.a + 1);
  Slot& loop = task.local(step.a + 2 + step.b);
  Value& count = task.local(step.a).value;
  const data::Number* counted = count.as_number();
  const double done = counted ? counted->value : 0;
  bool more = false;
  if (const data::List* list = over.value.as_list()) {
    more = done < static_cast<double>(list->size());
    if (more) loop.fill((*list)[static_cast<std::size_t>(done)]);
  } else if (const data::Number* from = loop.value.as_number(), *last = over.value.as_number();
             from && last) {
    const data::Number next{from->value + (step.op == Op::for_again ? 1 : 0), from->dimension};
    more = next.value <= last->value;
    loop.fill(next);
  }
  count = done + 1;
  if (step.b == 1) task.local(step.a + 2).fill(done + 1);
  const bool jumps = more == (step.op == Op::for_again);
  task.pc = jumps ? static_cast<std::size_t>(step.d) : task.pc + 1;
}

void Interpreter::end_pass(Task& task, const Step& step) {
  ++task.passes;
  if (pass_limit_ == 0 || task.passes < pass_limit_) {
    ++task.pc;
    return;
  }
  if (!arrived(task)) {
    --task.passes;
    return;
  }
  const Expression& condition = *source(step).statement->expression;
  if (condition.kind == Expression::Kind::name && host_.find(condition.name))
    host_.end_loop(condition.name, program_.at(source(step).line));
  task.pc = static_cast<std::size_t>(step.d);
}

void Interpreter::retry(Task& task, const Step& step) {
  if (task.leaves_block(at(code_.depths, step.c)) && !arrived(task)) return;
  const Value most = take_value(task, step.b, step);
  const data::Number* n = most.as_number();
  if (!n || n->dimension != Dimension::none)
    fail_at(source(step).place, "bad-type", "'retry' takes how often, here is " + described(most));
  Value& count = task.local(step.a).value;
  const double tried = count.as_number()->value;
  if (tried >= n->value) {
    const data::Record error = *task.local(step.a + 1).value.as_record();
    const Location where =
        first_of_line(program_.at(source(step).line).file, error.find("line")->as_number()->value);
    Problem problem{error.find("kind")->text(), where, error.find("text")->text(), {}};
    keep_robot(error, problem);
    throw Error(std::move(problem));
  }
  count = tried + 1;
  const Depths& outside = at(code_.depths, step.c);
  leave(task, outside, code_.registers);
  task.pc = static_cast<std::size_t>(step.d);
}

/// The end of a task. After the last line of the program its tasks begin, with its move defaults.
void Interpreter::finish(Task& task) {
  if (!arrived(task) || !gone_back(task)) return;
  task.state = TaskState::finished;
  if (&task != tasks_.front().get()) return;
  for (const FunctionCode& each : code_.tasks) {
    Task& made = add_task(each.name, each.entry, true);
    made.uses = task.uses;
    made.frames.front().uses = made.uses.size();
  }
  if (test_ && *test_ < code_.tests.size())
    add_task(code_.tests[*test_].name, code_.tests[*test_].entry, true);
}

}  // namespace polyarm::program
