#include "polyarm/program/compiler.hpp"

/// Statements that create and change names.
namespace polyarm::program {

void Compiler::let(const Statement& s, bool top) {
  const Temporaries inner(*this);
  // In an included file only functions are not `top`, and their names are their own.
  if (top || s.name_place.file == 0) add(Op::check_new, s.name_place, {.a = text(s.name)});
  if (top) {
    const int slot = globals_.at(s.name);
    const Operand from = read(*s.expression);
    add(Op::let_global, s.name_place, {.a = operand(Where::global, slot), .b = from});
    sure_globals_[static_cast<std::size_t>(slot)] = true;
    return;
  }
  into(*s.expression, next());
  declare(s.name);
}

void Compiler::set_literal(const Statement& s) {
  Resolved resolved;
  if (!find_variable(s.name, resolved)) {
    add(Op::arrive, s.place);
    add(Op::set_literal, s.place, {.a = kNone});
    return;
  }
  const bool local = resolved.where == Resolved::Where::local;
  add(Op::set_literal, s.place, {.a = operand(local ? Where::local : Where::global, resolved.slot)});
}

void Compiler::set(const Statement& s) {
  const Temporaries inner(*this);
  const Resolved resolved = resolve(s.name);
  if (!resolved.fields.empty() || !s.path.empty()) return set_part(s, resolved);
  if (resolved.where == Resolved::Where::host) {
    const Operand from = read(*s.expression);
    add(Op::set_host, s.name_place, {.a = text(s.name), .b = from});
    return;
  }
  const bool local = resolved.where == Resolved::Where::local;
  change(*s.expression, operand(local ? Where::local : Where::global, resolved.slot), s.name_place);
}

/// Reads the whole first, then the indices, then the value.
void Compiler::set_part(const Statement& s, const Resolved& resolved) {
  if (resolved.where != Resolved::Where::host && set_part_in_place(s, resolved)) return;
  const Operand root = temporary();
  if (resolved.where == Resolved::Where::host) {
    add(Op::host, s.name_place, {.a = root, .b = text(s.name)});
  } else {
    const Operand from = variable(resolved, s.name_place);
    add(Op::load, s.name_place, {.a = root, .b = from});
  }
  const int first = height();
  for (const PathPart& part : s.path)
    if (part.index) push(*part.index);
  const int places = height() - first;
  push(*s.expression);
  add(Op::replace, s.name_place, {.a = root, .b = first, .c = names(resolved.fields), .d = places});
  if (resolved.where == Resolved::Where::host) {
    add(Op::set_host, s.name_place, {.a = text(s.name), .b = root});
    return;
  }
  const Where where = resolved.where == Resolved::Where::local ? Where::local : Where::global;
  add(Op::change, s.name_place, {.a = operand(where, resolved.slot), .b = root});
}

/// Only if nothing can change the variable meanwhile.
bool Compiler::set_part_in_place(const Statement& s, const Resolved& resolved) {
  const bool local = resolved.where == Resolved::Where::local;
  for (const PathPart& part : s.path)
    if (!local && part.index && !at_once(*part.index)) return false;
  if (!local && !at_once(*s.expression)) return false;
  const Operand root = variable(resolved, s.name_place);
  if (resolved.fields.empty() && s.path.size() == 1 && s.path.front().index) {
    const Operand place = read(*s.path.front().index), from = read(*s.expression);
    add(Op::set_element, s.name_place, {.a = root, .b = place, .c = from});
    return true;
  }
  if (resolved.fields.size() == 1 && s.path.empty()) {
    const Operand from = read(*s.expression);
    add(Op::set_field, s.name_place,
        {.more = number_of_field(), .a = root, .b = from, .c = text(resolved.fields.front())});
    return true;
  }
  const int first = height();
  for (const PathPart& part : s.path)
    if (part.index) push(*part.index);
  const int places = height() - first;
  push(*s.expression);
  const bool places_alone = resolved.fields.empty() && places == static_cast<int>(s.path.size());
  add(Op::replace, s.name_place,
      {.more = static_cast<std::uint16_t>(places_alone ? 1 : 0),
       .a = root,
       .b = first,
       .c = names(resolved.fields),
       .d = places});
  return true;
}

}  // namespace polyarm::program
