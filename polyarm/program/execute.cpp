#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/program/functions.hpp"
#include "polyarm/program/task.hpp"

namespace polyarm::program {

namespace {
template <typename Items>
auto& at(Items& items, int index) {
  return items[static_cast<std::size_t>(index)];
}
}  // namespace

void Interpreter::fail_at(Place place, std::string code, std::string what, std::string advice) const {
  throw Error(Problem{std::move(code), program_.at(place), std::move(what), std::move(advice)});
}

/// Takes one step. A step that cannot be taken yet leaves the task waiting in front of it.
void Interpreter::execute(Task& task) {
  const Step& step = code_.steps[task.pc];
  task.line = step.line;
  try {
    if (step.op <= Op::here) return execute_value(task, step);
    if (step.op <= Op::fill) return execute_name(task, step);
    if (step.op <= Op::lock) return execute_world(task, step);
    execute_flow(task, step);
  } catch (const OperationError& error) {
    fail_at(step.place, error.code, error.what, error.advice);
  }
}

// Values.

Value Interpreter::pop(Task& task, Place place) {
  if (!task.stack.back().set)
    fail_at(place, "no-value", "a value was expected, and this function returns none",
            "write `return` with a value in it");
  Value out = std::move(task.stack.back().value);
  task.stack.pop_back();
  return out;
}

/// The last `count` values on the stack are values indeed.
void Interpreter::require_values(const Task& task, const Step& step, std::size_t count) const {
  const auto unset = [](const Slot& slot) { return !slot.set; };
  if (std::any_of(task.stack.end() - static_cast<std::ptrdiff_t>(count), task.stack.end(), unset))
    fail_at(step.place, "no-value", "a value was expected, and this function returns none",
            "write `return` with a value in it");
}

bool Interpreter::pop_boolean(Task& task, const Step& step, const char* of) {
  const Value value = pop(task, step.place);
  if (const bool* truth = value.as_boolean()) return *truth;
  fail_at(step.place, "bad-type",
          std::string("the condition of '") + of + "' is " + data::name(value.kind()) + " (" +
              value.text().substr(0, 60) + "), True or False was expected");
}

void Interpreter::execute_value(Task& task, const Step& step) {
  switch (step.op) {
    case Op::constant:
      task.push(at(code_.constants, step.a));
      break;
    case Op::absent:
      task.stack.push_back({{}, nullptr, false});
      break;
    case Op::local:
      task.stack.push_back(Slot(task.local(step.a)));
      break;
    case Op::global:
      if (!at(globals_, step.a).set)
        fail_at(step.place, "no-value", "this name has no value yet", "its `let` comes later");
      task.stack.push_back(at(globals_, step.a));
      break;
    case Op::host:
      if (!push_host(task, step)) return;
      break;
    case Op::local_element:
    case Op::global_element: {
      const Slot& list = step.op == Op::local_element ? task.local(step.a) : at(globals_, step.a);
      const Value index = pop(task, step.place);
      task.push(element(list.value, index));
      break;
    }
    case Op::unary: {
      const Value of = pop(task, step.place);
      task.push(apply(static_cast<Operator>(step.a), of));
      break;
    }
    case Op::binary: {
      const Value right = pop(task, step.place), left = pop(task, step.place);
      task.push(apply(static_cast<Operator>(step.a), left, right));
      break;
    }
    case Op::settle: {
      const bool* left = task.stack.back().value.as_boolean();
      const bool settles = left && *left == (static_cast<Operator>(step.a) == Operator::logical_or);
      if (settles) {
        task.pc = static_cast<std::size_t>(step.c);
        return;
      }
      break;
    }
    case Op::joined: {
      std::string text;
      const auto first = task.stack.end() - step.a;
      require_values(task, step, static_cast<std::size_t>(step.a));
      for (auto part = first; part != task.stack.end(); ++part) text += part->value.text();
      task.stack.erase(first, task.stack.end());
      task.push(apply(Operator::add, Value(std::string{}), Value(std::move(text))));
      break;
    }
    case Op::list:
    case Op::record: {
      data::List items;
      for (int i = 0; i < step.a; ++i) items.push_back(pop(task, step.place));
      std::reverse(items.begin(), items.end());
      task.push(step.op == Op::list ? make_list(std::move(items))
                                    : make_record({at(code_.name_lists, step.b), std::move(items)}));
      break;
    }
    case Op::element: {
      const Value index = pop(task, step.place), list = pop(task, step.place);
      task.push(element(list, index));
      break;
    }
    case Op::field:
      push_field(task, step);
      break;
    case Op::builtin:
      call_builtin(task, step);
      break;
    case Op::call:
      return enter(task, step);
    default: {  // here
      if (!arrived(task)) return;
      const MoveDefaults use = task.uses.empty() ? MoveDefaults{} : task.uses.back();
      Value place = host_.here(use.robot, use.tool, use.frame_pose ? std::string{} : use.frame);
      if (use.frame_pose && place.as_point())
        place = data::Point{inverse(*use.frame_pose) * place.as_point()->pose, false};
      task.push(std::move(place));
      break;
    }
  }
  ++task.pc;
}

namespace {
/// Points are read when their line is come to; everything else of the host's may depend on what has moved.
bool waits_for_motion(const Value& value) {
  if (const data::List* list = value.as_list())
    return std::any_of(list->begin(), list->end(), waits_for_motion);
  return !value.is_place();
}
}  // namespace

bool Interpreter::push_host(Task& task, const Step& step) {
  const std::string& wanted = at(code_.texts, step.a);
  const Value* found = host_.find(wanted);
  std::string_view rest;
  for (std::size_t dot = wanted.rfind('.'); !found && dot != std::string::npos && dot > 0;
       dot = wanted.rfind('.', dot - 1)) {
    found = host_.find(std::string_view(wanted).substr(0, dot));
    rest = std::string_view(wanted).substr(dot + 1);
  }
  if (!found) {
    auto names = host_.names();
    fail_at(step.place, "unknown-name",
            "there is nothing called '" + wanted + "'" + did_you_mean(wanted, names),
            "names are data, points, tags and what `let` made");
  }
  if (waits_for_motion(*found) && !arrived(task)) return false;
  Value value = *found;
  if (!rest.empty())
    for (const std::string& part : split_fields(rest, '.')) value = field(value, part);
  const bool whole = rest.empty() && value.is_place();
  task.push(std::move(value), whole ? &wanted : nullptr);
  return true;
}

/// The name of a point is what the host calls it.
void Interpreter::push_field(Task& task, const Step& step) {
  const std::string& name = at(code_.texts, step.a);
  const std::string* origin = task.stack.back().origin;
  const Value of = pop(task, step.place);
  if (name == "name" && of.is_place()) return task.push(origin ? *origin : of.text());
  task.push(field(of, name));
}

void Interpreter::call_builtin(Task& task, const Step& step) {
  const Function& function = functions()[static_cast<std::size_t>(step.a)];
  data::List arguments;
  for (int i = 0; i < step.b; ++i) arguments.push_back(pop(task, step.place));
  std::reverse(arguments.begin(), arguments.end());
  for (std::size_t i = 0; i < arguments.size(); ++i) require(function, i, arguments[i]);
  task.push(function.call(arguments, at(code_.name_lists, step.c)));
}

void Interpreter::enter(Task& task, const Step& step) {
  if (task.frames.size() > kDeepestCalls)
    fail_at(step.place, "too-deep",
            "functions call one another more than " + std::to_string(kDeepestCalls) + " deep",
            "write a loop, or end the recursion earlier");
  task.frames.push_back({task.pc + 1, task.stack.size() - static_cast<std::size_t>(step.b), task.uses.size(),
                         task.locks.size(), task.handlers.size()});
  task.pc = static_cast<std::size_t>(at(code_.functions, step.a).entry);
}

void Interpreter::give(Task& task) {
  Slot result = std::move(task.stack.back());
  const CallFrame frame = task.frames.back();
  task.frames.pop_back();
  task.stack.resize(frame.base);
  task.uses.resize(frame.uses);
  task.handlers.resize(std::min(task.handlers.size(), frame.handlers));
  give_back_locks(task, frame.locks);
  task.stack.push_back(std::move(result));
  task.pc = frame.return_to;
}

// Names.

void Interpreter::execute_name(Task& task, const Step& step) {
  switch (step.op) {
    case Op::drop:
      task.stack.pop_back();
      break;
    case Op::check_new:
      if (host_.find(at(code_.texts, step.a)))
        fail_at(step.place, "shadowing", "there is a '" + at(code_.texts, step.a) + "' already",
                "choose another name, or change it with `set`");
      break;
    case Op::let_global:
      if (!task.stack.back().set) pop(task, step.place);
      at(globals_, step.a) = std::move(task.stack.back());
      task.stack.pop_back();
      break;
    case Op::set_local:
    case Op::set_global: {
      Slot& slot = step.op == Op::set_local ? task.local(step.a) : at(globals_, step.a);
      const std::string* origin = task.stack.back().origin;
      Value value = pop(task, step.place);
      if (!slot.set)
        fail_at(step.place, "no-value", "'" + step.statement->name + "' has no value yet",
                "its `let` comes later");
      change(slot.value, std::move(value), step);
      slot.origin = origin;
      break;
    }
    case Op::set_host:
      if (!set_host(task, step)) return;
      break;
    case Op::set_literal:
      set_literal(task, step);
      break;
    case Op::replace:
      replace_part(task, step);
      break;
    case Op::given:
      if (task.local(step.a).set) {
        task.pc = static_cast<std::size_t>(step.c);
        return;
      }
      break;
    default:  // fill
      task.local(step.a) = std::move(task.stack.back());
      task.stack.pop_back();
      break;
  }
  ++task.pc;
}

/// A name keeps its type and unit.
void Interpreter::change(Value& present, Value value, const Step& step) {
  const std::string& name = step.statement->name;
  if (!same_type(present, value))
    fail_at(step.place, "bad-type",
            "'" + name + "' is " + described(present) + " (" + present.text().substr(0, 60) +
                ") and cannot become " + described(value) + " (" + value.text().substr(0, 60) + ")",
            "a name keeps its type and unit");
  present = std::move(value);
}

bool Interpreter::set_host(Task& task, const Step& step) {
  const std::string& name = at(code_.texts, step.a);
  const Value* present = host_.find(name);
  if (!present)
    fail_at(step.place, "unknown-name",
            "there is nothing called '" + name + "'" + did_you_mean(name, host_.names()),
            "write `let " + name + " = …` to make it");
  if (!arrived(task)) return false;
  Value old = *present;
  change(old, pop(task, step.place), step);
  host_.set(name, std::move(old), program_.at(step.line));
  return true;
}

void Interpreter::set_literal(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  if (step.a < 0 && step.b < 0) return host_.set(s.name, s.literal, program_.at(s.place));
  Slot& slot = step.a >= 0 ? task.local(step.a) : at(globals_, step.b);
  slot = {s.literal, nullptr, true};
}

/// The stack holds the whole, the places in lists, and the value that comes in.
void Interpreter::replace_part(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  Value value = pop(task, step.place);
  std::vector<PathStep> path;
  for (const std::string& part : at(code_.name_lists, step.a)) path.push_back({part, {}});
  const auto indices =
      std::count_if(s.path.begin(), s.path.end(), [](const PathPart& p) { return p.index != nullptr; });
  std::size_t next = task.stack.size() - static_cast<std::size_t>(indices);
  const std::size_t first = next;
  for (const PathPart& part : s.path) {
    if (part.index) {
      path.push_back({{}, task.stack[next++].value});
    } else {
      path.push_back({part.field, {}});
    }
  }
  task.stack.resize(first);
  replace(task.stack.back().value, path, std::move(value));
}

// Flow.

void Interpreter::execute_flow(Task& task, const Step& step) {
  const auto target = static_cast<std::size_t>(step.c);
  switch (step.op) {
    case Op::jump:
      task.pc = target;
      return;
    case Op::jump_unless: {
      const char* of = step.statement->kind == Statement::Kind::while_loop ? "while" : "if";
      task.pc = pop_boolean(task, step, of) ? task.pc + 1 : target;
      return;
    }
    case Op::for_begin:
      begin_for(task, step);
      break;
    case Op::for_next:
      return next_of_for(task, step);
    case Op::leave:
      leave(task, at(code_.depths, step.a));
      break;
    case Op::pass:
      return end_pass(task, step);
    case Op::give:
      return give(task);
    case Op::try_begin:
      task.handlers.push_back(
          {target, task.stack.size(), task.frames.size(), task.uses.size(), task.locks.size()});
      break;
    case Op::try_end:
      if (!arrived(task)) return;
      task.handlers.pop_back();
      break;
    case Op::raise:
    case Op::raise_again: {
      const Value error = step.op == Op::raise ? pop(task, step.place) : task.local(step.a).value;
      const data::Record* record = error.as_record();
      const auto part = [&](const char* name) { return record ? record->find(name) : nullptr; };
      Problem problem{"user", program_.at(step.line), error.text(), {}};
      if (const Value* kind = part("kind")) problem.code = kind->text();
      if (const Value* text = part("text")) problem.what = text->text();
      const Value* line = part("line");
      if (line && line->as_number())
        problem.where = {problem.where.file, static_cast<int>(line->as_number()->value), 0};
      throw Error(std::move(problem));
    }
    case Op::retry:
      return retry(task, step);
    case Op::together:
      return together(task, step);
    case Op::begin_when: {
      Task& when = add_task("when", at(code_.whens, step.a).entry, false);
      when.apart = true;
      wait_for(when, WaitKind::turn);
      break;
    }
    case Op::edge: {
      const bool now = pop_boolean(task, step, "when");
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
    case Op::stop:
      if (!arrived(task)) return;
      task.state = TaskState::stopped;
      return stop();
    default:
      return finish(task);
  }
  ++task.pc;
}

void Interpreter::leave(Task& task, const Depths& to) {
  const CallFrame& frame = task.frame();
  task.stack.resize(frame.base + static_cast<std::size_t>(to.locals));
  task.uses.resize(std::min(task.uses.size(), frame.uses + static_cast<std::size_t>(to.uses)));
  task.handlers.resize(
      std::min(task.handlers.size(), frame.handlers + static_cast<std::size_t>(to.handlers)));
  give_back_locks(task, frame.locks + static_cast<std::size_t>(to.locks));
}

/// Slots of a loop: how far it has come, what it runs over (a list, or the last number), and its names.
void Interpreter::begin_for(Task& task, const Step& step) {
  const Statement& s = *step.statement;
  for (const std::string& name : {s.name, s.second_name})
    if (!name.empty() && host_.find(name))
      fail_at(s.name_place, "shadowing", "there is a '" + name + "' already",
              "choose another name for the loop");
  Value over = pop(task, step.place);
  Value first = 0;
  if (step.a == 1) {
    first = pop(task, step.place);
    const data::Number *from = first.as_number(), *to = over.as_number();
    if (!from || !to || from->dimension != to->dimension)
      fail_at(s.second->place, "bad-type", "a range goes from one number to another of the same unit");
    constexpr double kLargest = 1e15;  // beyond it a step of one may not count
    if (std::abs(from->value) > kLargest || std::abs(to->value) > kLargest)
      fail_at(s.second->place, "bad-type", "this range is too large to count");
  } else if (!over.as_list()) {
    fail_at(s.expression->place, "bad-type", "a list, or a range such as 1 .. 5, was expected");
  }
  task.push(0);
  task.push(std::move(over));
  if (step.b == 1) task.push(0);
  task.push(std::move(first));
}

void Interpreter::next_of_for(Task& task, const Step& step) {
  const Slot& over = task.local(step.a + 1);
  Slot& loop = task.local(step.a + 2 + step.b);
  Value& count = task.local(step.a).value;
  const double done = count.as_number()->value;
  bool more = false;
  if (const data::List* list = over.value.as_list()) {
    more = done < static_cast<double>(list->size());
    if (more) loop = {(*list)[static_cast<std::size_t>(done)], nullptr, true};
  } else {
    const data::Number from = *loop.value.as_number();
    const data::Number next{from.value + (done > 0 ? 1 : 0), from.dimension};
    more = next.value <= over.value.as_number()->value;
    loop = {next, nullptr, true};
  }
  count = done + 1;
  if (step.b == 1) task.local(step.a + 2).value = done + 1;
  task.pc = more ? task.pc + 1 : static_cast<std::size_t>(step.c);
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
  const Expression& condition = *step.statement->expression;
  if (condition.kind == Expression::Kind::name && host_.find(condition.name))
    host_.set(condition.name, false, program_.at(step.line));
  task.pc = static_cast<std::size_t>(step.c);
}

void Interpreter::retry(Task& task, const Step& step) {
  const Value most = pop(task, step.place);
  const data::Number* n = most.as_number();
  if (!n || n->dimension != Dimension::none)
    fail_at(step.place, "bad-type", "'retry' takes how often, here is " + described(most));
  Value& count = task.local(step.a).value;
  const double tried = count.as_number()->value;
  if (tried >= n->value) {
    const data::Record error = *task.local(step.a + 1).value.as_record();
    const Location where{program_.at(step.line).file,
                         static_cast<int>(error.find("line")->as_number()->value), 0};
    throw Error(Problem{error.find("kind")->text(), where, error.find("text")->text(), {}});
  }
  count = tried + 1;
  leave(task, at(code_.depths, step.c));
  task.pc = static_cast<std::size_t>(step.b);
}

/// The last line of a task. Behind the last line of the program its tasks begin, with what it used.
void Interpreter::finish(Task& task) {
  if (!arrived(task)) return;
  task.state = TaskState::finished;
  if (&task != tasks_.front().get()) return;
  for (const FunctionCode& each : code_.tasks) {
    Task& made = add_task(each.name, each.entry, true);
    made.uses = task.uses;
    made.frames.front().uses = made.uses.size();
  }
}

}  // namespace polyarm::program
