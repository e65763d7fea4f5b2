#include "polyarm/cell/prompter.hpp"

#include <algorithm>

#include "polyarm/program/code.hpp"

namespace polyarm::cell {

namespace {
using data::Number;
using data::Value;
using Kind = program::Statement::Kind;

constexpr std::size_t kMostConstants = 20;  // of a name
constexpr std::size_t kMostOffers = 200;    // at one wait

void find_literals(const program::Expression& e, std::vector<Value>& out) {
  if (e.kind == program::Expression::Kind::literal) out.push_back(e.value);
  for (const program::ExpressionPtr& part : e.parts) find_literals(*part, out);
}

void push_new(std::vector<Value>& out, const Value& value) {
  if (std::find(out.begin(), out.end(), value) == out.end()) out.push_back(value);
}
}  // namespace

PossibleValues::PossibleValues(const program::Program& program, const program::Program* others) {
  add_from(program);
  if (others) add_from(*others);
  program::for_each_statement(program.statements, [this](const program::Statement& s) {
    for (const program::Branch& branch : s.branches)
      if (branch.condition)
        for (const std::string& name : program::names_read(*branch.condition))
          if (std::find(deciding_.begin(), deciding_.end(), name) == deciding_.end())
            deciding_.push_back(name);
  });
}

void PossibleValues::add_from(const program::Program& program) {
  program::for_each_statement(program.statements, [this](const program::Statement& s) {
    if (s.kind == Kind::set_literal) add(s.name, s.literal);
    if (s.kind == Kind::set && s.expression && s.expression->kind == program::Expression::Kind::literal)
      add(s.name, s.expression->value);
    if (s.expression && (s.kind == Kind::wait || s.kind == Kind::while_loop)) add(*s.expression);
    for (const program::Branch& branch : s.branches)
      if (branch.condition) add(*branch.condition);
    for (const program::Clause& clause : s.clauses)
      if (clause.kind == program::Clause::Kind::until && clause.value) add(*clause.value);
  });
}

/// Each comparison by itself: its constants are those of its names.
void PossibleValues::add(const program::Expression& condition) {
  const bool joins =
      condition.kind == program::Expression::Kind::binary && !program::is_comparison(condition.op);
  if (joins || condition.kind == program::Expression::Kind::unary) {
    for (const program::ExpressionPtr& part : condition.parts) add(*part);
    return;
  }
  std::vector<Value> literals;
  find_literals(condition, literals);
  for (const std::string& name : program::names_read(condition))
    for (const Value& literal : literals) add(name, literal);
}

void PossibleValues::add(const std::string& name, const Value& value) {
  std::vector<Value>& known = constants_[name];
  if (known.size() < kMostConstants) push_new(known, value);
}

std::vector<Value> PossibleValues::instead_of(const std::string& name, const Value& now) const {
  if (const bool* boolean = now.as_boolean()) return {Value(!*boolean)};
  const auto at = constants_.find(name);
  const std::vector<Value> constants = at == constants_.end() ? std::vector<Value>{} : at->second;
  std::vector<Value> out;
  if (const Number* number = now.as_number()) {
    std::vector<double> middles;
    for (const Value& constant : constants)
      if (const Number* of = constant.as_number()) middles.insert(middles.end(), {of->value, -of->value});
    middles.push_back(number->value);
    for (const double middle : middles)
      for (const double value : {middle, middle + 1, middle - 1})
        if (value != number->value) push_new(out, Value(Number{value, number->dimension}));
  } else if (const std::string* text = now.as_text()) {
    for (const Value& constant : constants)
      if (constant.as_text() && *constant.as_text() != *text) push_new(out, constant);
    out.emplace_back(*text + "?");  // none of those
  }
  return out;
}

std::vector<std::vector<NamedValue>> Prompter::offers_for(const std::vector<NamedValue>& names) const {
  std::vector<std::vector<NamedValue>> out;
  const auto with = [&](std::size_t i, const Value& value) {
    std::vector<NamedValue> all = names;
    all[i].second = value;
    return all;
  };
  std::vector<std::vector<Value>> others;
  for (const auto& [name, now] : names) others.push_back(values_.instead_of(name, now));
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const Value& value : others[i]) out.push_back(with(i, value));
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t k = i + 1; k < names.size(); ++k)
      for (const Value& first : others[i])
        for (const Value& second : others[k]) {
          if (out.size() >= kMostOffers) return out;
          out.push_back(with(i, first));
          out.back()[k].second = second;
        }
  return out;
}

const std::vector<NamedValue>* Prompter::next(const Location& where, const std::vector<NamedValue>& names) {
  const auto [at, made] = waits_.try_emplace(where.text());
  Wait& wait = at->second;
  if (made) wait.offers = offers_for(names);
  return wait.tried < wait.offers.size() ? &wait.offers[wait.tried++] : nullptr;
}

}  // namespace polyarm::cell
