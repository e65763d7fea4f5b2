#include <algorithm>
#include <optional>

#include "polyarm/language/functions.hpp"
#include "polyarm/program/code_writer.hpp"

/// Expressions: results are computed directly into their destination; variables and constants are read in
/// place.
namespace polyarm::program {

using Kinds = Expression::Kind;

namespace {
bool is_logic(Operator op) {
  return op == Operator::logical_and || op == Operator::logical_or;
}

/// The steps of the operators that have their own; `change`: into a variable.
std::optional<Op> own_step(Operator op, bool change) {
  switch (op) {
    case Operator::add:
      return change ? Op::add_to : Op::add;
    case Operator::subtract:
      return change ? Op::subtract_to : Op::subtract;
    case Operator::multiply:
      return change ? Op::multiply_to : Op::multiply;
    case Operator::divide:
      return change ? Op::divide_to : Op::divide;
    case Operator::modulo:
      return change ? Op::modulo_to : Op::modulo;
    default:
      return std::nullopt;
  }
}

/// The constant value; empty if the computation fails, which is then reported at run time.
template <typename... Values>
std::optional<Value> folded(Operator op, const Values&... values) {
  try {
    return apply(op, values...);
  } catch (const OperationError&) {
    return std::nullopt;
  }
}

/// True if its value is computed from those of its parts.
bool calculates(const Expression& e) {
  return e.kind == Kinds::unary || (e.kind == Kinds::binary && !is_logic(e.op));
}
}  // namespace

/// Calls, and requests to the host, may let others run meanwhile.
bool CodeWriter::at_once(const Expression& e) const {
  if (e.kind == Kinds::each) return false;
  if (e.kind == Kinds::name && resolve(e.name).where == Resolved::Where::host) return false;
  if (e.kind == Kinds::call) {
    const Function* builtin = function_at_.contains(e.name) ? nullptr : find_function(e.name);
    if (!builtin || !builtin->call) return false;
  }
  return std::all_of(e.parts.begin(), e.parts.end(),
                     [&](const ExpressionPtr& part) { return at_once(*part); });
}

Operand CodeWriter::read(const Expression& e) {
  if (e.kind == Kinds::literal) return constant(e.value);
  if (e.kind == Kinds::name) {
    const Resolved resolved = resolve(e.name);
    if (resolved.is_variable()) return variable(resolved, e.place);
  }
  if (!calculates(e)) return push(e);
  const Operand to = next(), out = calculate(e, to, false);
  return out == to ? temporary() : out;
}

/// Reads now what others may change while `behind` is evaluated.
Operand CodeWriter::read_before(const Expression& e, const Expression& behind) {
  const Operand out = read(e);
  if (where(out) != Where::global || at_once(behind)) return out;
  const Operand to = temporary();
  add(Op::load, e.place, {.a = to, .b = out});
  return to;
}

Operand CodeWriter::push(const Expression& e) {
  into(e, next());
  return temporary();
}

void CodeWriter::into(const Expression& e, Operand to) {
  switch (e.kind) {
    case Kinds::literal:
      add(Op::load, e.place, {.a = to, .b = constant(e.value)});
      return;
    case Kinds::name:
      return name(e, to);
    case Kinds::unary:
    case Kinds::binary: {
      if (!calculates(e)) return logic(e, to);
      const Operand out = calculate(e, to, false);
      if (out != to) add(Op::load, e.place, {.a = to, .b = out});
      return;
    }
    case Kinds::call:
      return call(e, to);
    case Kinds::index:
      return element(e, to);
    case Kinds::field: {
      const Temporaries inner(*this);
      return fields(read(*e.parts[0]), {e.name}, to, e.place);
    }
    case Kinds::each:
      return each(e, to);
    default:
      return several(e, to);
  }
}

void CodeWriter::name(const Expression& e, Operand to) {
  const Resolved resolved = resolve(e.name);
  if (resolved.where == Resolved::Where::host) {
    add(Op::host, e.place, {.a = to, .b = text(e.name)});
    return;
  }
  const Operand root = variable(resolved, e.place);
  if (!resolved.fields.empty()) return fields(root, resolved.fields, to, e.place);
  add(Op::load, e.place, {.a = to, .b = root});
}

void CodeWriter::fields(Operand root, const std::vector<std::string>& fields, Operand to, Place place) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Temporaries inner(*this);
    const Operand part = i + 1 == fields.size() ? to : temporary();
    add(Op::field, place, {.more = number_of_field(), .a = part, .b = root, .c = text(fields[i])});
    root = part;
  }
}

/// Into `to`, or as a constant if everything is known.
Operand CodeWriter::calculate(const Expression& e, Operand to, bool changes) {
  const auto known = [&](Operand of) -> const Value* {
    return where(of) == Where::constant ? &code_.constants[static_cast<std::size_t>(index(of))].value
                                        : nullptr;
  };
  const Temporaries inner(*this);
  std::optional<Value> value;
  if (e.kind == Kinds::unary) {
    const Operand of = read(*e.parts[0]);
    if (known(of)) value = folded(e.op, *known(of));
    if (!value) add_binary(Op::unary, e.op, e.place, {.a = to, .b = of});
  } else {
    const Operand left = read_before(*e.parts[0], *e.parts[1]), right = read(*e.parts[1]);
    if (known(left) && known(right)) value = folded(e.op, *known(left), *known(right));
    const Op op = own_step(e.op, changes).value_or(Op::calculate);
    if (!value) add_binary(op, e.op, e.place, {.a = to, .b = left, .c = right});
  }
  return value ? constant(*value) : to;
}

/// If the left side decides, the right side is not evaluated.
void CodeWriter::logic(const Expression& e, Operand to) {
  const Temporaries inner(*this);
  const Operand both = push(*e.parts[0]);
  const int settle = add_binary(Op::settle, e.op, e.place, {.b = both});
  const Operand right = read(*e.parts[1]);
  add_binary(Op::calculate, e.op, e.place, {.a = both, .b = both, .c = right});
  land(settle);
  move_to(to, both, e.place);
}

void CodeWriter::element(const Expression& e, Operand to) {
  const Temporaries inner(*this);
  const Expression& list = *e.parts[0];
  const Resolved resolved = list.kind == Kinds::name ? resolve(list.name) : Resolved{};
  Operand of = kNone;
  if (resolved.is_variable()) {  // checked when its place is known
    of = operand(resolved.where == Resolved::Where::local ? Where::local : Where::global, resolved.slot);
  } else {
    of = push(list);
  }
  const Operand place = read(*e.parts[1]);
  add(Op::element, e.place, {.a = to, .b = of, .c = place});
}

/// Parts in consecutive registers.
void CodeWriter::several(const Expression& e, Operand to) {
  const Temporaries inner(*this);
  const int first = height();
  for (const ExpressionPtr& part : e.parts) push(*part);
  Step operands{.a = to, .b = first, .c = static_cast<int>(e.parts.size())};
  if (e.kind == Kinds::record) operands.d = names(e.names);
  const Op op = e.kind == Kinds::list ? Op::list : e.kind == Kinds::record ? Op::record : Op::joined;
  add(op, e.place, operands);
}

/// [VALUE for NAME in …]: a loop that appends to a list. Registers in use become nameless variables, so that
/// the names of the loop lie above them.
void CodeWriter::each(const Expression& e, Operand to) {
  const Temporaries inner(*this);
  const int outside = static_cast<int>(scope_.locals.size());
  const Operand made = temporary();
  add(Op::list, e.place, {.a = made, .b = height(), .c = 0});
  const int kept = temporaries_;
  for (temporaries_ = 0; static_cast<int>(scope_.locals.size()) < outside + kept;) declare("");
  const bool counted = !e.names.empty(), range = e.parts.size() > 2;
  const int slot = height();
  for (const std::string& name : {counted ? e.names.front() : std::string{}, e.name})
    if (!name.empty() && e.place.file == 0) add(Op::check_new, e.place, {.a = text(name)});
  {
    const Temporaries ends(*this);
    push(*e.parts[1]);
    if (range) push(*e.parts[2]);
    need(slot + 4);
    add(Op::for_begin, e.parts[1]->place, {.a = slot, .b = counted ? 1 : 0, .c = range ? 1 : 0});
  }
  declare("");
  declare("");
  if (counted) declare(e.names.front());
  declare(e.name);
  const int next = add(Op::for_next, e.place, {.a = slot, .b = counted ? 1 : 0});
  add_step(Op::pace, e.place, {.begins = 1});  // each value counts
  {
    const Temporaries value(*this);
    const int first = height();
    push(*e.parts[0]);
    code_.places.insert(code_.places.end(), {e.place, e.parts[0]->place});
    add(Op::append, e.place,
        {.a = operand(Where::local, index(made)), .b = first, .c = 1, .d = static_cast<int>(code_.places.size()) - 2});
  }
  add(Op::for_again, e.place, {.a = slot, .b = counted ? 1 : 0, .d = next + 1});
  land(next);
  add(Op::release_now, e.place, {.a = slot, .b = height() - slot});
  forget(outside);
  temporaries_ = kept;
  move_to(to, made, e.place);
}

void CodeWriter::change(const Expression& e, Operand variable, Place place) {
  const Temporaries inner(*this);
  const bool adds = e.kind == Kinds::binary && e.op == Operator::add && e.parts[0]->kind == Kinds::name &&
                    e.parts[1]->kind == Kinds::list && at_once(*e.parts[1]);
  if (adds) {
    const Resolved left = resolve(e.parts[0]->name);
    const bool same = left.is_variable() && left.slot == index(variable) &&
                      (left.where == Resolved::Where::local) == (where(variable) == Where::local);
    if (same) return append(e, variable, place);
  }
  const bool at_once_into = e.kind == Kinds::binary && own_step(e.op, true);
  const Operand from = at_once_into ? calculate(e, variable, true) : read(e);
  if (from != variable || !at_once_into) add(Op::change, place, {.a = variable, .b = from});
}

/// set l = l + […]
void CodeWriter::append(const Expression& e, Operand variable, Place place) {
  const Expression& list = *e.parts[1];
  if (where(variable) == Where::global) read(*e.parts[0]);
  const int first = height();
  for (const ExpressionPtr& part : list.parts) push(*part);
  code_.places.insert(code_.places.end(), {e.place, list.place});
  add(Op::append, place,
      {.a = variable,
       .b = first,
       .c = static_cast<int>(list.parts.size()),
       .d = static_cast<int>(code_.places.size()) - 2});
}

}  // namespace polyarm::program
