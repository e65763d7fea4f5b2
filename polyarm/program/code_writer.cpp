#include "polyarm/program/code_writer.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"
#include "polyarm/program/functions.hpp"

namespace polyarm::program {

int CodeWriter::here() const {
  return static_cast<int>(code_.steps.size());
}

int CodeWriter::add(Op op, Place place, int a, int b) {
  Step step{op, a, b, -1, place, line_.line ? line_ : place, statement_, begins_};
  begins_ = false;
  code_.steps.push_back(step);
  return here() - 1;
}

void CodeWriter::land(int step) {
  code_.steps[static_cast<std::size_t>(step)].c = here();
}

void CodeWriter::jump_to(int target, Place place) {
  code_.steps[static_cast<std::size_t>(add(Op::jump, place))].c = target;
}

int CodeWriter::constant(const Value& value) {
  code_.constants.push_back(value);
  return static_cast<int>(code_.constants.size()) - 1;
}

int CodeWriter::text(const std::string& text) {
  const auto [at, made] = text_at_.try_emplace(text, static_cast<int>(code_.texts.size()));
  if (made) code_.texts.push_back(text);
  return at->second;
}

int CodeWriter::names(std::vector<std::string> names) {
  code_.name_lists.push_back(std::move(names));
  return static_cast<int>(code_.name_lists.size()) - 1;
}

void CodeWriter::refuse(Place place, const OperationError& error) {
  code_.problems.push_back({error.code, program_.at(place), error.what, error.advice});
  add(Op::refuse, place, static_cast<int>(code_.problems.size()) - 1);
}

Depths CodeWriter::depths() const {
  Depths out = scope_.depths;
  out.locals = static_cast<int>(scope_.locals.size());
  return out;
}

int CodeWriter::declare(const std::string& name) {
  scope_.locals.push_back(name);
  scope_.variables.push_back(static_cast<int>(code_.variables.size()));
  code_.variables.push_back({name, static_cast<int>(scope_.locals.size()) - 1, here(), -1});
  return static_cast<int>(scope_.locals.size()) - 1;
}

void CodeWriter::forget(int keep) {
  const auto first = static_cast<std::size_t>(keep);
  for (std::size_t i = first; i < scope_.variables.size(); ++i)
    code_.variables[static_cast<std::size_t>(scope_.variables[i])].end = here();
  scope_.locals.resize(first);
  scope_.variables.resize(first);
}

bool CodeWriter::find_variable(const std::string& name, Resolved& out) const {
  const auto& locals = scope_.locals;
  const auto at = std::find(locals.rbegin(), locals.rend(), name);
  if (!name.empty() && at != locals.rend()) {
    out.where = Resolved::Where::local;
    out.slot = static_cast<int>(locals.rend() - at) - 1;
    return true;
  }
  const auto global = globals_.find(name);
  if (global == globals_.end()) return false;
  out.where = Resolved::Where::global;
  out.slot = global->second;
  return true;
}

CodeWriter::Resolved CodeWriter::resolve(const std::string& name) const {
  Resolved out;
  if (find_variable(name, out)) return out;
  const auto dot = name.find('.');
  if (dot != std::string::npos && find_variable(name.substr(0, dot), out))
    out.fields = split_fields(std::string_view(name).substr(dot + 1), '.');
  return out;
}

void CodeWriter::push_variable(const Resolved& resolved, const std::string& name, Place place) {
  using Where = Resolved::Where;
  if (resolved.where == Where::host) {
    add(Op::host, place, text(name));
  } else {
    add(resolved.where == Where::local ? Op::local : Op::global, place, resolved.slot);
  }
  for (const std::string& field : resolved.fields) add(Op::field, place, text(field));
}

void CodeWriter::expression(const Expression& e) {
  using Kinds = Expression::Kind;
  switch (e.kind) {
    case Kinds::literal:
      add(Op::constant, e.place, constant(e.value));
      return;
    case Kinds::name:
      return push_variable(resolve(e.name), e.name, e.place);
    case Kinds::binary:
      return binary(e);
    case Kinds::call:
      return call(e);
    case Kinds::index:
      return index(e);
    default:
      break;
  }
  for (const ExpressionPtr& part : e.parts) expression(*part);
  const int count = static_cast<int>(e.parts.size());
  if (e.kind == Kinds::unary) add(Op::unary, e.place, static_cast<int>(e.op));
  if (e.kind == Kinds::list) add(Op::list, e.place, count);
  if (e.kind == Kinds::joined) add(Op::joined, e.place, count);
  if (e.kind == Kinds::field) add(Op::field, e.place, text(e.name));
  if (e.kind == Kinds::record) add(Op::record, e.place, count, names(e.names));
}

void CodeWriter::binary(const Expression& e) {
  const bool may_settle = e.op == Operator::logical_and || e.op == Operator::logical_or;
  expression(*e.parts[0]);
  const int settle = may_settle ? add(Op::settle, e.place, static_cast<int>(e.op)) : -1;
  expression(*e.parts[1]);
  add(Op::binary, e.place, static_cast<int>(e.op));
  if (may_settle) land(settle);
}

void CodeWriter::index(const Expression& e) {
  const Expression& list = *e.parts[0];
  const Resolved resolved = list.kind == Expression::Kind::name ? resolve(list.name) : Resolved{};
  if (resolved.where == Resolved::Where::host || !resolved.fields.empty()) {
    expression(list);
    expression(*e.parts[1]);
    add(Op::element, e.place);
    return;
  }
  expression(*e.parts[1]);
  add(resolved.where == Resolved::Where::local ? Op::local_element : Op::global_element, e.place,
      resolved.slot);
}

void CodeWriter::call(const Expression& e) {
  try {
    const auto own = function_at_.find(e.name);
    if (own != function_at_.end()) return call_function(e, own->second);
    const Function* function = find_function(e.name);
    if (!function) throw OperationError{"unknown-function", "there is no function '" + e.name + "'", {}};
    call_builtin(e, *function);
  } catch (const OperationError& error) {
    refuse(e.place, error);
  }
}

void CodeWriter::call_function(const Expression& e, std::size_t which) {
  const Bound bound = bind_arguments(signature_of(*functions_[which]), e.names);
  for (const int argument : bound.argument_of) {
    if (argument < 0) {
      add(Op::absent, e.place);
    } else {
      expression(*e.parts[static_cast<std::size_t>(argument)]);
    }
  }
  add(Op::call, e.place, static_cast<int>(which), static_cast<int>(bound.argument_of.size()));
}

void CodeWriter::call_builtin(const Expression& e, const Function& function) {
  const Bound bound = bind_arguments(signature_of(function), e.names);
  if (function.name == "here") {
    add(Op::here, e.place);
    return;
  }
  if (function.name == "ask") return call_ask(e, bound);
  for (std::size_t i = 0; i < bound.argument_of.size(); ++i) {
    const int argument = bound.argument_of[i];
    if (argument >= 0) {
      expression(*e.parts[static_cast<std::size_t>(argument)]);
      continue;
    }
    const FunctionParameter& parameter = function.parameters[i];
    const Dimension dimension = parameter.wanted == Wanted::length  ? Dimension::length
                                : parameter.wanted == Wanted::angle ? Dimension::angle
                                                                    : Dimension::none;
    add(Op::constant, e.place, constant(data::Number{*parameter.otherwise, dimension}));
  }
  for (const int argument : bound.further) expression(*e.parts[static_cast<std::size_t>(argument)]);
  const int step = add(function.call ? Op::builtin : Op::of_host, e.place,
                       static_cast<int>(&function - functions().data()),
                       static_cast<int>(bound.argument_of.size() + bound.further.size()));
  code_.steps[static_cast<std::size_t>(step)].c = names(e.names);
}

/// The question comes again until the answer is like what is wanted.
void CodeWriter::call_ask(const Expression& e, const Bound& bound) {
  const int begin = here();
  if (bound.argument_of[1] < 0) {
    add(Op::constant, e.place, constant(std::string{}));
  } else {
    expression(*e.parts[static_cast<std::size_t>(bound.argument_of[1])]);
  }
  expression(*e.parts[static_cast<std::size_t>(bound.argument_of[0])]);
  add(Op::ask_value, e.place);
  const int step = add(Op::answered, e.place);
  code_.steps[static_cast<std::size_t>(step)].c = begin;
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
