#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/program/functions.hpp"
#include "polyarm/program/task.hpp"

namespace polyarm::program {

void Interpreter::fail_at(Place place, std::string code, std::string what, std::string advice) const {
  throw Error(Problem{std::move(code), program_.at(place), std::move(what), std::move(advice)});
}

/// Takes one step. A step that cannot be taken yet leaves the task waiting in front of it.
void Interpreter::execute(Task& task) {
  const Step& step = code_.steps[task.pc];
  task.line = step.line;
  if (quick(task, step)) return;
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
    case Op::of_host:
      call_host(task, step);
      break;
    case Op::answered:
      if (!push_answer(task, step)) return;
      break;
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

void Interpreter::call_host(Task& task, const Step& step) {
  const Function& function = functions()[static_cast<std::size_t>(step.a)];
  data::List arguments;
  for (int i = 0; i < step.b; ++i) arguments.push_back(pop(task, step.place));
  std::reverse(arguments.begin(), arguments.end());
  for (std::size_t i = 0; i < arguments.size(); ++i) require(function, i, arguments[i]);
  task.push(host_.call(function.name, arguments, program_.at(step.place)));
}

namespace {
/// What a person typed, where a value like `like` was asked for.
std::optional<Value> understood(const std::string& answer, const Value& like) {
  if (answer.empty()) return like;
  if (like.as_text()) return Value(answer);
  if (like.as_boolean()) {
    for (const char* yes : {"yes", "y", "true", "on"})
      if (equal_ignoring_case(answer, yes)) return Value(true);
    for (const char* no : {"no", "n", "false", "off"})
      if (equal_ignoring_case(answer, no)) return Value(false);
    return std::nullopt;
  }
  const data::Number* number = like.as_number();
  const auto given = number ? parse_quantity(answer, number->dimension) : std::nullopt;
  if (!given || (number->dimension != Dimension::none && parse_number(answer))) return std::nullopt;
  return Value(data::Number{*given, number->dimension});
}
}  // namespace

/// False where the answer is not like what was asked for: the question comes again.
bool Interpreter::push_answer(Task& task, const Step& step) {
  const Value like = pop(task, step.place);
  std::optional<Value> given = understood(std::string(trim(host_.answer())), like);
  if (given) {
    task.push(std::move(*given));
    return true;
  }
  host_.log("the answer is " + described(like) + ", such as " + like.text(), program_.at(step.line));
  task.pc = static_cast<std::size_t>(step.c);
  return false;
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

}  // namespace polyarm::program
