/// Finds loops that never wait: those that never end, and those that poll a value.
#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "polyarm/base/text.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/program/scope.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

/// The effects of a loop, including the functions that it calls.
struct Doing {
  bool takes_time = false;
  bool leaves = false;               ///< it may end itself
  bool acts = false;                 ///< it reads or sets something of the cell
  std::set<std::string> changes;     ///< names that it sets
  std::set<std::string> decided_by;  ///< names that its conditions read
};

class EndlessCheck {
 public:
  EndlessCheck(const Program& program, Scope& scope) : program_{program}, scope_{scope} {}

  void run() {
    for_each_statement(program_.statements, [this](const Statement& s) {
      for (const Parameter& parameter : s.parameters) own_.insert(parameter.name);
      if (s.kind == Kind::let || s.kind == Kind::for_loop || s.kind == Kind::try_block)
        own_.insert({s.name, s.second_name});
    });
    loops_in(program_.statements);
  }

 private:
  /// True if something was reported; for nested loops only the innermost is reported.
  bool loops_in(const Block& block) {
    bool told = false;
    for (const Statement& s : block) {
      bool inner = loops_in(s.body);
      inner = loops_in(s.handler) || inner;
      for (const Branch& branch : s.branches) inner = loops_in(branch.body) || inner;
      for (const Clause& clause : s.clauses) inner = loops_in(clause.otherwise) || inner;
      if (!inner && s.kind == Kind::while_loop && s.expression) inner = loop(s);
      told = told || inner;
    }
    return told;
  }

  bool loop(const Statement& s) {
    const bool* constant = s.expression->value.as_boolean();
    const bool always = s.expression->kind == Expression::Kind::literal && constant && *constant;
    Doing doing;
    std::set<std::string> seen;
    look(*s.expression, doing, seen, true);
    look(s.body, doing, seen, false);
    if (doing.takes_time) return false;
    const auto changes = [&](const std::string& name) { return doing.changes.contains(name); };
    if (std::any_of(doing.decided_by.begin(), doing.decided_by.end(), changes)) return false;  // it counts
    const std::vector<std::string> asked = of_the_cell(doing.decided_by);
    if (asked.empty() && doing.leaves) return false;
    if (asked.empty() && !doing.acts && always) {
      scope_.error("endless-loop", s.place,
                   "this loop never ends and never waits: the program does not get past it",
                   "end it with `break`, or let it `wait` or move");
      return true;
    }
    if (asked.empty() && !doing.acts) return false;  // nothing changes this name
    scope_.warning("busy-loop", s.place,
                   "this loop never waits: it runs as often as it can" +
                       (asked.empty() ? std::string{} : " until " + join(asked, " or ") + " changes"),
                   s.body.empty() && asked.size() == 1 ? "a `wait` for the opposite condition does the same"
                                                       : "add `wait 10ms` to it, or `wait CONDITION`");
    return true;
  }

  void look(const Block& block, Doing& out, std::set<std::string>& seen, bool in_inner_loop) {
    for (const Statement& s : block) {
      if (s.kind == Kind::function || s.kind == Kind::task) continue;
      out.takes_time = out.takes_time || takes_time(s) || s.kind == Kind::run || s.kind == Kind::expect;
      const bool ends_inner = s.kind == Kind::break_loop && in_inner_loop;
      out.leaves = out.leaves || s.kind == Kind::stop || s.kind == Kind::raise ||
                   s.kind == Kind::return_value || (s.kind == Kind::break_loop && !ends_inner);
      const bool loops = s.kind == Kind::while_loop || s.kind == Kind::for_loop;
      if (s.kind == Kind::set || s.kind == Kind::set_literal || s.kind == Kind::pulse) change(s.name, out);
      if (s.expression) look(*s.expression, out, seen, loops);
      if (s.second) look(*s.second, out, seen, loops);
      for (const ExpressionPtr& argument : s.arguments) look(*argument, out, seen, false);
      for (const PathPart& part : s.path)
        if (part.index) look(*part.index, out, seen, false);
      for (const Branch& branch : s.branches) {
        if (branch.condition) look(*branch.condition, out, seen, true);
        look(branch.body, out, seen, in_inner_loop);
      }
      look(s.body, out, seen, in_inner_loop || loops);
      look(s.handler, out, seen, in_inner_loop);
    }
  }

  void look(const Expression& e, Doing& out, std::set<std::string>& seen, bool decides) {
    if (e.kind == Expression::Kind::name) {
      out.acts = out.acts || is_of_the_cell(e.name);
      if (decides) out.decided_by.insert(e.name);
    }
    if (e.kind == Expression::Kind::call) called(e, out, seen, decides);
    for (const ExpressionPtr& part : e.parts) look(*part, out, seen, decides);
  }

  void called(const Expression& e, Doing& out, std::set<std::string>& seen, bool decides) {
    if (e.name == "ask") out.takes_time = true;
    const Statement* function = scope_.function(e.name);
    if (!function) return;
    if (decides)
      for_each_statement(function->body, [&](const Statement& s) {
        for_each_expression(s, [&](const Expression& inner) {
          for (const std::string& name : names_read(inner)) out.decided_by.insert(name);
        });
      });
    if (!seen.insert(e.name).second) return;
    Doing inner;
    look(function->body, inner, seen, true);
    out.takes_time = out.takes_time || inner.takes_time;
    out.acts = out.acts || inner.acts;
    out.changes.merge(inner.changes);
    for_each_statement(function->body, [&](const Statement& s) {
      out.leaves = out.leaves || s.kind == Kind::stop || s.kind == Kind::raise;
    });
  }

  void change(const std::string& name, Doing& out) {
    out.changes.insert(name);
    out.acts = out.acts || is_of_the_cell(name);
  }

  bool is_of_the_cell(const std::string& name) const {
    return !own_.contains(name) && !own_.contains(name.substr(0, name.find('.')));
  }
  std::vector<std::string> of_the_cell(const std::set<std::string>& names) const {
    std::vector<std::string> out;
    for (const std::string& name : names)
      if (is_of_the_cell(name)) out.push_back("'" + name + "'");
    return out;
  }

  const Program& program_;
  Scope& scope_;
  std::set<std::string> own_;  ///< names that the program creates
};
}  // namespace

void check_endless(const Program& program, Scope& scope) {
  EndlessCheck(program, scope).run();
}

}  // namespace polyarm::program
