#include "polyarm/program/code.hpp"

namespace polyarm::program {

void for_each_statement(const Block& block, const std::function<void(const Statement&)>& visit) {
  for (const Statement& s : block) {
    visit(s);
    for_each_statement(s.body, visit);
    for_each_statement(s.handler, visit);
    for (const Branch& branch : s.branches) for_each_statement(branch.body, visit);
    for (const Clause& clause : s.clauses) for_each_statement(clause.otherwise, visit);
  }
}

void for_each_expression(const Statement& s, const std::function<void(const Expression&)>& visit) {
  const auto some = [&](const ExpressionPtr& e) {
    if (e) visit(*e);
  };
  some(s.expression);
  some(s.second);
  for (const ExpressionPtr& argument : s.arguments) some(argument);
  for (const PathPart& part : s.path) some(part.index);
  for (const Branch& branch : s.branches) some(branch.condition);
  for (const Parameter& parameter : s.parameters) some(parameter.value);
  for (const Clause& clause : s.clauses) some(clause.value), some(clause.to);
}

const Statement* statement_at(const Program& program, const Location& where) {
  const Statement* out = nullptr;
  for_each_statement(program.statements, [&](const Statement& s) {
    if (!out && s.place.line == where.line && program.at(s.place).file == where.file) out = &s;
  });
  return out;
}

void for_each_call(const Expression& e, const std::function<void(const Expression&)>& visit) {
  if (e.kind == Expression::Kind::call) visit(e);
  for (const ExpressionPtr& part : e.parts) for_each_call(*part, visit);
}

}  // namespace polyarm::program
