#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "polyarm/base/quantity.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/data/point_frames.hpp"
#include "polyarm/language/functions.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/language/text_functions.hpp"
#include "polyarm/vm/task.hpp"

namespace polyarm::program {

void Interpreter::fail_at(Place place, std::string code, std::string what, std::string advice) const {
  throw Error(Problem{std::move(code), program_.at(place), std::move(what), std::move(advice)});
}

/// Executes one step. If it cannot be completed yet, the task waits before it.
void Interpreter::execute(Task& task) {
  const Step& step = code_.steps[task.pc];
  task.line = source(step).line;
  try {
    if (step.op <= Op::release_now) return execute_plain(task, step);
    if (step.op <= Op::here) return execute_value(task, step);
    if (step.op <= Op::given) return execute_name(task, step);
    if (step.op <= Op::pulse) return execute_world(task, step);
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
  const Value& from = value_of(task, operand, step);
  if (where(operand) == Where::temporary) return std::move(slot(task, operand).value);
  return from;
}

void Interpreter::require_values(Task& task, const Step& step, int first, int count) {
  for (int i = first; i < first + count; ++i)
    if (!task.local(i).set)
      fail_at(source(step).place, "no-value", "a value was expected, but this function returns none",
              "write `return` with a value in it");
}

const Value& Interpreter::value_of(Task& task, Operand operand, const Step& step) {
  const Slot& from = slot(task, operand);
  if (!from.set)
    fail_at(source(step).place, "no-value", "a value was expected, but this function returns none",
            "write `return` with a value in it");
  return from.value;
}

void Interpreter::drop(Task& task, Operand operand) {
  if (where(operand) == Where::temporary) slot(task, operand).fill_plain(false);
}

bool Interpreter::take_boolean(Task& task, Operand operand, const Step& step, const char* of) {
  const Value value = take_value(task, operand, step);
  if (const bool* truth = value.as_boolean()) return *truth;
  fail_at(source(step).place, "bad-type",
          std::string("the condition of '") + of + "' is " + data::name(value.kind()) + " (" +
              value.excerpt(60) + "), True or False was expected");
}

void Interpreter::charge_for(const Value& value) {
  constexpr std::size_t kBytesOfAStep = 64;
  if (value.as_text()) charge(value.as_text()->size() / kBytesOfAStep);
}

// Large values.

bool Interpreter::continue_work(Task& task) {
  charge(static_cast<std::size_t>(task.work->go_on()));
  return task.work->done();
}

bool Interpreter::part_from_others(Task& task, Value& whole, std::span<const PathStep> path,
                                   std::size_t more) {
  constexpr std::size_t kTimes = 4;  // moving costs more than unused memory
  Value* at = &whole;
  for (std::size_t deep = 0; at->as_list() || at->as_record(); ++deep) {
    const bool large = at->as_list() && at->as_list()->size() > kLargeList;
    const bool grows = large && deep == path.size() && more > 0;
    if (large && (!at->is_alone() || (grows && moves_when_growing(*at->as_list(), more)))) {
      const bool begun = task.work && static_cast<Copying&>(*task.work).is_of(*at);
      const std::size_t room = grows ? std::min(kTimes * at->as_list()->size(), kMostListItems + more) : 0;
      if (!begun) task.work = std::make_unique<Copying>(*at, Value(data::List{}), room);
      if (!continue_work(task)) return false;
      *at = static_cast<Copying&>(*task.work).take();
      task.work.reset();
    }
    if (deep == path.size()) break;
    const std::size_t part = part_at(*at, path[deep]);
    at = &(*at->own_parts())[part];
  }
  task.work.reset();
  return true;
}

bool Interpreter::write(Task& task, int first, int count, std::string_view between, std::string& text) {
  bool plain = true;
  for (int i = first; i < first + count; ++i) {
    const Value& part = task.local(i).value;
    plain = plain && !part.as_list() && !part.as_record();
  }
  if (plain) {
    constexpr std::size_t kBytesOfAStep = 4;  // most of them are digits
    for (int i = first; i < first + count && text.size() <= kLongestText; ++i) {
      const Value& part = task.local(i).value;
      if (i > first) text += between;
      text += part.as_text() ? *part.as_text() : shown_text(part);
    }
    charge(text.size() / kBytesOfAStep);
    return true;
  }
  if (!task.work) {
    data::List parts;
    for (int i = first; i < first + count; ++i) parts.push_back(task.local(i).value);
    task.work = std::make_unique<Writing>(std::move(parts), between);
  }
  if (!continue_work(task)) return false;
  text = static_cast<Writing&>(*task.work).take();
  task.work.reset();
  return true;
}

// Plain steps, for any values.

/// The result of a binary operator; false: not finished yet. Lists are copied and compared in pieces.
bool Interpreter::result_of(Task& task, const Step& step, Value& result) {
  const auto op = static_cast<Operator>(step.more);
  const Value &right = value_of(task, step.c, step), &left = value_of(task, step.b, step);
  const bool same_kind = left.kind() == right.kind();
  const bool joins = op == Operator::add && left.as_list() && right.as_list() &&
                     left.as_list()->size() + right.as_list()->size() > kLargeList;
  const bool compares = (op == Operator::equal || op == Operator::unequal) && same_kind && is_large(left);
  if (!joins && !compares && !task.work) {
    if (is_comparison(op)) charge_for(left);
    result = apply(op, left, right);
    charge_for(result);
    return true;
  }
  if (joins && !task.work) {
    const Value::Extent a = left.extent(), b = right.extent();
    require_fits({a.values + b.values - 1, std::max(a.depth, b.depth)});
    task.work = std::make_unique<Copying>(left, right);
  }
  if (!task.work) task.work = std::make_unique<Comparing>(left, right);
  if (!continue_work(task)) return false;
  result = op == Operator::add
               ? static_cast<Copying&>(*task.work).take()
               : Value(static_cast<Comparing&>(*task.work).equal() == (op == Operator::equal));
  task.work.reset();
  return true;
}

bool Interpreter::calculate(Task& task, const Step& step) {
  Value result;
  if (!result_of(task, step, result)) return false;
  drop(task, step.b);
  drop(task, step.c);
  slot(task, step.a).fill(std::move(result));
  return true;
}

/// Appends to a text in place.
bool Interpreter::calculate_into_variable(Task& task, const Step& step) {
  const auto op = static_cast<Operator>(step.more);
  Slot& variable = slot(task, step.a);
  const Value& right = value_of(task, step.c, step);
  const bool grows = op == Operator::add && step.b == step.a && variable.set && variable.value.as_text() &&
                     right.as_text() &&
                     variable.value.as_text()->size() + right.as_text()->size() <= kLongestText;
  if (grows) {
    charge_for(right);
    const Value more = take_value(task, step.c, step);  // it may be the same text
    variable.value.append(std::string_view(*more.as_text()));
    return true;
  }
  Value result;
  if (!result_of(task, step, result)) return false;
  drop(task, step.b);
  drop(task, step.c);
  change(variable, std::move(result), nullptr, *source(step).statement);
  return true;
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
      if (!calculate_into_variable(task, step)) return;
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
      if (!set_element(task, step)) return;
      break;
    case Op::set_field:
      if (!set_field(task, step)) return;
      break;
    case Op::append:
      if (!append(task, step)) return;
      break;
    case Op::call:
      if (is_too_deep(task, step))
        fail_at(source(step).place, "too-deep",
                "functions call one another more than " + std::to_string(task.frames.size() - 1) + " deep",
                "write a loop, or end the recursion earlier");
      return enter_function(task, step);
    case Op::give:
      return give(task, step);
    case Op::release_now:
      release_now(task, step.a, step.b);
      break;
    default: {
      if (step.op < Op::unless_equal) {
        if (!calculate(task, step)) return;
        break;
      }
      Value result;
      if (!result_of(task, step, result)) return;
      drop(task, step.b);
      drop(task, step.c);
      const bool truth = *result.as_boolean();
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
      if (!join_texts(task, step)) return;
      break;
    case Op::list:
    case Op::record:
      make_parts(task, step);
      break;
    case Op::builtin:
    case Op::of_host:
      if (!call_function(task, step)) return;
      break;
    case Op::answered:
      if (!take_answer(task, step)) return;
      break;
    default: {  // here
      if (!arrived(task)) return;
      const MoveDefaults use = task.uses.empty() ? MoveDefaults{} : task.uses.back();
      Value place = host_.here(use.robot, use.tool, use.named_frame());
      if (use.frame_pose && place.as_point())
        place = data::Point{inverse(*use.frame_pose) * place.as_point()->pose, false};
      slot(task, step.a).fill(std::move(place));
      break;
    }
  }
  ++task.pc;
}

bool Interpreter::join_texts(Task& task, const Step& step) {
  require_values(task, step, step.b, step.c);
  std::string text;
  if (!write(task, step.b, step.c, {}, text)) return false;
  for (int i = step.b; i < step.b + step.c; ++i) task.local(i).value = false;
  if (text.size() > kLongestText) static_cast<void>(apply(Operator::add, Value(std::move(text)), Value("")));
  slot(task, step.a).fill(Value(std::move(text)));
  return true;
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
/// Points are read when their line is reached; any other host value may depend on what has moved.
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
            "names are data, points, tags and variables of `let`");
  }
  if (waits_for_motion(*found) && !arrived(task)) return false;
  Value value = *found;
  if (!rest.empty())
    for (const std::string& part : split_fields(rest, '.')) value = field(value, part);
  const bool whole = rest.empty() && value.is_place();
  slot(task, step.a) = {std::move(value), whole ? &wanted : nullptr, true};
  return true;
}

/// The name of a point is its name in the host.
void Interpreter::take_field(Task& task, const Step& step) {
  const std::string& name = at(code_.texts, step.c);
  const std::string* origin = slot(task, step.b).origin;
  const Value of = take_value(task, step.b, step);
  Value part = name == "name" && of.is_place() ? Value(origin ? *origin : of.text()) : field(of, name);
  slot(task, step.a).fill(std::move(part));
}

namespace {
constexpr std::size_t kStepsOfAListItem = 8;
}  // namespace

/// A pose without a frame is in the frame in use. Beside one that has a frame it is converted: otherwise
/// their numbers would be compared although they count from different places.
void Interpreter::use_one_frame(const Task& task, std::span<Value> arguments) const {
  const MoveDefaults use = task.uses.empty() ? MoveDefaults{} : task.uses.back();
  const std::string frame = use.named_frame().empty() ? "world" : use.named_frame();
  const bool of_world = !use.frame_pose && frame == "world";
  const auto framed = [](const Value& value) {
    return value.as_point() && !value.as_point()->frame().empty();
  };
  const auto differs = [&](const Value& value) {
    return framed(value) && !(of_world && value.as_point()->frame() == "world");
  };
  if (std::none_of(arguments.begin(), arguments.end(), differs)) return;
  for (Value& value : arguments) {
    if (!value.as_point() || framed(value)) continue;
    data::Point point = *value.as_point();
    if (use.frame_pose) point.pose = *use.frame_pose * point.pose;
    const Quaternion axes = use.frame_pose ? use.frame_pose->rotation : Quaternion{};
    value = host_.in_world(data::converted(std::move(point), frame, axes));
  }
}

bool Interpreter::call_function(Task& task, const Step& step) {
  const Function& function = functions()[step.more];
  require_values(task, step, step.b, step.c);
  if (function.series) return call_in_pieces(task, step);
  const bool near_given = function.live == Live::ik && task.local(step.b + 1).value.as_joints();
  if (function.waits && !near_given && !arrived(task)) return false;
  arguments_.clear();
  for (int i = 0; i < step.c; ++i) arguments_.push_back(std::move(task.local(step.b + i).value));
  for (std::size_t i = 0; i < arguments_.size(); ++i) require(function, i, arguments_[i]);
  if (function.one_frame) use_one_frame(task, arguments_);
  for (const Value& argument : arguments_) charge_for(argument);
  Value result = step.op == Op::builtin ? function.call(arguments_, at(code_.name_lists, step.d))
                 : function.live != Live::none
                     ? live_call(task, function)
                     : host_.call(function.name, arguments_, program_.at(source(step).place));
  arguments_.clear();
  charge_for(result);
  if (result.as_list()) charge(kStepsOfAListItem * result.as_list()->size());
  slot(task, step.a).fill(std::move(result));
  return true;
}

bool Interpreter::call_in_pieces(Task& task, const Step& step) {
  const Function& function = functions()[step.more];
  if (!task.work) {
    data::List arguments;
    for (int i = 0; i < step.c; ++i) arguments.push_back(task.local(step.b + i).value);
    for (std::size_t i = 0; i < arguments.size(); ++i) require(function, i, arguments[i]);
    if (function.one_frame) use_one_frame(task, arguments);
    task.work = std::make_unique<Making>(function.series(arguments));
  }
  if (!continue_work(task)) return false;
  Value result = static_cast<Making&>(*task.work).take();
  task.work.reset();
  release_now(task, step.b, step.c);
  slot(task, step.a).fill(std::move(result));
  return true;
}

namespace {
/// Parses the user's answer, which must be like `like`.
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

/// False if the answer does not match the example: the question is repeated.
bool Interpreter::take_answer(Task& task, const Step& step) {
  const Value like = take_value(task, step.a, step);
  std::optional<Value> given = understood(std::string(trim(host_.answer(like))), like);
  if (given) {
    slot(task, step.a).fill(std::move(*given));
    return true;
  }
  task.refused = "the answer is " + described(like) + ", such as " + like.text();
  host_.log(task.refused, program_.at(source(step).line));
  task.pc = static_cast<std::size_t>(step.d);
  return false;
}

}  // namespace polyarm::program
