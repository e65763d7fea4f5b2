/// The most frequent steps, for plain values. Other values and errors are left to execute.cpp, which can
/// execute every step.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "polyarm/language/operators.hpp"
#include "polyarm/language/rounding.hpp"
#include "polyarm/vm/task.hpp"

namespace polyarm::program {

using data::Number;

namespace {

/// The location of operands by kind.
struct Operands {
  Slot* of[4];
  Slot& operator[](Operand operand) const {
    const auto bits = static_cast<std::uint32_t>(operand);
    return *reinterpret_cast<Slot*>(reinterpret_cast<char*>(of[bits & 3]) + (bits & ~3u));
  }
};

// Always inlined: a call costs more than most steps.
#define POLYARM_QUICK [[gnu::always_inline]] inline

/// As std::fmod, but faster for integers; with the sign of the divisor.
double remainder_of(double a, double b) {
  constexpr double kWhole = 9e15;
  double rest = a;
  const bool fits = std::abs(a) < kWhole && std::abs(b) < kWhole;
  const std::int64_t m = fits ? static_cast<std::int64_t>(a) : 0, n = fits ? static_cast<std::int64_t>(b) : 0;
  if (n != 0 && static_cast<double>(m) == a && static_cast<double>(n) == b) {
    rest = static_cast<double>(m % n);
  } else {
    rest = unrounded_rest(std::abs(a) < std::abs(b) ? a : std::fmod(a, b), a, b);
  }
  return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest + 0.0;  // never -0
}

/// False if units or the result need a closer check.
template <Operator op>
POLYARM_QUICK bool calculate(const Operands& at, const Step& step, Number& out) {
  const Slot &left = at[step.b], &right = at[step.c];
  const Number *a = left.value.as_number(), *b = right.value.as_number();
  if (!a || !b) return false;
  const bool bare_b = b->dimension == Dimension::none;
  Dimension dimension = a->dimension;
  double value = 0;
  if constexpr (op == Operator::multiply) {
    if (!bare_b) {
      if (dimension != Dimension::none) return false;
      dimension = b->dimension;
    }
    value = a->value * b->value;
  } else if constexpr (op == Operator::divide) {
    if (b->value == 0) return false;
    if (!bare_b) {
      if (dimension != b->dimension) return false;
      dimension = Dimension::none;
    }
    value = a->value / b->value;
  } else {
    if (dimension != b->dimension) return false;
    if constexpr (op == Operator::add) value = a->value + b->value;
    if constexpr (op == Operator::subtract) value = a->value - b->value;
    if constexpr (op == Operator::modulo) {
      if (b->value == 0) return false;
      value = remainder_of(a->value, b->value);
    }
  }
  out = {value, dimension};
  return std::isfinite(value);
}

template <Operator op>
POLYARM_QUICK bool into_register(const Operands& at, const Step& step) {
  Number out;
  if (!calculate<op>(at, step, out)) return false;
  at[step.a].fill_plain(out);
  return true;
}

/// A variable keeps its unit.
template <Operator op>
POLYARM_QUICK bool into_variable(const Operands& at, const Step& step) {
  Number out;
  Number* now = at[step.a].value.own_number();
  if (!now || !calculate<op>(at, step, out) || now->dimension != out.dimension) return false;
  now->value = out.value;
  return true;
}

/// Booleans and short texts.
bool equal_others(const Slot& a, const Slot& b, bool wanted, bool& truth) {
  constexpr std::size_t kLong = 256;
  if (!a.set || !b.set) return false;
  if (const bool* x = a.value.as_boolean(), *y = b.value.as_boolean(); x && y) {
    truth = (*x == *y) == wanted;
    return true;
  }
  const std::string *x = a.value.as_text(), *y = b.value.as_text();
  if (!x || !y || x->size() > kLong) return false;
  truth = (*x == *y) == wanted;
  return true;
}

template <Operator op>
POLYARM_QUICK bool compare(const Operands& at, const Step& step, bool& truth) {
  const Number *a = at[step.b].value.as_number(), *b = at[step.c].value.as_number();
  if (!a || !b) {
    if constexpr (op == Operator::equal || op == Operator::unequal)
      return equal_others(at[step.b], at[step.c], op == Operator::equal, truth);
    return false;
  }
  if (a->dimension != b->dimension) return false;
  if constexpr (op == Operator::equal) truth = equal_numbers(a->value, b->value);
  if constexpr (op == Operator::unequal) truth = !equal_numbers(a->value, b->value);
  if constexpr (op == Operator::less) truth = less_number(a->value, b->value);
  if constexpr (op == Operator::less_equal) truth = !less_number(b->value, a->value);
  if constexpr (op == Operator::greater) truth = less_number(b->value, a->value);
  if constexpr (op == Operator::greater_equal) truth = !less_number(a->value, b->value);
  return true;
}

POLYARM_QUICK const bool* truth_of(const Slot& slot) {
  return slot.set ? slot.value.as_boolean() : nullptr;
}

/// Operators without their own step.
bool other_operator(const Operands& at, const Step& step) {
  const auto op = static_cast<Operator>(step.more);
  bool truth = false, known = false;
  if (op == Operator::logical_and || op == Operator::logical_or) {
    const bool *a = truth_of(at[step.b]), *b = truth_of(at[step.c]);
    known = a && b;
    truth = known && (op == Operator::logical_and ? *a && *b : *a || *b);
  }
  if (op == Operator::equal) known = compare<Operator::equal>(at, step, truth);
  if (op == Operator::unequal) known = compare<Operator::unequal>(at, step, truth);
  if (op == Operator::less) known = compare<Operator::less>(at, step, truth);
  if (op == Operator::less_equal) known = compare<Operator::less_equal>(at, step, truth);
  if (op == Operator::greater) known = compare<Operator::greater>(at, step, truth);
  if (op == Operator::greater_equal) known = compare<Operator::greater_equal>(at, step, truth);
  if (known) at[step.a].fill_plain(truth);
  return known;
}

POLYARM_QUICK bool quick_unary(const Operands& at, const Step& step) {
  const Slot& of = at[step.b];
  if (static_cast<Operator>(step.more) == Operator::logical_not) {
    const bool* truth = truth_of(of);
    if (truth) at[step.a].fill_plain(!*truth);
    return truth != nullptr;
  }
  const Number* number = of.value.as_number();
  if (number) at[step.a].fill_plain(Number{-number->value, number->dimension});
  return number != nullptr;
}

POLYARM_QUICK bool quick_load(const Operands& at, const Step& step) {
  Slot& from = at[step.b];
  if (const Number* number = from.value.as_number()) {
    at[step.a].fill_plain(Number(*number));
    return true;
  }
  if (!from.set) return false;
  at[step.a] = where(step.b) == Where::temporary ? std::move(from) : from;
  return true;
}

POLYARM_QUICK bool quick_change(const Operands& at, const Step& step) {
  Slot &variable = at[step.a], &from = at[step.b];
  if (variable.value.kind() != from.value.kind() || !variable.set || !from.set) return false;
  if (const Number* number = from.value.as_number()) {
    Number* now = variable.value.own_number();
    if (now->dimension != number->dimension) return false;
    now->value = number->value;
    return true;
  }
  variable = where(step.b) == Where::temporary ? std::move(from) : from;
  return true;
}

/// True if `at` is an index into a list of this size.
POLYARM_QUICK bool is_place(const Number* at, std::size_t size, std::size_t& index) {
  if (!at || at->dimension != Dimension::none) return false;
  if (!(at->value >= 1) || !(at->value <= static_cast<double>(size))) return false;
  index = static_cast<std::size_t>(at->value);
  return static_cast<double>(index--) == at->value;
}

/// Reads a part of the value in `from`, which is released if it is not read again.
POLYARM_QUICK void take_part(const Operands& at, Operand to, Operand from, const Value& part) {
  const bool last = where(from) == Where::temporary && from != to;
  if (const Number* number = part.as_number()) {
    const Number taken = *number;
    if (last) at[from].fill_plain(false);
    at[to].fill_plain(taken);
    return;
  }
  Value taken = part;
  if (last) at[from].fill_plain(false);
  at[to].fill(std::move(taken));
}

POLYARM_QUICK bool quick_element(const Operands& at, const Step& step) {
  const data::List* list = at[step.b].value.as_list();
  std::size_t index = 0;
  if (!list || !is_place(at[step.c].value.as_number(), list->size(), index)) return false;
  take_part(at, step.a, step.b, (*list)[index]);
  return true;
}

POLYARM_QUICK bool has_parts(const Value& value) {
  return value.kind() == data::Kind::list || value.kind() == data::Kind::record;
}

/// Numbers and booleans need no release, and are never read before they are overwritten.
POLYARM_QUICK void forget(Slot* slots, int count) {
  for (int i = 0; i < count; ++i)
    if (slots[i].value.is_shared()) slots[i].fill_plain(false);
}

/// Replaces a part by `part` if both are alike.
POLYARM_QUICK bool replace(Value& whole, std::size_t index, const Value& present, const Slot& part) {
  if (!part.set || has_parts(part.value) || !same_type(present, part.value)) return false;
  if (!whole.is_alone()) return false;
  Value next = part.value;
  (*whole.own_parts())[index] = std::move(next);
  return true;
}

POLYARM_QUICK bool quick_set_element(const Operands& at, const Step& step) {
  Value& whole = at[step.a].value;
  const data::List* list = whole.as_list();
  std::size_t index = 0;
  if (!list || !is_place(at[step.b].value.as_number(), list->size(), index)) return false;
  return replace(whole, index, (*list)[index], at[step.c]);
}

/// Only along list indices; their number is in `more`.
POLYARM_QUICK bool quick_replace(const Operands& at, const Step& step) {
  Slot* const places = at.of[0] + step.b;
  Value* whole = &at[step.a].value;
  if (step.more == 0) return false;
  for (int i = 0;; ++i) {
    const data::List* list = whole->as_list();
    std::size_t index = 0;
    if (!list || !whole->is_alone() || !is_place(places[i].value.as_number(), list->size(), index))
      return false;
    if (i + 1 == step.d) return replace(*whole, index, (*list)[index], places[step.d]);
    whole = &(*whole->own_parts())[index];
  }
}

bool quick_append(const Operands& at, const Step& step) {
  constexpr std::uint32_t kDeepest = 8;
  Slot& list = at[step.a];
  if (!list.set || !list.value.as_list() || !list.value.is_alone()) return false;
  const Value::Extent extent = list.value.extent();
  const auto count = static_cast<std::uint32_t>(step.c);
  if (extent.depth > kDeepest || extent.values + count > kMostListItems + 1) return false;
  if (moves_when_growing(*list.value.as_list(), count)) return false;
  Slot* const parts = at.of[0] + step.b;
  for (std::uint32_t i = 0; i < count; ++i)
    if (!parts[i].set || has_parts(parts[i].value)) return false;
  for (std::uint32_t i = 0; i < count; ++i) list.value.append(std::move(parts[i].value));
  return true;
}

/// The end of a pass of a range without index name; true if there is a next number.
POLYARM_QUICK bool count_on(const Operands& at, const Step& step, bool& more) {
  Slot* const loop = at.of[0] + step.a;
  const Number* last = loop[1].value.as_number();
  Number* now = loop[2].value.own_number();
  if (step.b != 0 || !last || !now) return false;
  now->value += 1;
  more = now->value <= last->value;
  return true;
}

POLYARM_QUICK bool next_of_list(const Operands& at, const Step& step, bool& more) {
  Slot* const loop = at.of[0] + step.a;
  const data::List* list = loop[1].value.as_list();
  Number* done = loop[0].value.own_number();
  if (step.b != 0 || !list || !done || !(done->value >= 0)) return false;
  more = done->value < static_cast<double>(list->size());
  if (more) loop[2].fill((*list)[static_cast<std::size_t>(done->value)]);
  done->value += 1;
  return true;
}

}  // namespace

/// The position in `record` of the field that `step` names. Tries the cached position first.
bool Interpreter::at_field(const data::Record& record, const Step& step, std::size_t& at) {
  constexpr std::size_t kRemembered = 1024;
  if (found_.empty()) found_.resize(kRemembered);
  std::uint32_t& found = found_[step.more % kRemembered];
  const std::string& name = code_.texts[static_cast<std::size_t>(step.c)];
  at = found;
  if (at < record.names.size() && record.names[at] == name) return true;
  for (at = 0; at < record.names.size(); ++at) {
    if (record.names[at] != name) continue;
    found = static_cast<std::uint32_t>(at);
    return true;
  }
  return false;
}

bool Interpreter::is_too_deep(const Task& task, const Step& step) const {
  return task.frames.size() > kDeepestCalls ||
         task.frames.back().base + static_cast<std::size_t>(step.a + code_.registers) > kMostRegisters;
}

void Interpreter::enter_function(Task& task, const Step& step) {
  const std::size_t base = task.frame().base + static_cast<std::size_t>(step.a);
  task.frames.push_back({task.pc + 1, base, task.uses.size(), task.locks.size(), task.handlers.size()});
  const std::size_t needed = base + static_cast<std::size_t>(code_.registers);
  if (task.stack.capacity() < needed) task.stack.reserve(std::max(needed, kMostRegisters));
  if (task.stack.size() < needed) task.stack.resize(needed);
  task.pc = static_cast<std::size_t>(at(code_.functions, step.c).entry);
}

/// The result goes to the first register of the function, which is the caller's again.
void Interpreter::give(Task& task, const Step& step) {
  const CallFrame frame = task.frames.back();
  if (task.leaves_block() && !arrived(task)) return;
  Slot* const registers = task.stack.data() + frame.base;
  Slot& from = slot(task, step.b);
  const bool others = where(step.b) == Where::global || where(step.b) == Where::constant;
  Slot result = others ? from : std::move(from);
  forget(registers, at(code_.functions, step.c).registers);
  *registers = std::move(result);
  task.frames.pop_back();
  task.pc = frame.return_to;
  if (task.uses.size() != frame.uses) task.uses.resize(frame.uses);
  if (task.handlers.size() > frame.handlers) task.handlers.resize(frame.handlers);
  if (task.locks.size() > frame.locks) give_back_locks(task, frame.locks);
}

void Interpreter::release_now(Task& task, int first, int count) {
  forget(task.stack.data() + task.frame().base + first, count);
}

/// The present step of `task`, with all pieces of its work within the budget; true if it is done and the task
/// continues.
bool Interpreter::execute_whole(Task& task, int& budget) {
  do {
    execute(task);
    budget -= work_ / kStepsOfAStatement;
    work_ %= kStepsOfAStatement;
  } while (task.work && task.state == TaskState::running && budget > 0);
  return task.state == TaskState::running && !task.work;
}

/// The hot state of run(): operand locations and the next step. Each function executes that step, or returns
/// false and leaves it to execute().
struct Interpreter::Course {
  Interpreter& program;
  Task& task;
  const Step* steps = program.code_.steps.data();
  const Step* step = steps + task.pc;
  Operands at{};

  POLYARM_QUICK void find_operands() {
    Slot* const frame = task.stack.data() + task.frames.back().base;
    at = {{frame, program.globals_.data(), program.code_.constants.data(), frame}};
  }
  POLYARM_QUICK void enter_frame() { at.of[0] = at.of[3] = task.stack.data() + task.frames.back().base; }
  /// Saves the position for execute(), and restores it.
  POLYARM_QUICK void note() { task.pc = static_cast<std::size_t>(step - steps); }
  POLYARM_QUICK void take_up() {
    find_operands();
    step = steps + task.pc;
  }
  /// The target of this step, or the next step.
  POLYARM_QUICK bool go_on(bool jumps) {
    step = jumps ? steps + step->d : step + 1;
    return true;
  }

  /// Jumps if the comparison is true (`when`), or if it is false.
  template <Operator op, bool when>
  POLYARM_QUICK bool compared() {
    bool truth = false;
    return compare<op>(at, *step, truth) && go_on(truth == when);
  }
  POLYARM_QUICK bool jump_unless() {
    const bool* holds = truth_of(at[step->b]);
    return holds && go_on(!*holds);
  }
  /// The left side of an `and` or `or` may decide.
  POLYARM_QUICK bool settle() {
    const bool* left = truth_of(at[step->b]);
    return left && go_on(*left == (static_cast<Operator>(step->more) == Operator::logical_or));
  }
  POLYARM_QUICK bool for_again() {
    bool more = false;
    return (count_on(at, *step, more) || next_of_list(at, *step, more)) && go_on(more);
  }
  POLYARM_QUICK bool call() {
    if (program.is_too_deep(task, *step)) return false;
    note();
    program.enter_function(task, *step);
    enter_frame();
    step = steps + task.pc;
    return true;
  }
  /// Returns a number from a function that needs no clean-up.
  POLYARM_QUICK bool give() {
    const CallFrame& frame = task.frames.back();
    const Number* result = at[step->b].value.as_number();
    if (!result || task.uses.size() != frame.uses || task.handlers.size() > frame.handlers ||
        task.locks.size() > frame.locks)
      return false;
    const Number number = *result;
    forget(at.of[0], program.code_.functions[static_cast<std::size_t>(step->c)].registers);
    at.of[0]->fill_plain(number);
    step = steps + frame.return_to;
    task.frames.pop_back();
    enter_frame();
    return true;
  }
  POLYARM_QUICK bool release_now() {
    forget(at.of[0] + step->a, step->b);
    return true;
  }
  POLYARM_QUICK bool field() {
    const data::Record* record = at[step->b].value.as_record();
    std::size_t place = 0;
    if (!record || !program.at_field(*record, *step, place)) return false;
    take_part(at, step->a, step->b, record->values[place]);
    return true;
  }
  bool set_field() {
    Value& whole = at[step->a].value;
    const data::Record* record = whole.as_record();
    std::size_t place = 0;
    return record && program.at_field(*record, *step, place) &&
           replace(whole, place, record->values[place], at[step->b]);
  }
};

// A step followed by the next one; a step that sets the next one; and the jumps after a comparison.
#define POLYARM_STEP(op, done) \
  case Op::op:                 \
    if (!(done)) break;        \
    ++on.step;                 \
    continue;
#define POLYARM_TURN(op, done) \
  case Op::op:                 \
    if (!(done)) break;        \
    continue;
#define POLYARM_JUMPS(comparison)                                                 \
  POLYARM_TURN(unless_##comparison, (on.compared<Operator::comparison, false>())) \
  POLYARM_TURN(when_##comparison, (on.compared<Operator::comparison, true>()))

/// Executes steps until `task` waits, has ended or pauses; true if the budget is used up.
bool Interpreter::run(Task& task, int& budget) {
  if (task.work && !execute_whole(task, budget)) return task.state == TaskState::running;
  Course on{*this, task};
  on.find_operands();
  bool watched = looks_for_stops();
  while (true) {
    if (on.step->begins != 0) {
      if (budget <= 0 || watched) {
        on.note();
        if (budget <= 0) return true;
        if (stops_here(task)) return false;
        watched = looks_for_stops();
      }
      budget -= on.step->begins;
    }
    switch (on.step->op) {
      POLYARM_STEP(load, quick_load(on.at, *on.step))
      POLYARM_STEP(require, on.at[on.step->a].set)
      POLYARM_STEP(add, into_register<Operator::add>(on.at, *on.step))
      POLYARM_STEP(subtract, into_register<Operator::subtract>(on.at, *on.step))
      POLYARM_STEP(multiply, into_register<Operator::multiply>(on.at, *on.step))
      POLYARM_STEP(divide, into_register<Operator::divide>(on.at, *on.step))
      POLYARM_STEP(modulo, into_register<Operator::modulo>(on.at, *on.step))
      POLYARM_STEP(calculate, other_operator(on.at, *on.step))
      POLYARM_STEP(add_to, into_variable<Operator::add>(on.at, *on.step))
      POLYARM_STEP(subtract_to, into_variable<Operator::subtract>(on.at, *on.step))
      POLYARM_STEP(multiply_to, into_variable<Operator::multiply>(on.at, *on.step))
      POLYARM_STEP(divide_to, into_variable<Operator::divide>(on.at, *on.step))
      POLYARM_STEP(modulo_to, into_variable<Operator::modulo>(on.at, *on.step))
      POLYARM_STEP(unary, quick_unary(on.at, *on.step))
      POLYARM_STEP(change, quick_change(on.at, *on.step))
      POLYARM_STEP(element, quick_element(on.at, *on.step))
      POLYARM_STEP(field, on.field())
      POLYARM_STEP(set_element, quick_set_element(on.at, *on.step))
      POLYARM_STEP(set_field, on.set_field())
      POLYARM_STEP(replace, quick_replace(on.at, *on.step))
      POLYARM_STEP(append, quick_append(on.at, *on.step))
      POLYARM_JUMPS(equal)
      POLYARM_JUMPS(unequal)
      POLYARM_JUMPS(less)
      POLYARM_JUMPS(less_equal)
      POLYARM_JUMPS(greater)
      POLYARM_JUMPS(greater_equal)
      POLYARM_TURN(jump, on.go_on(true))
      POLYARM_TURN(jump_unless, on.jump_unless())
      POLYARM_TURN(settle, on.settle())
      POLYARM_TURN(for_again, on.for_again())
      POLYARM_TURN(call, on.call())
      POLYARM_TURN(give, on.give())
      POLYARM_STEP(release_now, on.release_now())
      default:
        break;
    }
    on.note();
    if (!execute_whole(task, budget)) return task.state == TaskState::running;
    on.take_up();
    watched = looks_for_stops();
  }
}

#undef POLYARM_STEP
#undef POLYARM_TURN
#undef POLYARM_JUMPS

}  // namespace polyarm::program
