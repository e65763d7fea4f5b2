#include <algorithm>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/vm/task.hpp"

/// Steps that create, change and fill names.
namespace polyarm::program {

void Interpreter::execute_name(Task& task, const Step& step) {
  switch (step.op) {
    case Op::check_new:
      if (host_.find(at(code_.texts, step.a)))
        fail_at(source(step).place, "shadowing", "there is a '" + at(code_.texts, step.a) + "' already",
                "choose another name, or change it with `set`");
      break;
    case Op::let_global: {
      const std::string* origin = slot(task, step.b).origin;
      Value value = take_value(task, step.b, step);
      slot(task, step.a) = {std::move(value), origin, true};
      break;
    }
    case Op::set_host:
      if (!set_host(task, step)) return;
      break;
    case Op::set_literal:
      set_literal(task, step);
      break;
    case Op::replace:
      if (!replace_part(task, step)) return;
      break;
    default:  // given
      if (task.local(step.a).set) {
        task.pc = static_cast<std::size_t>(step.d);
        return;
      }
      break;
  }
  ++task.pc;
}

/// A name keeps its type and unit.
void Interpreter::check_type(const Value& present, const Value& value, const Statement& s) const {
  if (same_type(present, value)) return;
  fail_at(s.name_place, "bad-type",
          "'" + s.name + "' is " + described(present) + " (" + present.excerpt(60) + ") and cannot become " +
              described(value) + " (" + value.excerpt(60) + ")",
          "a name keeps its type and unit");
}

void Interpreter::change(Slot& variable, Value value, const std::string* origin, const Statement& s) {
  if (!variable.set)
    fail_at(s.name_place, "no-value", "'" + s.name + "' has no value yet", "its `let` comes later");
  check_type(variable.value, value, s);
  variable = {std::move(value), origin, true};
}

bool Interpreter::set_host(Task& task, const Step& step) {
  const std::string& name = at(code_.texts, step.a);
  const Place place = source(step).place;
  const Value* present = host_.find(name);
  if (!present)
    fail_at(place, "unknown-name",
            "there is nothing called '" + name + "'" + did_you_mean(name, host_.names()),
            "write `let " + name + " = …` to make it");
  if (!arrived(task)) return false;
  Value value = take_value(task, step.b, step);
  check_type(*present, value, *source(step).statement);
  host_.set(name, std::move(value), program_.at(source(step).line));
  return true;
}

void Interpreter::set_literal(Task& task, const Step& step) {
  const Statement& s = *source(step).statement;
  if (step.a == kNone) return host_.set(s.name, s.literal, program_.at(s.place));
  slot(task, step.a) = {s.literal, nullptr, true};
}

// Parts of variables.

bool Interpreter::set_element(Task& task, const Step& step) {
  value_of(task, step.c, step);
  const PathStep path{{}, slot(task, step.b).value};
  Value& whole = slot(task, step.a).value;
  if (!part_from_others(task, whole, {&path, 1})) return false;
  drop(task, step.b);
  replace(whole, {&path, 1}, take_value(task, step.c, step));
  return true;
}

bool Interpreter::set_field(Task& task, const Step& step) {
  value_of(task, step.b, step);
  const PathStep path{at(code_.texts, step.c), {}};
  Value& whole = slot(task, step.a).value;
  if (!part_from_others(task, whole, {&path, 1})) return false;
  replace(whole, {&path, 1}, take_value(task, step.b, step));
  return true;
}

/// set l = l + […]
bool Interpreter::append(Task& task, const Step& step) {
  const Place sum = at(code_.places, step.d), list = at(code_.places, step.d + 1);
  Slot& variable = slot(task, step.a);
  Place place = list;
  try {
    for (int i = step.b + step.c - 1; i >= step.b; --i)
      if (!task.local(i).set)
        fail_at(list, "no-value", "a value was expected, but this function returns none",
                "write `return` with a value in it");
    const auto more_values = static_cast<std::size_t>(step.c);
    if (variable.set && variable.value.as_list() && !part_from_others(task, variable.value, {}, more_values))
      return false;
    data::List items;
    for (int i = 0; i < step.c; ++i) items.push_back(std::move(task.local(step.b + i).value));
    const Value more = make_list(std::move(items));
    place = sum;
    if (!variable.set)
      fail_at(sum, "no-value", "a value was expected, but this function returns none",
              "write `return` with a value in it");
    if (!variable.value.as_list()) {
      change(variable, apply(Operator::add, variable.value, more), nullptr, *source(step).statement);
      return true;
    }
    const Value::Extent a = variable.value.extent(), b = more.extent();
    require_fits({a.values + b.values - 1, std::max(a.depth, b.depth)});
    for (const Value& part : *more.as_list()) variable.value.append(part);
    variable.origin = nullptr;
  } catch (const OperationError& error) {
    fail_at(place, error.code, error.what, error.advice);
  }
  return true;
}

/// Consecutive registers hold the indices and the new value.
bool Interpreter::replace_part(Task& task, const Step& step) {
  const Statement& s = *source(step).statement;
  const Operand from = operand(Where::temporary, step.b + step.d);
  value_of(task, from, step);
  std::vector<PathStep> path;
  for (const std::string& part : at(code_.name_lists, step.c)) path.push_back({part, {}});
  int next = step.b;
  for (const PathPart& part : s.path) {
    if (part.index) {
      path.push_back({{}, task.local(next++).value});
    } else {
      path.push_back({part.field, {}});
    }
  }
  Value& whole = slot(task, step.a).value;
  if (!part_from_others(task, whole, path)) return false;
  replace(whole, path, take_value(task, from, step));
  return true;
}

}  // namespace polyarm::program
