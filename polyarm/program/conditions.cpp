#include "polyarm/program/code_writer.hpp"

/// A condition becomes jumps if it is known to be boolean.
namespace polyarm::program {

using Kinds = Expression::Kind;

namespace {
bool is_junction(const Expression& e) {
  return e.kind == Kinds::binary && (e.op == Operator::logical_and || e.op == Operator::logical_or);
}

bool is_comparison(const Expression& e) {
  return e.kind == Kinds::binary && program::is_comparison(e.op);
}

bool is_negation(const Expression& e) {
  return e.kind == Kinds::unary && e.op == Operator::logical_not;
}

/// For any other expression the type is known only at run time.
bool is_surely_boolean(const Expression& e) {
  if (is_junction(e)) return is_surely_boolean(*e.parts[0]) && is_surely_boolean(*e.parts[1]);
  return is_comparison(e) || (is_negation(e) && is_surely_boolean(*e.parts[0]));
}
}  // namespace

void CodeWriter::jump_unless(const Expression& condition, std::vector<int>& jumps) {
  const Temporaries inner(*this);
  if (!is_surely_boolean(condition)) {
    const Operand of = read(condition);
    jumps.push_back(add(Op::jump_unless, condition.place, {.b = of}));
    return;
  }
  if (is_comparison(condition)) return compare(condition, Op::unless_equal, jumps);
  if (is_negation(condition)) return jump_when(*condition.parts[0], jumps);
  if (condition.op == Operator::logical_and) {
    jump_unless(*condition.parts[0], jumps);
    return jump_unless(*condition.parts[1], jumps);
  }
  std::vector<int> holds;
  jump_when(*condition.parts[0], holds);
  jump_unless(*condition.parts[1], jumps);
  land(holds);
}

void CodeWriter::jump_when(const Expression& condition, std::vector<int>& jumps) {
  const Temporaries inner(*this);
  if (is_comparison(condition)) return compare(condition, Op::when_equal, jumps);
  if (is_negation(condition)) return jump_unless(*condition.parts[0], jumps);
  if (condition.op == Operator::logical_or) {
    jump_when(*condition.parts[0], jumps);
    return jump_when(*condition.parts[1], jumps);
  }
  std::vector<int> fails;
  jump_unless(*condition.parts[0], fails);
  jump_when(*condition.parts[1], jumps);
  land(fails);
}

/// `first` is the step for ==; those of the other comparisons follow it.
void CodeWriter::compare(const Expression& e, Op first, std::vector<int>& jumps) {
  const Operand left = read_before(*e.parts[0], *e.parts[1]), right = read(*e.parts[1]);
  const int which = static_cast<int>(e.op) - static_cast<int>(Operator::equal);
  const Op op = static_cast<Op>(static_cast<int>(first) + which);
  jumps.push_back(add_binary(op, e.op, e.place, {.b = left, .c = right}));
}

int CodeWriter::reads(const Expression& condition) {
  ConditionReads out;
  for (const std::string& name : names_read(condition)) {
    const Resolved resolved = resolve(name);
    if (resolved.where == Resolved::Where::host) out.names.push_back(name);
    if (resolved.where == Resolved::Where::global) out.others = true;
  }
  for_each_call(condition, [&](const Expression&) { out.others = true; });
  code_.reads.push_back(std::move(out));
  return static_cast<int>(code_.reads.size()) - 1;
}

}  // namespace polyarm::program
