/// The steps that programs calculate with most, for plain numbers and booleans. What is not plain is left to
/// the steps in execute.cpp, which also say what is wrong.
#include <cmath>
#include <cstdint>

#include "polyarm/program/task.hpp"

namespace polyarm::program {

using data::Number;

/// What a step calculates: a number, or a boolean.
struct Plain {
  bool is_boolean = false, truth = false;
  Number number;
};

namespace {

Number* number_in(Value& value) {
  return value.own_number();
}

bool is_load(Op op) {
  return op == Op::constant || op == Op::local || op == Op::global;
}

/// As std::fmod, and quicker for whole numbers.
double remainder_of(double a, double b) {
  constexpr double kWhole = 9e15;
  const bool fits = a > -kWhole && a < kWhole && b > -kWhole && b < kWhole;
  const std::int64_t m = fits ? static_cast<std::int64_t>(a) : 0, n = fits ? static_cast<std::int64_t>(b) : 0;
  const bool whole = n != 0 && static_cast<double>(m) == a && static_cast<double>(n) == b;
  const double rest = whole ? static_cast<double>(m % n) : std::fmod(a, b);
  return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}

bool as_truth(bool truth, Plain& out) {
  out.is_boolean = true;
  out.truth = truth;
  return true;
}

bool as_number(double value, Dimension dimension, Plain& out) {
  out.is_boolean = false;
  out.number = {value, dimension};
  return std::isfinite(value);
}

/// Of two numbers; false where units or the result need a closer look.
bool calculate(Operator op, const Number& a, const Number& b, Plain& out) {
  const bool alike = a.dimension == b.dimension;
  const bool bare_a = a.dimension == Dimension::none, bare_b = b.dimension == Dimension::none;
  switch (op) {
    case Operator::add:
      return alike && as_number(a.value + b.value, a.dimension, out);
    case Operator::subtract:
      return alike && as_number(a.value - b.value, a.dimension, out);
    case Operator::multiply:
      return (bare_a || bare_b) && as_number(a.value * b.value, bare_b ? a.dimension : b.dimension, out);
    case Operator::divide:
      return (bare_b || alike) && b.value != 0 &&
             as_number(a.value / b.value, bare_b ? a.dimension : Dimension::none, out);
    case Operator::modulo:
      return alike && b.value != 0 && as_number(remainder_of(a.value, b.value), a.dimension, out);
    case Operator::equal:
      return alike && as_truth(a.value == b.value, out);
    case Operator::unequal:
      return alike && as_truth(a.value != b.value, out);
    case Operator::less:
      return alike && as_truth(a.value < b.value, out);
    case Operator::less_equal:
      return alike && as_truth(a.value <= b.value, out);
    case Operator::greater:
      return alike && as_truth(a.value > b.value, out);
    case Operator::greater_equal:
      return alike && as_truth(a.value >= b.value, out);
    default:
      return false;
  }
}

void push(std::vector<Slot>& stack, const Plain& plain) {
  if (plain.is_boolean) {
    stack.emplace_back(plain.truth);
  } else {
    stack.emplace_back(plain.number);
  }
}

void put(Slot& slot, const Plain& plain) {
  Number* number = plain.is_boolean ? nullptr : number_in(slot.value);
  if (number) {
    *number = plain.number;
  } else if (plain.is_boolean) {
    slot.value = plain.truth;
  } else {
    slot.value = plain.number;
  }
  slot.origin = nullptr;
}

const Number* number_of_slot(const Slot& slot) {
  return slot.set ? slot.value.as_number() : nullptr;
}

/// A variable keeps its unit.
bool change_number(Slot& slot, const Number& next) {
  Number* now = slot.set ? number_in(slot.value) : nullptr;
  if (!now || now->dimension != next.dimension) return false;
  *now = next;
  slot.origin = nullptr;
  return true;
}

const Number* element_of(const Slot& from, const Number& at) {
  const data::List* list = from.set ? from.value.as_list() : nullptr;
  if (!list || at.dimension != Dimension::none) return nullptr;
  if (!(at.value >= 1) || !(at.value <= static_cast<double>(list->size())) ||
      at.value != std::floor(at.value))
    return nullptr;
  return (*list)[static_cast<std::size_t>(at.value) - 1].as_number();
}

}  // namespace

/// What a step that loads something loads, where that is a number.
const Number* Interpreter::loaded_number(Task& task, const Step& step) const {
  if (step.op == Op::constant) return at(code_.constants, step.a).as_number();
  if (step.op == Op::local) return number_of_slot(task.local(step.a));
  return step.op == Op::global ? number_of_slot(at(globals_, step.a)) : nullptr;
}

/// What has been calculated goes where the step behind wants it, without a way over the stack.
void Interpreter::hand_on(Task& task, const Plain& plain, const Step& next, std::size_t pc) {
  task.pc = pc;
  if (!next.begins && plain.is_boolean && next.op == Op::jump_unless) {
    task.pc = plain.truth ? pc + 1 : static_cast<std::size_t>(next.c);
    return;
  }
  const bool sets = next.op == Op::set_local || next.op == Op::set_global;
  if (!next.begins && !plain.is_boolean && sets) {
    Slot& slot = next.op == Op::set_local ? task.local(next.a) : at(globals_, next.a);
    if (change_number(slot, plain.number)) {
      ++task.pc;
      return;
    }
  }
  push(task.stack, plain);
}

/// `step` loads something: with the operator behind it, where there is one.
bool Interpreter::quick_load(Task& task, const Step& step) {
  const Number* a = loaded_number(task, step);
  const Step* next = &step + 1;
  if (!a) {
    const Slot* slot = step.op == Op::local    ? &task.local(step.a)
                       : step.op == Op::global ? &at(globals_, step.a)
                                               : nullptr;
    const bool* truth = slot && slot->set ? slot->value.as_boolean() : nullptr;
    if (!truth) return false;
    hand_on(task, Plain{true, *truth, {}}, *next, task.pc + 1);
    return true;
  }
  Plain result;
  if (is_load(next->op) && next[1].op == Op::binary) {  // a b op
    const Number* b = loaded_number(task, *next);
    if (b && calculate(static_cast<Operator>(next[1].a), *a, *b, result)) {
      hand_on(task, result, next[2], task.pc + 3);
      return true;
    }
  } else if (next->op == Op::binary) {  // … b op
    const Number* left = number_of_slot(task.stack.back());
    if (left && calculate(static_cast<Operator>(next->a), *left, *a, result)) {
      if (result.is_boolean || next[1].op == Op::set_local || next[1].op == Op::set_global) {
        task.stack.pop_back();
        hand_on(task, result, next[1], task.pc + 2);
      } else {
        put(task.stack.back(), result);
        task.pc += 2;
      }
      return true;
    }
  }
  task.stack.emplace_back(Number(*a));
  ++task.pc;
  return true;
}

/// Both operands are on the stack.
bool Interpreter::quick_binary(Task& task, const Step& step) {
  std::vector<Slot>& stack = task.stack;
  Slot &left = stack[stack.size() - 2], &right = stack.back();
  const auto op = static_cast<Operator>(step.a);
  const Number *a = number_of_slot(left), *b = number_of_slot(right);
  Plain result;
  if (a && b) {
    if (!calculate(op, *a, *b, result)) return false;
  } else {
    const bool *p = left.value.as_boolean(), *q = right.value.as_boolean();
    if (!p || !q || !left.set || !right.set) return false;
    if (op != Operator::logical_and && op != Operator::logical_or) return false;
    as_truth(op == Operator::logical_and ? *p && *q : *p || *q, result);
  }
  stack.pop_back();
  put(stack.back(), result);
  ++task.pc;
  return true;
}

/// A range of numbers that names no places.
bool Interpreter::quick_for(Task& task, const Step& step) {
  if (step.b == 1) return false;
  const Number* last = number_of_slot(task.local(step.a + 1));
  Number *count = number_in(task.local(step.a).value), *now = number_in(task.local(step.a + 2).value);
  if (!last || !count || !now) return false;
  now->value += count->value > 0 ? 1 : 0;
  count->value += 1;
  task.pc = now->value <= last->value ? task.pc + 1 : static_cast<std::size_t>(step.c);
  return true;
}

/// True where the step has been taken, and some behind it.
bool Interpreter::quick(Task& task, const Step& step) {
  std::vector<Slot>& stack = task.stack;
  switch (step.op) {
    case Op::constant:
    case Op::local:
    case Op::global:
      return quick_load(task, step);
    case Op::binary:
      return quick_binary(task, step);
    case Op::for_next:
      return quick_for(task, step);
    case Op::local_element:
    case Op::global_element: {
      const Number* place = number_of_slot(stack.back());
      const Slot& list = step.op == Op::local_element ? task.local(step.a) : at(globals_, step.a);
      const Number* element = place ? element_of(list, *place) : nullptr;
      if (!element) return false;
      put(stack.back(), Plain{false, false, *element});
      break;
    }
    case Op::set_local:
    case Op::set_global: {
      const Number* next = number_of_slot(stack.back());
      Slot& slot = step.op == Op::set_local ? task.local(step.a) : at(globals_, step.a);
      if (!next || !change_number(slot, *next)) return false;
      stack.pop_back();
      break;
    }
    case Op::settle: {
      const bool* left = stack.back().set ? stack.back().value.as_boolean() : nullptr;
      if (!left) return false;
      if (*left != (static_cast<Operator>(step.a) == Operator::logical_or)) break;
      task.pc = static_cast<std::size_t>(step.c);
      return true;
    }
    case Op::jump:
      task.pc = static_cast<std::size_t>(step.c);
      return true;
    case Op::jump_unless: {
      const bool* truth = stack.back().set ? stack.back().value.as_boolean() : nullptr;
      if (!truth) return false;
      task.pc = *truth ? task.pc + 1 : static_cast<std::size_t>(step.c);
      stack.pop_back();
      return true;
    }
    default:
      return false;
  }
  ++task.pc;
  return true;
}

}  // namespace polyarm::program
