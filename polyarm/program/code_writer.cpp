#include "polyarm/program/code_writer.hpp"

#include <algorithm>
#include <bit>

#include "polyarm/base/text.hpp"

namespace polyarm::program {

int CodeWriter::here() const {
  return static_cast<int>(code_.steps.size());
}

int CodeWriter::add(Op op, Place place, Step operands) {
  constexpr int kMostSteps = 2000;
  if (begins_) since_last_check_ = 0;
  if (++since_last_check_ > kMostSteps) {
    since_last_check_ = 0;
    add_step(Op::pace, place, {.begins = 1});
  }
  operands.begins = begins_ ? 1 : 0;
  begins_ = false;
  add_step(op, place, operands);
  return here() - 1;
}

void CodeWriter::add_step(Op op, Place place, Step operands) {
  operands.op = op;
  code_.steps.push_back(operands);
  code_.sources.push_back({place, line_.line ? line_ : place, statement_});
}

int CodeWriter::add_binary(Op op, Operator operation, Place place, Step operands) {
  operands.more = static_cast<std::uint16_t>(operation);
  return add(op, place, operands);
}

void CodeWriter::land(int at) {
  const Op op = step(at).op;
  const bool other =
      op == Op::until || op == Op::wait || op == Op::expect || op == Op::meet || op == Op::lock;
  (other ? step(at).c : step(at).d) = here();
}

void CodeWriter::land(const std::vector<int>& steps) {
  for (const int at : steps) land(at);
}

void CodeWriter::jump_to(int target, Place place) {
  add(Op::jump, place, {.d = target});
}

Operand CodeWriter::constant(const Value& value) {
  int at = static_cast<int>(code_.constants.size());
  if (const data::Number* number = value.as_number()) {
    const NumberKey key{std::bit_cast<std::uint64_t>(number->value), static_cast<int>(number->dimension)};
    at = number_at_.try_emplace(key, at).first->second;
  }
  if (at == static_cast<int>(code_.constants.size())) code_.constants.emplace_back(value, nullptr, true);
  return operand(Where::constant, at);
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
  add(Op::refuse, place, {.a = static_cast<int>(code_.problems.size()) - 1});
}

// Registers.

Depths CodeWriter::depths() const {
  Depths out = scope_.depths;
  out.locals = static_cast<int>(scope_.locals.size());
  return out;
}

void CodeWriter::need(int registers) {
  registers_ = std::max(registers_, registers);
  code_.registers = std::max(code_.registers, registers);
}

Operand CodeWriter::next() {
  need(height() + 1);
  return operand(Where::temporary, height());
}

Operand CodeWriter::temporary() {
  const Operand out = next();
  ++temporaries_;
  return out;
}

int CodeWriter::declare(const std::string& name) {
  scope_.locals.push_back(name);
  scope_.variables.push_back(static_cast<int>(code_.variables.size()));
  const int slot = static_cast<int>(scope_.locals.size()) - 1;
  code_.variables.push_back({name, slot, here(), -1});
  need(slot + 1);
  return slot;
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

Operand CodeWriter::variable(const Resolved& resolved, Place place) {
  if (resolved.where == Resolved::Where::local) return operand(Where::local, resolved.slot);
  const Operand out = operand(Where::global, resolved.slot);
  if (!all_sure_ && !sure_globals_[static_cast<std::size_t>(resolved.slot)])
    add(Op::require, place, {.a = out});
  return out;
}

}  // namespace polyarm::program
