#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "polyarm/program/code.hpp"
#include "polyarm/program/scope.hpp"

namespace polyarm::program {

namespace {
using Statements = Statement::Kind;

struct Use {
  Place place;
  const Statement* task;
};

class TaskCheck {
 public:
  TaskCheck(const Program& program, const KnownNames& known, Scope& scope)
      : program_{program}, scope_{scope} {
    if (known.robots && known.robots->names.size() == 1) only_ = known.robots->names.front();
  }

  void run() {
    std::map<std::string, Use> robots;
    std::map<std::string, std::set<const Statement*>> meetings;
    std::map<std::string, Place> first_meeting;
    for (const Statement& s : program_.statements) {
      if (s.kind == Statements::task) robots_in(s.body, s, robots);
      for_each_statement(s.body, [&](const Statement& inner) {
        if (inner.kind != Statements::meet || inner.name.empty()) return;
        meetings[inner.name].insert(&s);
        first_meeting.try_emplace(inner.name, inner.place);
      });
    }
    for (const auto& [name, tasks] : meetings)
      if (tasks.size() == 1 && (*tasks.begin())->kind != Statements::function)
        error("no-meeting", first_meeting.at(name), "no other task reaches '" + name + "'",
              "use `meet` in two or more tasks");
  }

 private:
  /// Two tasks that command one robot outside a lock. What a function moves counts at its call, which `call`
  /// is then.
  void robots_in(const Block& block_, const Statement& task, std::map<std::string, Use>& robots,
                 std::optional<Place> call = {}) {
    for (const Statement& s : block_) {
      if (s.kind == Statements::lock) continue;
      bool named = false;
      for (const Clause& clause : s.clauses) {
        robots_in(clause.otherwise, task, robots, call);
        if (clause.kind != Clause::Kind::robot || !clause.value) continue;
        const std::string name =
            clause.value->kind == Expression::Kind::literal ? clause.value->value.text() : clause.value->name;
        used(name, call.value_or(clause.place), task, robots);
        named = true;
      }
      if (s.kind == Statements::move && !named && !only_.empty() && !s.moves_base())
        used(only_, call.value_or(s.place), task, robots);
      robots_called(s, task, robots, call);
      robots_in(s.body, task, robots, call);
      robots_in(s.handler, task, robots, call);
      for (const Branch& branch : s.branches) robots_in(branch.body, task, robots, call);
    }
  }
  void robots_called(const Statement& s, const Statement& task, std::map<std::string, Use>& robots,
                     std::optional<Place> call) {
    for_each_expression(s, [&](const Expression& e) {
      for_each_call(e, [&](const Expression& each) {
        const Statement* function = scope_.function(each.name);
        if (function && called_.insert({&task, function}).second)
          robots_in(function->body, task, robots, call.value_or(each.place));
      });
    });
  }

  void used(const std::string& name, Place place, const Statement& task, std::map<std::string, Use>& robots) {
    const auto [at, made] = robots.try_emplace(name, Use{place, &task});
    if (!made && at->second.task != &task)
      error("two-tasks", place,
            "the robot '" + name + "' is used by the task '" + at->second.task->name + "' in line " +
                std::to_string(at->second.place.line) + ", too",
            "only one task may command a robot, unless each use is inside a `lock`");
  }

  void error(std::string code, Place place, std::string what, std::string advice) {
    scope_.error(std::move(code), place, std::move(what), std::move(advice));
  }

  const Program& program_;
  Scope& scope_;
  std::string only_;  ///< the robot of a cell with one robot
  std::set<std::pair<const Statement*, const Statement*>> called_;  ///< tasks, and functions that they call
};

/// Statements of one `together` run at the same time, so each moves robots of its own.
class TogetherCheck {
 public:
  TogetherCheck(const Program& program, const KnownNames& known, Scope& scope)
      : program_{program}, scope_{scope} {
    if (known.robots && known.robots->names.size() == 1) only_ = known.robots->names.front();
  }

  void run() { block(program_.statements, {}); }

 private:
  /// Robots, and where each is moved first. The base of a robot counts as another one.
  using Moved = std::map<std::string, Place>;

  static std::string robot_of(const Statement& s) {
    for (const Clause& clause : s.clauses)
      if (clause.kind == Clause::Kind::robot && clause.value)
        return clause.value->kind == Expression::Kind::literal ? clause.value->value.text()
                                                               : clause.value->name;
    return {};
  }

  /// `robot`: what moves use that name none.
  void block(const Block& statements, std::string robot) {
    for (const Statement& s : statements) {
      if (s.kind == Statements::use)
        if (const std::string named = robot_of(s); !named.empty()) robot = named;
      if (s.kind == Statements::together) together(s, robot);
      for_each_block(s, [&](const Block& inner) { block(inner, robot); });
    }
  }

  void together(const Statement& s, const std::string& robot) {
    Moved all;
    for (const Statement& part : s.body) {
      Moved own;
      std::set<std::string> seen;
      std::string used = robot;
      moved_by(part, used, own, seen);
      for (const auto& [name, place] : own) {
        const auto [first, is_new] = all.try_emplace(name, place);
        if (!is_new) refuse(name, first->second, place, part.place);
      }
    }
  }

  void refuse(const std::string& name, Place first, Place second, Place statement) {
    const bool in_function = second.file != statement.file || second.line < statement.line;
    scope_.error(
        "two-moves", in_function ? statement : second,
        (name.empty() ? "one robot" : "'" + name + "'") + " is moved twice in one 'together', here and " +
            scope_.in_line(first, second) + ": its statements run at the same time",
        "put these moves one after the other outside of 'together', or name another robot: `robot NAME`");
  }

  void moved_by(const Statement& s, std::string& robot, Moved& out, std::set<std::string>& seen) const {
    if (s.kind == Statements::lock || s.kind == Statements::function) return;
    if (s.kind == Statements::use)
      if (const std::string named = robot_of(s); !named.empty()) robot = named;
    if (s.kind == Statements::move) {
      std::string name = robot_of(s);
      if (name.empty()) name = robot;
      if (name.empty()) name = only_;
      out.try_emplace((s.moves_base() ? "the base of " : "") + name, s.place);
    }
    for_each_expression(s, [&](const Expression& e) {
      for_each_call(e, [&](const Expression& call) {
        const Statement* function = scope_.function(call.name);
        if (function && seen.insert(call.name).second) moved_in(function->body, robot, out, seen);
      });
    });
    for_each_block(s, [&](const Block& inner) { moved_in(inner, robot, out, seen); });
  }
  void moved_in(const Block& statements, std::string robot, Moved& out, std::set<std::string>& seen) const {
    for (const Statement& s : statements) moved_by(s, robot, out, seen);
  }

  static void for_each_block(const Statement& s, const std::function<void(const Block&)>& visit) {
    visit(s.body);
    visit(s.handler);
    for (const Branch& branch : s.branches) visit(branch.body);
    for (const Clause& clause : s.clauses) visit(clause.otherwise);
  }

  const Program& program_;
  Scope& scope_;
  std::string only_;  ///< the robot of a cell with one robot
};
}  // namespace

void check_tasks(const Program& program, const KnownNames& known, Scope& scope) {
  TaskCheck(program, known, scope).run();
  TogetherCheck(program, known, scope).run();
}

}  // namespace polyarm::program
