/// The steps that programs calculate with most, for plain values. What is not plain, and what is wrong, is
/// left to execute.cpp, which can take every step.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "polyarm/program/operators.hpp"
#include "polyarm/program/task.hpp"

namespace polyarm::program {

using data::Number;

namespace {

/// Where operands are, by what they are.
struct Operands {
  Slot* of[4];
  Slot& operator[](Operand operand) const {
    const auto bits = static_cast<std::uint32_t>(operand);
    return *reinterpret_cast<Slot*>(reinterpret_cast<char*>(of[bits & 3]) + (bits & ~3u));
  }
};

// What a step calls is a part of it: a call costs more than most of them.
#define POLYARM_QUICK [[gnu::always_inline]] inline

/// As std::fmod, and quicker for whole numbers; with the sign of the divisor.
double remainder_of(double a, double b) {
  constexpr double kWhole = 9e15;
  double rest = a;
  if (std::abs(a) >= std::abs(b)) {
    const bool fits = std::abs(a) < kWhole;
    const std::int64_t m = fits ? static_cast<std::int64_t>(a) : 0,
                       n = fits ? static_cast<std::int64_t>(b) : 0;
    const bool whole = n != 0 && static_cast<double>(m) == a && static_cast<double>(n) == b;
    rest = whole ? static_cast<double>(m % n) : std::fmod(a, b);
  }
  return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest + 0.0;  // never -0
}

/// False where units or the result need a closer look.
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
  if constexpr (op == Operator::equal) truth = a->value == b->value;
  if constexpr (op == Operator::unequal) truth = a->value != b->value;
  if constexpr (op == Operator::less) truth = a->value < b->value;
  if constexpr (op == Operator::less_equal) truth = a->value <= b->value;
  if constexpr (op == Operator::greater) truth = a->value > b->value;
  if constexpr (op == Operator::greater_equal) truth = a->value >= b->value;
  return true;
}

POLYARM_QUICK const bool* truth_of(const Slot& slot) {
  return slot.set ? slot.value.as_boolean() : nullptr;
}

/// Operators that have no step of their own.
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

/// Whether `at` is a place in a list of so many values.
POLYARM_QUICK bool is_place(const Number* at, std::size_t size, std::size_t& index) {
  if (!at || at->dimension != Dimension::none) return false;
  if (!(at->value >= 1) || !(at->value <= static_cast<double>(size))) return false;
  index = static_cast<std::size_t>(at->value);
  return static_cast<double>(index--) == at->value;
}

/// Reads a part of what `from` holds, which is let go where nobody reads it again.
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

/// Numbers and booleans need nothing, and are never read before something else is put there.
POLYARM_QUICK void forget(Slot* slots, int count) {
  for (int i = 0; i < count; ++i)
    if (slots[i].value.is_shared()) slots[i].fill_plain(false);
}

/// `part` takes the place of one that is like it.
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

/// Along places in lists alone, which `more` says.
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
  Slot* const parts = at.of[0] + step.b;
  for (std::uint32_t i = 0; i < count; ++i)
    if (!parts[i].set || has_parts(parts[i].value)) return false;
  for (std::uint32_t i = 0; i < count; ++i) list.value.append(std::move(parts[i].value));
  return true;
}

/// A range that names no places, at the end of a pass; whether there is a next number.
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

/// Where `record` has the field that `step` names. It is looked for first where it was found before.
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

/// The result comes to the first register of the function, which is the caller's again.
void Interpreter::give(Task& task, const Step& step) {
  const CallFrame frame = task.frames.back();
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

void Interpreter::let_go(Task& task, int first, int count) {
  forget(task.stack.data() + task.frame().base + first, count);
}

/// The step that `task` stands at, with all pieces of its work as far as the budget goes; true where it is
/// done and the task goes on.
bool Interpreter::execute_whole(Task& task, int& budget) {
  do {
    execute(task);
    budget -= work_ / kStepsOfAStatement;
    work_ %= kStepsOfAStatement;
  } while (task.work && task.state == TaskState::running && budget > 0);
  return task.state == TaskState::running && !task.work;
}

// A step that goes on with the next one, and the two that jump where a comparison does not hold, or does;
// where they are not known here they are left to execute().
#define POLYARM_STEP(op, done) \
  case Op::op:                 \
    if (!(done)) break;        \
    ++step;                    \
    continue;
#define POLYARM_JUMPS(comparison)                                \
  case Op::unless_##comparison:                                  \
    if (!compare<Operator::comparison>(at, *step, truth)) break; \
    step = truth ? step + 1 : steps + step->d;                   \
    continue;                                                    \
  case Op::when_##comparison:                                    \
    if (!compare<Operator::comparison>(at, *step, truth)) break; \
    step = truth ? steps + step->d : step + 1;                   \
    continue;

/// Takes steps until `task` waits, has ended or pauses; true where the budget is used up.
bool Interpreter::run(Task& task, int& budget) {
  if (task.work && !execute_whole(task, budget)) return task.state == TaskState::running;
  const Step* const steps = code_.steps.data();
  const auto operands = [&] {
    Slot* const frame = task.stack.data() + task.frame().base;
    return Operands{{frame, globals_.data(), code_.constants.data(), frame}};
  };
  Operands at = operands();
  const FunctionCode* const functions = code_.functions.data();
  const auto quick_field = [&](const Step& of) __attribute__((always_inline)) {
    const data::Record* record = at[of.b].value.as_record();
    std::size_t place = 0;
    if (!record || !at_field(*record, of, place)) return false;
    take_part(at, of.a, of.b, record->values[place]);
    return true;
  };
  const auto quick_set_field = [&](const Step& of) {
    Value& whole = at[of.a].value;
    const data::Record* record = whole.as_record();
    std::size_t place = 0;
    return record && at_field(*record, of, place) && replace(whole, place, record->values[place], at[of.b]);
  };
  const Step* step = steps + task.pc;
  bool watched = looks_for_stops();
  while (true) {
    if (step->begins != 0) {
      if (budget <= 0 || watched) {
        task.pc = static_cast<std::size_t>(step - steps);
        if (budget <= 0) return true;
        if (stops_here(task)) return false;
        watched = looks_for_stops();
      }
      budget -= step->begins;
    }
    bool truth = false;
    switch (step->op) {
      POLYARM_STEP(load, quick_load(at, *step))
      POLYARM_STEP(require, at[step->a].set)
      POLYARM_STEP(add, into_register<Operator::add>(at, *step))
      POLYARM_STEP(subtract, into_register<Operator::subtract>(at, *step))
      POLYARM_STEP(multiply, into_register<Operator::multiply>(at, *step))
      POLYARM_STEP(divide, into_register<Operator::divide>(at, *step))
      POLYARM_STEP(modulo, into_register<Operator::modulo>(at, *step))
      POLYARM_STEP(calculate, other_operator(at, *step))
      POLYARM_STEP(add_to, into_variable<Operator::add>(at, *step))
      POLYARM_STEP(subtract_to, into_variable<Operator::subtract>(at, *step))
      POLYARM_STEP(multiply_to, into_variable<Operator::multiply>(at, *step))
      POLYARM_STEP(divide_to, into_variable<Operator::divide>(at, *step))
      POLYARM_STEP(modulo_to, into_variable<Operator::modulo>(at, *step))
      POLYARM_STEP(unary, quick_unary(at, *step))
      POLYARM_STEP(change, quick_change(at, *step))
      POLYARM_STEP(element, quick_element(at, *step))
      POLYARM_STEP(field, quick_field(*step))
      POLYARM_STEP(set_element, quick_set_element(at, *step))
      POLYARM_STEP(set_field, quick_set_field(*step))
      POLYARM_STEP(replace, quick_replace(at, *step))
      POLYARM_STEP(append, quick_append(at, *step))
      POLYARM_JUMPS(equal)
      POLYARM_JUMPS(unequal)
      POLYARM_JUMPS(less)
      POLYARM_JUMPS(less_equal)
      POLYARM_JUMPS(greater)
      POLYARM_JUMPS(greater_equal)
      case Op::jump:
        step = steps + step->d;
        continue;
      case Op::jump_unless: {
        const bool* holds = truth_of(at[step->b]);
        if (!holds) break;
        step = *holds ? step + 1 : steps + step->d;
        continue;
      }
      case Op::settle: {
        const bool* left = truth_of(at[step->b]);
        if (!left) break;
        const bool settles = *left == (static_cast<Operator>(step->more) == Operator::logical_or);
        step = settles ? steps + step->d : step + 1;
        continue;
      }
      case Op::for_again:
        if (!count_on(at, *step, truth) && !next_of_list(at, *step, truth)) break;
        step = truth ? steps + step->d : step + 1;
        continue;
      case Op::call:
        if (is_too_deep(task, *step)) break;
        task.pc = static_cast<std::size_t>(step - steps);
        enter_function(task, *step);
        at.of[0] = at.of[3] = task.stack.data() + task.frames.back().base;
        step = steps + task.pc;
        continue;
      case Op::give: {
        const CallFrame& frame = task.frames.back();
        const Number* result = at[step->b].value.as_number();
        if (!result || task.uses.size() != frame.uses || task.handlers.size() > frame.handlers ||
            task.locks.size() > frame.locks)
          break;
        const Number number = *result;
        forget(at.of[0], functions[step->c].registers);
        at.of[0]->fill_plain(number);
        step = steps + frame.return_to;
        task.frames.pop_back();
        at.of[0] = at.of[3] = task.stack.data() + task.frames.back().base;
        continue;
      }
      case Op::let_go:
        forget(at.of[0] + step->a, step->b);
        ++step;
        continue;
      default:
        break;
    }
    task.pc = static_cast<std::size_t>(step - steps);
    if (!execute_whole(task, budget)) return task.state == TaskState::running;
    at = operands();
    step = steps + task.pc;
    watched = looks_for_stops();
  }
}

#undef POLYARM_STEP
#undef POLYARM_JUMPS

}  // namespace polyarm::program
