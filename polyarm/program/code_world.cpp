#include <algorithm>
#include <utility>

#include "polyarm/program/compiler.hpp"

/// Statements that move, wait, report and meet.
namespace polyarm::program {

// Moves.

void Compiler::clause_value(const Clause& clause) {
  using Clauses = Clause::Kind;
  const bool is_name =
      clause.kind == Clauses::robot || clause.kind == Clauses::tool || clause.kind == Clauses::frame;
  if (!has_value(clause.kind) || clause.kind == Clauses::until) return;
  if (clause.kind == Clauses::at) {
    if (clause.value) push(*clause.value);
    push(*clause.to);
    return;
  }
  const Expression& value = *clause.value;
  if (is_name && value.kind == Expression::Kind::name && resolve(value.name).where == Resolved::Where::host) {
    const Operand from = constant(value.name), to = temporary();
    add(Op::load, value.place, {.a = to, .b = from});
    return;
  }
  push(value);
}

void Compiler::move(const Statement& s) {
  if (s.moves_at_speed()) add(Op::arrive, s.place);  // starts from the present position of the robot
  {
    const Temporaries inner(*this);
    const int first = height();
    for (const ExpressionPtr& point : s.arguments) push(*point);
    for (const Clause& clause : s.clauses) clause_value(clause);
    add(Op::move, s.place, {.a = first});
  }
  for (const Clause& clause : s.clauses)
    if (clause.kind == Clause::Kind::until)
      check_until(Op::until, *clause.value, clause.has_else, clause.otherwise, s);
}

void Compiler::use(const Statement& s) {
  const Temporaries inner(*this);
  const int first = height();
  for (const Clause& clause : s.clauses) clause_value(clause);
  add(Op::use, s.place, {.a = first});
  ++scope_.depths.uses;
}

// Waits.

/// Checks the condition repeatedly; `otherwise` is the block for the step's c.
void Compiler::check_until(Op op, const Expression& condition, bool has_else, const Block& otherwise,
                          const Statement& s) {
  const int start = here();
  const int what = reads(condition);
  int look = 0;
  {
    const Temporaries inner(*this);
    const Operand of = read(condition);
    look = add(op, condition.place, {.a = start, .b = what, .d = of});
  }
  or_else(look, has_else, otherwise, s);
}

void Compiler::or_else(int step, bool has_else, const Block& otherwise, const Statement& s) {
  if (!has_else) return;
  const int skip = add(Op::jump, s.place);
  land(step);
  compile_block(otherwise);
  land(skip);
}

void Compiler::timeout(const Statement& s) {
  if (!s.second) return;
  const Temporaries inner(*this);
  const Operand of = read(*s.second);
  add(Op::deadline, s.second->place, {.b = of});
}

void Compiler::wait(const Statement& s, const Expression& condition) {
  add(Op::arrive, s.place);
  if (s.kind == Statement::Kind::wait) timeout(s);
  check_until(Op::wait, condition, s.has_else, s.body, s);
}

void Compiler::wait_time(const Statement& s) {
  add(Op::arrive, s.place);
  const Temporaries inner(*this);
  const Operand of = read(*s.expression);
  add(Op::wait_time, s.expression->place, {.b = of});
}

namespace {
/// The values that decide whether `e` is true.
void parts_reported(const Expression& e, std::vector<const Expression*>& out) {
  using Kinds = Expression::Kind;
  if (e.kind == Kinds::literal || e.kind == Kinds::record) return;
  const bool splits = e.kind == Kinds::unary || e.kind == Kinds::binary;
  if (!splits) return out.push_back(&e);
  for (const ExpressionPtr& part : e.parts) {
    const bool whole = is_comparison(e.op) && part->kind != Kinds::literal;
    if (whole) {
      out.push_back(part.get());
    } else {
      parts_reported(*part, out);
    }
  }
}
}  // namespace

/// On failure it reads the parts of the condition again, for the message.
void Compiler::expect(const Statement& s) {
  add(Op::arrive, s.place);
  timeout(s);
  const Temporaries inner(*this);
  const Expression& condition = *s.expression;
  const int start = here();
  const int what = reads(condition);
  const Operand of = read(condition);
  const int look = add(Op::expect, condition.place, {.a = start, .b = what, .d = of});
  const int skip = add(Op::jump, s.place);
  land(look);
  std::vector<const Expression*> parts;
  parts_reported(condition, parts);
  std::vector<std::string> spellings;
  const int first = height();
  for (const Expression* part : parts) push(*part), spellings.push_back(spelled(*part));
  add(Op::unmet, condition.place,
      {.b = first, .c = static_cast<int>(parts.size()), .d = names(std::move(spellings))});
  land(skip);
}

// The operator.

/// `wait user`: a name if it exists, else a question.
void Compiler::ask(const Statement& s) {
  if (s.second && resolve(s.second->name).where != Resolved::Where::host) return wait(s, *s.second);
  int question = 0;
  {
    const Temporaries inner(*this);
    const Operand text = s.expression ? read(*s.expression) : constant(std::string{});
    question = add(Op::ask, s.place, {.b = text});
  }
  if (!s.second) return;
  const int skip = add(Op::jump, s.place);
  land(question);
  wait(s, *s.second);
  land(skip);
}

void Compiler::hold(const Statement& s) {
  const Temporaries inner(*this);
  const Operand reason = s.expression ? read(*s.expression) : kNone;
  add(Op::hold, s.place, {.b = reason});
}

void Compiler::log(const Statement& s) {
  const Temporaries inner(*this);
  const int first = height();
  for (const ExpressionPtr& argument : s.arguments) push(*argument);
  add(Op::log, s.place, {.b = first, .c = static_cast<int>(s.arguments.size())});
}

// Tasks.

/// Each statement becomes a small task of its own that starts with the present names.
void Compiler::together(const Statement& s) {
  const int skip = add(Op::jump, s.place);
  std::vector<int> entries;
  const Scope around = scope_;
  const bool in_main = std::exchange(in_main_, false);
  for (const Statement& part : s.body) {
    scope_ = {around.locals, around.variables, {}, {}, around.handlers, false};
    entries.push_back(here());
    statement_ = &part, line_ = part.place, begins_ = true;
    statement(part, false);
    add(Op::finish, part.place);
  }
  scope_ = around;
  in_main_ = in_main;
  statement_ = &s, line_ = s.place;
  land(skip);
  code_.entries.push_back(std::move(entries));
  const bool moves = std::all_of(s.body.begin(), s.body.end(), [](const Statement& part) {
    const auto looks = [](const Clause& clause) { return clause.kind == Clause::Kind::until; };
    return part.kind == Statement::Kind::move && !part.moves_base() &&
           std::none_of(part.clauses.begin(), part.clauses.end(), looks);
  });
  add(Op::together, s.place, {.a = static_cast<int>(code_.entries.size()) - 1, .b = moves ? 1 : 0});
}

void Compiler::meet(const Statement& s) {
  add(Op::arrive, s.place);
  timeout(s);
  or_else(add(Op::meet, s.place, {.a = text(s.name)}), s.has_else, s.body, s);
}

void Compiler::pulse(const Statement& s) {
  add(Op::arrive, s.place);
  const Temporaries inner(*this);
  const Operand time = read(*s.expression);
  add(Op::pulse, s.name_place, {.a = text(s.name), .b = time});
}

void Compiler::lock(const Statement& s) {
  const Depths before = depths();
  add(Op::arrive, s.place);
  timeout(s);
  add(Op::lock, s.place, {.a = text(s.name)});
  ++scope_.depths.locks;
  compile_block(s.body);
  const Depths inside = depths();
  --scope_.depths.locks;
  statement_ = &s;
  add(Op::arrive, line_);
  leave(inside, before, line_);
}

}  // namespace polyarm::program
