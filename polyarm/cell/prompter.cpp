#include "polyarm/cell/prompter.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/program/code.hpp"

namespace polyarm::cell {

namespace {
using data::Number;
using data::Value;
using Kind = program::Statement::Kind;

constexpr std::size_t kMostConstants = 20;  // per name
constexpr std::size_t kMostOffers = 200;    // per wait

void find_literals(const program::Expression& e, std::vector<Value>& out) {
  if (e.kind == program::Expression::Kind::literal) out.push_back(e.value);
  for (const program::ExpressionPtr& part : e.parts) find_literals(*part, out);
}

bool divides(const program::Expression& e) {
  return e.kind == program::Expression::Kind::binary &&
         (e.op == program::Operator::divide || e.op == program::Operator::modulo);
}

void for_each_divisor(const program::Expression& e,
                      const std::function<void(const program::Expression&)>& visit) {
  if (divides(e)) visit(*e.parts[1]);
  for (const program::ExpressionPtr& part : e.parts) for_each_divisor(*part, visit);
}

LinearForm difference(LinearForm a, const LinearForm& b) {
  a.offset -= b.offset;
  for (const auto& [name, slope] : b.slopes) a.slopes[name] -= slope;
  return a;
}

/// Step that moves a value to the other side of a boundary.
double step_of(Dimension dimension) {
  const bool is_small = dimension == Dimension::length || dimension == Dimension::angle;
  return is_small ? 0.001 : 1;
}

void push_new(std::vector<Value>& out, const Value& value) {
  if (std::find(out.begin(), out.end(), value) == out.end()) out.push_back(value);
}
}  // namespace

PossibleValues::PossibleValues(const program::Program& program, const program::Program* others,
                               const Find& find) {
  add_from(program, find);
  if (others) add_from(*others, find);
  add_deciding(program);
}

void PossibleValues::add_deciding(const program::Program& program) {
  const Definitions definitions(program);
  const auto note = [&](const program::Expression& e, const Location& where) {
    for (const std::string& name : definitions.sources(e, where))
      if (std::find(deciding_.begin(), deciding_.end(), name) == deciding_.end()) deciding_.push_back(name);
  };
  program::for_each_statement(program.statements, [&](const program::Statement& s) {
    for (const program::Branch& branch : s.branches)
      if (branch.condition) note(*branch.condition, program.at(branch.place));
  });
  program::for_each_statement(program.statements, [&](const program::Statement& s) {
    if (s.kind == Kind::while_loop && s.expression) note(*s.expression, program.at(s.place));
    for_each_located(program, s, [&](const program::Expression& e, const Location& where) {
      for_each_divisor(e, [&](const program::Expression& divisor) { note(divisor, where); });
    });
  });
}

void PossibleValues::add_from(const program::Program& program, const Find& find) {
  const Definitions definitions(program);
  program::for_each_statement(program.statements, [&](const program::Statement& s) {
    if (s.kind == Kind::set_literal) add(s.name, s.literal);
    if (s.kind == Kind::set && s.expression && s.expression->kind == program::Expression::Kind::literal)
      add(s.name, s.expression->value);
    for_each_located(program, s, [&](const program::Expression& e, const Location& where) {
      add(e, definitions, where, find);
    });
  });
}

/// Adds each comparison separately, and each divisor.
void PossibleValues::add(const program::Expression& e, const Definitions& definitions, const Location& where,
                         const Find& find) {
  const bool compares = e.kind == program::Expression::Kind::binary && program::is_comparison(e.op);
  if (!compares) {
    for (const program::ExpressionPtr& part : e.parts) add(*part, definitions, where, find);
    if (divides(e))
      for (const LinearForm& form : definitions.forms(*e.parts[1], where)) add_boundaries(form, find);
    return;
  }
  bool solved = false;
  for (const LinearForm& left : definitions.forms(*e.parts[0], where))
    for (const LinearForm& right : definitions.forms(*e.parts[1], where))
      solved = add_boundaries(difference(left, right), find) || solved;
  for (const program::ExpressionPtr& part : e.parts)
    for_each_divisor(*part, [&](const program::Expression& divisor) {
      for (const LinearForm& form : definitions.forms(divisor, where)) add_boundaries(form, find);
    });
  if (solved) return;
  std::vector<Value> literals;
  find_literals(e, literals);
  for (const std::string& name : definitions.sources(e, where))
    for (const Value& literal : literals) add(name, literal);
}

/// For each name, adds the value at which the form becomes 0 while the other names keep their values. False
/// if the form has no such name.
bool PossibleValues::add_boundaries(const LinearForm& form, const Find& find) {
  const auto present = [&](const std::string& name) -> const Number* {
    const Value* value = find ? find(name) : nullptr;
    return value ? value->as_number() : nullptr;
  };
  bool out = false;
  for (const auto& [name, slope] : form.slopes) {
    if (slope == 0) continue;
    double rest = form.offset;
    for (const auto& [other, share] : form.slopes)
      if (const Number* number = other == name ? nullptr : present(other)) rest += share * number->value;
    const double at = rest == 0 ? 0 : -rest / slope;
    if (!std::isfinite(at)) continue;
    const Number* number = present(name);
    add(name, Value(Number{at, number ? number->dimension : Dimension::none}));
    out = true;
  }
  return out;
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
    const double step = step_of(number->dimension);
    std::vector<double> middles;
    for (const Value& constant : constants)
      if (const Number* of = constant.as_number()) middles.insert(middles.end(), {of->value, -of->value});
    middles.push_back(number->value);
    for (const double middle : middles)
      for (const double value : {middle, middle + step, middle - step})
        if (value != number->value) push_new(out, Value(Number{value, number->dimension}));
  } else if (const std::string* text = now.as_text()) {
    for (const Value& constant : constants)
      if (constant.as_text() && *constant.as_text() != *text) push_new(out, constant);
    out.emplace_back(*text + "?");  // an answer that matches none of the constants
  }
  return out;
}

std::vector<Value> PossibleValues::other_answers(const std::string& name, const Value& usual) const {
  return usual.as_boolean() || constants_.contains(name) ? instead_of(name, usual) : std::vector<Value>{};
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
