#include <algorithm>

#include "polyarm/program/code.hpp"
#include "polyarm/program/scope.hpp"

namespace polyarm::program {

namespace {
using Kind = Statement::Kind;

class BlendCheck {
 public:
  BlendCheck(const Program& program, Scope& scope) : program_{program}, scope_{scope} {}

  void run() {
    collect_variables();
    block(program_.statements, true);
  }

 private:
  /// All names that a line of the program creates; reading one does not wait.
  void collect_variables() {
    for_each_statement(program_.statements, [&](const Statement& s) {
      if (s.kind == Kind::let || s.kind == Kind::for_loop || s.kind == Kind::try_block) made_.insert(s.name);
      made_.insert(s.second_name);
      for (const Parameter& parameter : s.parameters) made_.insert(parameter.name);
    });
  }

  bool is_variable(const std::string& name) const { return made_.contains(name.substr(0, name.find('.'))); }

  /// The part of an expression that reads from the cell, or an empty text.
  std::string world_in(const Expression& e) const {
    if (e.kind == Expression::Kind::call && (e.name == "here" || e.name == "ask")) return e.name + "()";
    const Function* function = e.kind == Expression::Kind::call ? find_function(e.name) : nullptr;
    const bool near_given = function && function->live == Live::ik && e.parts.size() > 1;
    if (function && function->waits && !near_given) return e.name + "()";
    if (e.kind == Expression::Kind::name && !is_variable(e.name)) {
      const auto at = scope_.names.find(e.name);
      const bool waits = at != scope_.names.end() && at->second.kind && !is_place(at->second) &&
                         *at->second.kind != data::Kind::list;
      return waits ? "'" + e.name + "'" : "";
    }
    for (const ExpressionPtr& part : e.parts)
      if (std::string found = world_in(*part); !found.empty()) return found;
    return {};
  }

  /// The reason why `s` first waits for motion, or an empty text.
  std::string waits(const Statement& s) const {
    switch (s.kind) {
      case Kind::load:
      case Kind::import:
        return "loads data";
      case Kind::move:
        if (s.moves_at_speed()) return "starts at the present position of the robot";
        break;
      case Kind::wait:
      case Kind::wait_time:
      case Kind::ask:
        return "waits";
      case Kind::meet:
      case Kind::lock:
      case Kind::together:
        return "waits for other tasks";
      case Kind::hold:
      case Kind::stop:
        return "ends the motion";
      case Kind::set_literal:
      case Kind::set:
        if (!s.name.empty() && !is_variable(s.name)) return "sets '" + s.name + "'";
        break;
      default:
        break;
    }
    std::string found;
    for_each_expression(s, [&](const Expression& e) {
      if (found.empty()) found = world_in(e);
    });
    return found.empty() ? found : "reads " + found;
  }

  static const Clause* own_blend(const Statement& s) {
    if (s.kind != Kind::move || s.motion == Statement::Motion::moveto || s.moves_base() || s.moves_at_speed())
      return nullptr;
    const Clause* blend = nullptr;
    for (const Clause& clause : s.clauses) {
      if (clause.kind == Clause::Kind::exact || clause.kind == Clause::Kind::until) return nullptr;
      if (clause.kind == Clause::Kind::blend) blend = &clause;
    }
    return blend;
  }

  static bool keeps_going(const Statement& s) {
    return s.kind == Kind::let || s.kind == Kind::set || s.kind == Kind::log || s.kind == Kind::use ||
           s.kind == Kind::function || s.kind == Kind::task || s.kind == Kind::when || s.kind == Kind::trap || s.kind == Kind::every ||
           s.kind == Kind::on_stop;
  }

  /// Checks what certainly follows the move.
  void look_behind(const Block& block, std::size_t at, const Clause& blend, bool last_of_all) {
    for (std::size_t i = at + 1; i < block.size(); ++i) {
      const Statement& next = block[i];
      const std::string why = waits(next);
      if (!why.empty()) {
        scope_.warning("no-blend", blend.place,
                       "this blend cannot happen: line " + std::to_string(next.place.line) + " " + why +
                           ", and the robot arrives before that",
                       "write `exact` here, or move that line");
        return;
      }
      if (!keeps_going(next)) return;
    }
    if (last_of_all)
      scope_.warning("no-blend", blend.place, "this blend cannot happen: no move follows it",
                     "write `exact` here");
  }

  void block(const Block& block_, bool top) {
    const bool has_tasks =
        std::any_of(block_.begin(), block_.end(), [](const Statement& s) { return s.kind == Kind::task; });
    for (std::size_t i = 0; i < block_.size(); ++i) {
      const Statement& s = block_[i];
      if (const Clause* blend = own_blend(s)) look_behind(block_, i, *blend, top && !has_tasks);
      block(s.body, s.kind == Kind::task);
      block(s.handler, false);
      for (const Branch& branch : s.branches) block(branch.body, false);
      for (const Clause& clause : s.clauses) block(clause.otherwise, false);
    }
  }

  const Program& program_;
  Scope& scope_;
  std::set<std::string> made_;
};
}  // namespace

void check_blends(const Program& program, Scope& scope) {
  BlendCheck(program, scope).run();
}

}  // namespace polyarm::program
