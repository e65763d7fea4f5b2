#include "polyarm/cell/definitions.hpp"

#include <algorithm>

#include "polyarm/program/code.hpp"

namespace polyarm::cell {

namespace {
using Kind = program::Statement::Kind;
using Kinds = program::Expression::Kind;
using program::Expression;
using program::Operator;

constexpr int kDeepest = 20;  // nesting depth of definitions
using Forms = std::vector<LinearForm>;

void push(Forms& out, LinearForm form) {
  if (out.size() < Definitions::kMostForms) out.push_back(std::move(form));
}

LinearForm sum(LinearForm a, const LinearForm& b, double share) {
  a.offset += share * b.offset;
  for (const auto& [name, slope] : b.slopes) a.slopes[name] += share * slope;
  return a;
}

bool is_constant(const LinearForm& form) {
  return std::all_of(form.slopes.begin(), form.slopes.end(),
                     [](const auto& each) { return each.second == 0; });
}

/// Non-linear results are left out.
void push_joined(Operator op, const LinearForm& a, const LinearForm& b, Forms& out) {
  if (op == Operator::add || op == Operator::subtract)
    push(out, sum(a, b, op == Operator::add ? 1 : -1));
  else if (op == Operator::multiply && is_constant(b))
    push(out, sum({}, a, b.offset));
  else if (op == Operator::multiply && is_constant(a))
    push(out, sum({}, b, a.offset));
  else if (op == Operator::divide && is_constant(b) && b.offset != 0)
    push(out, sum({}, a, 1 / b.offset));
}

void push_new(std::vector<std::string>& out, const std::string& name) {
  if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
}

std::string result_of(const std::string& function) {
  return function + "()";
}
}  // namespace

std::string answer_name(const Location& where) {
  return "answer in " + where.text();
}

void for_each_located(const program::Program& program, const program::Statement& s,
                      const std::function<void(const Expression&, const Location&)>& visit) {
  const Location where = program.at(s.place);
  for (const program::Branch& branch : s.branches)
    if (branch.condition) visit(*branch.condition, program.at(branch.place));
  program::for_each_expression(s, [&](const Expression& e) {
    const auto is_of_branch = [&](const program::Branch& branch) { return branch.condition.get() == &e; };
    if (std::none_of(s.branches.begin(), s.branches.end(), is_of_branch)) visit(e, where);
  });
}

Definitions::Definitions(const program::Program& program) : program_(program) {
  program::for_each_statement(program.statements, [this](const program::Statement& s) {
    if (s.kind != Kind::function) return;
    for (const program::Parameter& parameter : s.parameters) parameters_[s.name].push_back(parameter.name);
    program::for_each_statement(s.body, [&](const program::Statement& inner) {
      if (inner.kind == Kind::return_value && inner.expression)
        given_[result_of(s.name)].push_back({inner.expression.get(), program_.at(inner.place)});
    });
  });
  program::for_each_statement(program.statements, [this](const program::Statement& s) { add(s); });
}

void Definitions::add(const program::Statement& s) {
  const Location where = program_.at(s.place);
  if ((s.kind == Kind::let || s.kind == Kind::set) && s.expression && s.path.empty())
    given_[s.name].push_back({s.expression.get(), where});
  if (s.kind == Kind::let || s.kind == Kind::for_loop || s.kind == Kind::try_block)
    own_[s.name] = own_[s.second_name] = true;
  for (const program::Parameter& parameter : s.parameters) {
    own_[parameter.name] = true;
    if (parameter.value) given_[parameter.name].push_back({parameter.value.get(), where});
  }
  for_each_located(program_, s, [this](const Expression& e, const Location& at) {
    program::for_each_call(e, [&](const Expression& call) { add_arguments(call, at); });
  });
}

/// Maps the call's arguments to the function's parameters.
void Definitions::add_arguments(const Expression& e, const Location& where) {
  const auto function = parameters_.find(e.name);
  if (function == parameters_.end()) return;
  for (std::size_t i = 0; i < e.parts.size(); ++i) {
    const bool named = i < e.names.size() && !e.names[i].empty();
    if (named)
      given_[e.names[i]].push_back({e.parts[i].get(), where});
    else if (i < function->second.size())
      given_[function->second[i]].push_back({e.parts[i].get(), where});
  }
}

Forms Definitions::forms(const Expression& e, const Location& where) const {
  return forms(e, where, 0);
}

Forms Definitions::forms(const Expression& e, const Location& where, int depth) const {
  if (depth > kDeepest) return {};
  Forms out;
  switch (e.kind) {
    case Kinds::literal:
      if (const data::Number* number = e.value.as_number()) push(out, {number->value, {}});
      return out;
    case Kinds::name:
      return forms_of_name(e, depth);
    case Kinds::call:
      return forms_of_call(e, where, depth);
    case Kinds::unary:
      if (e.op == Operator::negate)
        for (const LinearForm& form : forms(*e.parts[0], where, depth + 1)) push(out, sum({}, form, -1));
      return out;
    case Kinds::binary: {
      const Forms right = forms(*e.parts[1], where, depth + 1);
      for (const LinearForm& a : forms(*e.parts[0], where, depth + 1))
        for (const LinearForm& b : right) push_joined(e.op, a, b, out);
      return out;
    }
    default:
      return out;
  }
}

Forms Definitions::forms_of_name(const Expression& e, int depth) const {
  Forms out;
  if (!own_.contains(e.name)) push(out, {0, {{e.name, 1}}});
  const auto given = given_.find(e.name);
  if (given == given_.end()) return out;
  for (const Given& each : given->second)
    for (LinearForm& form : forms(*each.value, each.where, depth + 4)) push(out, std::move(form));
  return out;
}

Forms Definitions::forms_of_call(const Expression& e, const Location& where, int depth) const {
  Forms out;
  if (e.name == "ask") {
    push(out, {0, {{answer_name(where), 1}}});
    return out;
  }
  if (const auto given = given_.find(result_of(e.name)); given != given_.end()) {
    for (const Given& each : given->second)
      for (LinearForm& form : forms(*each.value, each.where, depth + 4)) push(out, std::move(form));
    return out;
  }
  const bool rounds = e.name == "round" || e.name == "floor" || e.name == "ceil";
  if (!rounds && e.name != "abs" && e.name != "min" && e.name != "max") return out;
  for (const program::ExpressionPtr& part : e.parts)
    for (const LinearForm& form : forms(*part, where, depth + 1)) {
      push(out, form);
      if (e.name == "abs") push(out, sum({}, form, -1));
    }
  return out;
}

std::vector<std::string> Definitions::sources(const Expression& e, const Location& where) const {
  std::vector<std::string> out;
  std::vector<const Expression*> seen;
  sources(e, where, seen, out);
  return out;
}

void Definitions::sources(const Expression& e, const Location& where, std::vector<const Expression*>& seen,
                          std::vector<std::string>& out) const {
  if (std::find(seen.begin(), seen.end(), &e) != seen.end()) return;
  seen.push_back(&e);
  const auto follow = [&](const std::string& name) {
    if (const auto given = given_.find(name); given != given_.end())
      for (const Given& each : given->second) sources(*each.value, each.where, seen, out);
  };
  if (e.kind == Kinds::name) {
    const std::string first = e.name.substr(0, e.name.find('.'));
    if (!own_.contains(e.name) && !own_.contains(first)) push_new(out, e.name);
    follow(e.name);
    if (first != e.name) follow(first);
  }
  if (e.kind == Kinds::call && e.name == "ask") push_new(out, answer_name(where));
  if (e.kind == Kinds::call) follow(result_of(e.name));
  for (const program::ExpressionPtr& part : e.parts) sources(*part, where, seen, out);
}

}  // namespace polyarm::cell
