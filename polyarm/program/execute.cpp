#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/program/functions.hpp"
#include "polyarm/program/operators.hpp"
#include "polyarm/program/task.hpp"

namespace polyarm::program {

void Interpreter::fail_at(Place place, std::string code, std::string what, std::string advice) const {
  throw Error(Problem{std::move(code), program_.at(place), std::move(what), std::move(advice)});
}

/// Takes one step. A step that cannot be taken yet leaves the task waiting in front of it.
void Interpreter::execute(Task& task) {
  const Step& step = code_.steps[task.pc];
  task.line = source(step).line;
  try {
    if (step.op <= Op::let_go) return execute_plain(task, step);
    if (step.op <= Op::here) return execute_value(task, step);
    if (step.op <= Op::given) return execute_name(task, step);
    if (step.op <= Op::lock) return execute_world(task, step);
    execute_flow(task, step);
  } catch (const OperationError& error) {
    fail_at(source(step).place, error.code, error.what, error.advice);
  }
}

// Registers.

Slot& Interpreter::slot(Task& task, Operand operand) {
  switch (where(operand)) {
    case Where::global:
      return at(globals_, index(operand));
    case Where::constant:
      return at(code_.constants, index(operand));
    default:
      return task.local(index(operand));
  }
}

Value Interpreter::take_value(Task& task, Operand operand, const Step& step) {
  Slot& from = slot(task, operand);
  if (!from.set)
    fail_at(source(step).place, "no-value", "a value was expected, and this function returns none",
            "write `return` with a value in it");
  if (where(operand) == Where::temporary) return std::move(from.value);
  return from.value;
}

void Interpreter::require_values(Task& task, const Step& step, int first, int count) {
  for (int i = first; i < first + count; ++i)
    if (!task.local(i).set)
      fail_at(source(step).place, "no-value", "a value was expected, and this function returns none",
              "write `return` with a value in it");
}

bool Interpreter::take_boolean(Task& task, Operand operand, const Step& step, const char* of) {
  const Value value = take_value(task, operand, step);
  if (const bool* truth = value.as_boolean()) return *truth;
  fail_at(source(step).place, "bad-type",
          std::string("the condition of '") + of + "' is " + data::name(value.kind()) + " (" +
              value.text().substr(0, 60) + "), True or False was expected");
}

void Interpreter::charge_for(const Value& value) {
  constexpr std::size_t kBytesOfAStep = 64;
  if (value.as_text()) charge(value.as_text()->size() / kBytesOfAStep);
  if (value.as_list() || value.as_record()) charge(value.extent().values);
}

// Plain steps, of any values.

void Interpreter::calculate(Task& task, const Step& step) {
  const auto op = static_cast<Operator>(step.more);
  const Value right = take_value(task, step.c, step), left = take_value(task, step.b, step);
  if (is_comparison(op)) charge_for(left);
  Value result = apply(op, left, right);
  charge_for(result);
  slot(task, step.a).fill(std::move(result));
}

/// A text that grows does so in its place.
void Interpreter::calculate_into_variable(Task& task, const Step& step) {
  const auto op = static_cast<Operator>(step.more);
  Slot& variable = slot(task, step.a);
  const Value right = take_value(task, step.c, step);
  const bool grows = op == Operator::add && step.b == step.a && variable.set && variable.value.as_text() &&
                     right.as_text() &&
                     variable.value.as_text()->size() + right.as_text()->size() <= kLongestText;
  if (grows) {
    charge_for(right);
    return variable.value.append(std::string_view(*right.as_text()));
  }
  const Value left = take_value(task, step.b, step);
  Value result = apply(op, left, right);
  charge_for(result);
  change(variable, std::move(result), nullptr, *source(step).statement);
}

namespace {
bool is_when(Op op) {
  return op >= Op::when_equal && op <= Op::when_greater_equal;
}
}  // namespace

void Interpreter::execute_plain(Task& task, const Step& step) {
  const auto target = static_cast<std::size_t>(step.d);
  switch (step.op) {
    case Op::load:
      slot(task, step.a) =
          where(step.b) == Where::temporary ? std::move(slot(task, step.b)) : slot(task, step.b);
      break;
    case Op::require:
      if (!slot(task, step.a).set)
        fail_at(source(step).place, "no-value", "this name has no value yet", "its `let` comes later");
      break;
    case Op::add_to:
    case Op::subtract_to:
    case Op::multiply_to:
    case Op::divide_to:
    case Op::modulo_to:
      calculate_into_variable(task, step);
      break;
    case Op::unary: {
      const Value of = take_value(task, step.b, step);
      slot(task, step.a).fill(apply(static_cast<Operator>(step.more), of));
      break;
    }
    case Op::change: {
      const std::string* origin = slot(task, step.b).origin;
      Value value = take_value(task, step.b, step);
      change(slot(task, step.a), std::move(value), origin, *source(step).statement);
      break;
    }
    case Op::jump:
      task.pc = target;
      return;
    case Op::jump_unless: {
      const char* of = source(step).statement->kind == Statement::Kind::while_loop ? "while" : "if";
      task.pc = take_boolean(task, step.b, step, of) ? task.pc + 1 : target;
      return;
    }
    case Op::settle: {
      const bool* left = slot(task, step.b).value.as_boolean();
      const bool settles = left && *left == (static_cast<Operator>(step.more) == Operator::logical_or);
      task.pc = settles ? target : task.pc + 1;
      return;
    }
    case Op::for_next:
    case Op::for_again:
      return next_of_for(task, step);
    case Op::element: {
      const Value place = take_value(task, step.c, step);
      const bool variable = where(step.b) == Where::local || where(step.b) == Where::global;
      const Value list = variable ? slot(task, step.b).value : take_value(task, step.b, step);
      slot(task, step.a).fill(element(list, place));
      break;
    }
    case Op::field:
      take_field(task, step);
      break;
    case Op::set_element:
      set_element(task, step);
      break;
    case Op::set_field:
      set_field(task, step);
      break;
    case Op::append:
      append(task, step);
      break;
    case Op::call:
      if (task.frames.size() > kDeepestCalls)
        fail_at(source(step).place, "too-deep",
                "functions call one another more than " + std::to_string(kDeepestCalls) + " deep",
                "write a loop, or end the recursion earlier");
      return enter_function(task, step);
    case Op::give:
      return give(task, step);
    case Op::let_go:
      let_go(task, step.a, step.b);
      break;
    default: {
      if (step.op < Op::unless_equal) {
        calculate(task, step);
        break;
      }
      const Value right = take_value(task, step.c, step), left = take_value(task, step.b, step);
      charge_for(left);
      const bool truth = *apply(static_cast<Operator>(step.more), left, right).as_boolean();
      task.pc = truth == is_when(step.op) ? target : task.pc + 1;
      return;
    }
  }
  ++task.pc;
}

// Other values.

void Interpreter::execute_value(Task& task, const Step& step) {
  switch (step.op) {
    case Op::absent:
      slot(task, step.a) = {{}, nullptr, false};
      break;
    case Op::host:
      if (!push_host(task, step)) return;
      break;
    case Op::joined:
      join_texts(task, step);
      break;
    case Op::list:
    case Op::record:
      make_parts(task, step);
      break;
    case Op::builtin:
    case Op::of_host:
      call_function(task, step);
      break;
    case Op::answered:
      if (!take_answer(task, step)) return;
      break;
    default: {  // here
      if (!arrived(task)) return;
      const MoveDefaults use = task.uses.empty() ? MoveDefaults{} : task.uses.back();
      Value place = host_.here(use.robot, use.tool, use.frame_pose ? std::string{} : use.frame);
      if (use.frame_pose && place.as_point())
        place = data::Point{inverse(*use.frame_pose) * place.as_point()->pose, false};
      slot(task, step.a).fill(std::move(place));
      break;
    }
  }
  ++task.pc;
}

void Interpreter::join_texts(Task& task, const Step& step) {
  constexpr std::size_t kBytesOfAStep = 4;  // most of them are digits
  require_values(task, step, step.b, step.c);
  std::string text;
  for (int i = step.b; i < step.b + step.c; ++i) {
    Value& part = task.local(i).value;
    if (part.as_text()) {
      text += *part.as_text();
    } else {
      text += part.text();
    }
    part = false;
  }
  charge(text.size() / kBytesOfAStep);
  if (text.size() > kLongestText) static_cast<void>(apply(Operator::add, Value(std::move(text)), Value("")));
  slot(task, step.a).fill(Value(std::move(text)));
}

void Interpreter::make_parts(Task& task, const Step& step) {
  require_values(task, step, step.b, step.c);
  data::List items(static_cast<std::size_t>(step.c));
  for (int i = 0; i < step.c; ++i)
    items[static_cast<std::size_t>(i)] = std::move(task.local(step.b + i).value);
  Value made = step.op == Op::list ? make_list(std::move(items))
                                   : make_record({at(code_.name_lists, step.d), std::move(items)});
  slot(task, step.a).fill(std::move(made));
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
  const std::string& wanted = at(code_.texts, step.b);
  const Value* found = host_.find(wanted);
  std::string_view rest;
  for (std::size_t dot = wanted.rfind('.'); !found && dot != std::string::npos && dot > 0;
       dot = wanted.rfind('.', dot - 1)) {
    found = host_.find(std::string_view(wanted).substr(0, dot));
    rest = std::string_view(wanted).substr(dot + 1);
  }
  if (!found) {
    auto names = host_.names();
    fail_at(source(step).place, "unknown-name",
            "there is nothing called '" + wanted + "'" + did_you_mean(wanted, names),
            "names are data, points, tags and what `let` made");
  }
  if (waits_for_motion(*found) && !arrived(task)) return false;
  Value value = *found;
  if (!rest.empty())
    for (const std::string& part : split_fields(rest, '.')) value = field(value, part);
  const bool whole = rest.empty() && value.is_place();
  slot(task, step.a) = {std::move(value), whole ? &wanted : nullptr, true};
  return true;
}

/// The name of a point is what the host calls it.
void Interpreter::take_field(Task& task, const Step& step) {
  const std::string& name = at(code_.texts, step.c);
  const std::string* origin = slot(task, step.b).origin;
  const Value of = take_value(task, step.b, step);
  Value part = name == "name" && of.is_place() ? Value(origin ? *origin : of.text()) : field(of, name);
  slot(task, step.a).fill(std::move(part));
}

void Interpreter::call_function(Task& task, const Step& step) {
  const Function& function = functions()[step.more];
  require_values(task, step, step.b, step.c);
  arguments_.clear();
  for (int i = 0; i < step.c; ++i) arguments_.push_back(std::move(task.local(step.b + i).value));
  for (std::size_t i = 0; i < arguments_.size(); ++i) require(function, i, arguments_[i]);
  Value result = step.op == Op::builtin
                     ? function.call(arguments_, at(code_.name_lists, step.d))
                     : host_.call(function.name, arguments_, program_.at(source(step).place));
  arguments_.clear();
  charge_for(result);
  slot(task, step.a).fill(std::move(result));
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
bool Interpreter::take_answer(Task& task, const Step& step) {
  const Value like = take_value(task, step.a, step);
  std::optional<Value> given = understood(std::string(trim(host_.answer())), like);
  if (given) {
    slot(task, step.a).fill(std::move(*given));
    return true;
  }
  host_.log("the answer is " + described(like) + ", such as " + like.text(), program_.at(source(step).line));
  task.pc = static_cast<std::size_t>(step.d);
  return false;
}

}  // namespace polyarm::program
