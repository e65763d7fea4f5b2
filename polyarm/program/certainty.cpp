#include "polyarm/program/certainty.hpp"

#include <algorithm>

#include "polyarm/language/functions.hpp"
#include "polyarm/program/code.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

std::string first_part(const std::string& name) {
  return name.substr(0, name.find('.'));
}

/// True if it leaves its block early.
bool leaves(const Statement& s) {
  return s.kind == Kind::stop || s.kind == Kind::break_loop || s.kind == Kind::continue_loop ||
         s.kind == Kind::return_value || s.kind == Kind::raise || s.kind == Kind::retry;
}

bool calls_any(const Statement& s, const std::set<std::string>& functions) {
  bool out = false;
  for_each_expression(s, [&](const Expression& e) {
    for_each_call(e, [&](const Expression& called) { out = out || functions.contains(called.name); });
  });
  return out;
}
}  // namespace

Certainty::Certainty(const Program& program, std::set<std::string> open)
    : program_{program}, open_{std::move(open)} {
  collect(program_.statements, nullptr);
  find_moving_functions();
  do check_everything();
  while (changed_);
}

void Certainty::collect(const Block& statements, const Statement* function) {
  for (const Statement& s : statements) {
    spots_.try_emplace({s.place.file, s.place.line}, Spot{&s, function});
    if (s.kind == Kind::function) functions_[s.name] = &s;
    if (s.kind == Kind::use) uses_.push_back(&s);
    const Statement* const inner = s.kind == Kind::function ? &s : function;
    collect(s.body, inner);
    collect(s.handler, inner);
    for (const Branch& branch : s.branches) collect(branch.body, inner);
    for (const Clause& clause : s.clauses) collect(clause.otherwise, inner);
  }
}

void Certainty::find_moving_functions() {
  do {
    changed_ = false;
    for (const auto& [name, function] : functions_)
      if (has_moves(function->body)) make_open(moving_, name);
  } while (changed_);
}

/// One pass over the program. An open name may make earlier lines open, so the pass is repeated.
void Certainty::check_everything() {
  changed_ = false;
  conditions_known_ = true;
  open_blocks_.clear();
  block(program_.statements, false);
  for (const auto& [name, function] : functions_) check_function(*function);
}

void Certainty::check_function(const Statement& function) {
  inside_ = &function;
  std::set<std::string> made;
  for (const Parameter& parameter : function.parameters) {
    made.insert(parameter.name);
    if (reads_open(parameter.value)) make_open(open_, parameter.name);
  }
  block(function.body, called_openly_.contains(function.name), std::move(made));
  inside_ = nullptr;
}

void Certainty::block(const Block& statements, bool open, std::set<std::string> made) {
  if (open && !statements.empty() && has_moves(statements)) {
    OpenBlock lines{statements.front().place.file, statements.front().place.line, 0};
    for_each_statement(statements,
                       [&](const Statement& s) { lines.last = std::max(lines.last, s.place.line); });
    open_blocks_.push_back(lines);
  }
  around_.push_back({open, std::move(made)});
  for (const Statement& s : statements) statement(s);
  around_.pop_back();
}

void Certainty::statement(const Statement& s) {
  if (s.kind == Kind::function) return;  // check_function()
  for_each_expression(s, [&](const Expression& e) { for_each_call(e, [&](const auto& c) { call(c); }); });
  for (const Clause& clause : s.clauses) {
    if (clause.kind == Clause::Kind::at) make_open(open_, first_part(clause.target));  // at any moment
    block(clause.otherwise, true);
  }
  if (leaves(s)) ends(s);
  switch (s.kind) {
    case Kind::let:
      around_.back().made.insert(s.name);
      return give(s.name, reads_open(s.expression));
    case Kind::set:
    case Kind::set_literal:
      return give(s.name, reads_open(s));
    case Kind::branch:
      return branches(s);
    case Kind::while_loop: {
      const bool open = reads_open(s.expression);
      conditions_known_ = conditions_known_ && !open;
      return block(s.body, open || leaves_openly(s.body, false));
    }
    case Kind::for_loop:
      return for_loop(s);
    case Kind::try_block:  // any failure in it may depend on open values
      make_open(open_, s.name);
      block(s.body, true);
      return block(s.handler, true);
    case Kind::lock:
      return block(s.body, false);
    default:  // code after a timeout, and code that runs in parallel or at any moment
      return block(s.body, true);
  }
}

void Certainty::branches(const Statement& s) {
  bool open = false;
  for (const Branch& branch : s.branches) {
    open = open || reads_open(branch.condition);
    conditions_known_ = conditions_known_ && !open;
    block(branch.body, open);
  }
}

void Certainty::for_loop(const Statement& s) {
  const bool open_range = reads_open(s.expression) || reads_open(s.second);
  const bool open = open_range || leaves_openly(s.body, false);
  conditions_known_ = conditions_known_ && !open_range;
  if (open) make_open(open_, s.name);
  if (open && !s.second_name.empty()) make_open(open_, s.second_name);
  block(s.body, open, {s.name, s.second_name});
}

/// A return, stop, raise … of a function.
void Certainty::ends(const Statement& s) {
  if (!inside_) return;
  if (s.kind == Kind::return_value && (reads_open(s.expression) || in_open_block()))
    make_open(open_results_, inside_->name);
  if ((s.kind == Kind::stop || s.kind == Kind::raise) && in_open_block()) make_open(leaving_, inside_->name);
}

/// Arguments give parameters their values.
void Certainty::call(const Expression& e) {
  const auto at = functions_.find(e.name);
  if (at == functions_.end()) return;
  const std::vector<Parameter>& parameters = at->second->parameters;
  for (std::size_t i = 0; i < e.parts.size(); ++i) {
    if (!reads_open(e.parts[i])) continue;
    const bool named = i < e.names.size() && !e.names[i].empty();
    if (named)
      make_open(open_, e.names[i]);
    else if (i < parameters.size())
      make_open(open_, parameters[i].name);
  }
  if (in_open_block()) make_open(called_openly_, e.name);
  if (inside_ && leaving_.contains(e.name)) make_open(leaving_, inside_->name);
}

/// Assigns a value to a name. A name from outside of the present open block becomes open.
void Certainty::give(const std::string& name, bool open) {
  const std::string first = first_part(name);
  for (auto around = around_.rbegin(); around != around_.rend() && !open; ++around) {
    if (around->made.contains(first)) break;
    open = around->open;
  }
  if (open) make_open(open_, name);
}

void Certainty::make_open(std::set<std::string>& names, const std::string& name) {
  changed_ = names.insert(name).second || changed_;
}

bool Certainty::in_open_block() const {
  return std::any_of(around_.begin(), around_.end(), [](const Around& around) { return around.open; });
}

bool Certainty::reads_open(const Expression& e) const {
  using Kinds = Expression::Kind;
  if (e.kind == Kinds::name && (open_.contains(e.name) || open_.contains(first_part(e.name)))) return true;
  const Function* live = e.kind == Kinds::call && !functions_.contains(e.name) ? find_function(e.name) : nullptr;
  if (live && live->open) return true;
  if (e.kind == Kinds::call && (e.name == "ask" || open_results_.contains(e.name))) return true;
  return std::any_of(e.parts.begin(), e.parts.end(),
                     [this](const ExpressionPtr& part) { return reads_open(*part); });
}

bool Certainty::reads_open(const Statement& s) const {
  bool out = false;
  for_each_expression(s, [&](const Expression& e) { out = out || reads_open(e); });
  for (const Clause& clause : s.clauses)  // frame "NAME"
    if (clause.value && clause.value->kind == Expression::Kind::literal && clause.value->value.as_text())
      out = out || open_.contains(*clause.value->value.as_text());
  if (s.kind == Kind::move)
    for (const Statement* use : uses_) out = out || reads_open(*use);
  return out;
}

/// True if an open value may decide whether the block continues after its end or the program ends.
bool Certainty::leaves_openly(const Block& statements, bool open) const {
  for (const Statement& s : statements) {
    if (open && leaves(s)) return true;
    if (calls_any(s, leaving_)) return true;
    bool inner = open;
    for (const Branch& branch : s.branches) {
      inner = inner || reads_open(branch.condition);
      if (leaves_openly(branch.body, inner)) return true;
    }
    const bool after_timeout = s.kind == Kind::wait || s.kind == Kind::meet;
    if (leaves_openly(s.body, open || after_timeout || reads_open(s.expression))) return true;
    if (leaves_openly(s.handler, true)) return true;
    for (const Clause& clause : s.clauses)
      if (leaves_openly(clause.otherwise, true)) return true;
  }
  return false;
}

bool Certainty::has_moves(const Block& statements) const {
  bool out = false;
  for_each_statement(statements,
                     [&](const Statement& s) { out = out || s.kind == Kind::move || calls_any(s, moving_); });
  return out;
}

Place Certainty::place_of(const Location& where) const {
  for (int file = 0; file <= static_cast<int>(program_.included.size()); ++file)
    if (program_.at({where.line, 0, file}).file == where.file) return {where.line, 0, file};
  return {where.line, 0, -1};
}

bool Certainty::values_known(const Location& where) const {
  const Place place = place_of(where);
  const auto at = spots_.find({place.file, place.line});
  return at != spots_.end() && !reads_open(*at->second.statement);
}

bool Certainty::values_known(const std::vector<Location>& calls) const {
  if (calls.empty()) return false;
  if (calls.size() == 1) return values_known(calls.front());
  Certainty here = *this;
  for (std::size_t i = 0; i + 1 < calls.size(); ++i) {
    const Place by = place_of(calls[i]), inside = place_of(calls[i + 1]);
    const auto caller = spots_.find({by.file, by.line}), called = spots_.find({inside.file, inside.line});
    if (caller == spots_.end() || called == spots_.end() || !called->second.function) return false;
    here.enter(*called->second.function, *caller->second.statement);
  }
  return here.values_known(calls.back());
}

void Certainty::enter(const Statement& function, const Statement& by) {
  std::set<std::string> open;
  const auto arguments = [&](const Expression& e) {
    if (e.name != function.name) return;
    for (std::size_t i = 0; i < e.parts.size(); ++i) {
      if (!reads_open(e.parts[i])) continue;
      const bool named = i < e.names.size() && !e.names[i].empty();
      if (named)
        open.insert(e.names[i]);
      else if (i < function.parameters.size())
        open.insert(function.parameters[i].name);
    }
  };
  for_each_expression(by, [&](const Expression& e) { for_each_call(e, arguments); });
  for (const Parameter& parameter : function.parameters) open_.erase(parameter.name);
  for_each_statement(function.body, [&](const Statement& s) {
    if (s.kind == Kind::let || s.kind == Kind::for_loop) open_.erase(s.name), open_.erase(s.second_name);
  });
  open_.merge(open);
  do {
    changed_ = false;
    check_function(function);
  } while (changed_);
}

bool Certainty::follows(const Location& from, const Location& to) const {
  const Place begin = from.file.empty() ? Place{0, 0, place_of(to).file} : place_of(from);
  const Place end = place_of(to);
  const auto function = [&](Place place) {
    const auto at = spots_.find({place.file, place.line});
    return at == spots_.end() ? nullptr : at->second.function;
  };
  const bool in_order = begin.file == end.file && function(begin) == function(end);
  return std::none_of(open_blocks_.begin(), open_blocks_.end(), [&](const OpenBlock& block) {
    if (block.contains(end)) return false;
    if (block.contains(begin) || !in_order) return true;
    if (block.file != end.file) return false;
    if (begin.line <= end.line) return block.first > begin.line && block.last < end.line;
    return block.first > begin.line || block.last < end.line;  // around a loop
  });
}

}  // namespace polyarm::program
