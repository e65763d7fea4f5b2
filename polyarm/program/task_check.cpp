#include <map>
#include <set>

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
  TaskCheck(const Program& program, Scope& scope) : program_{program}, scope_{scope} {}

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
        error("no-meeting", first_meeting.at(name), "no other task comes to '" + name + "'",
              "`meet` stands in two or more tasks");
  }

 private:
  /// Two tasks that command one robot outside a lock.
  void robots_in(const Block& block_, const Statement& task, std::map<std::string, Use>& robots) {
    for (const Statement& s : block_) {
      if (s.kind == Statements::lock) continue;
      for (const Clause& clause : s.clauses) {
        if (clause.kind != Clause::Kind::robot || !clause.value) continue;
        const std::string name =
            clause.value->kind == Expression::Kind::literal ? clause.value->value.text() : clause.value->name;
        const auto [at, made] = robots.try_emplace(name, Use{clause.place, &task});
        if (!made && at->second.task != &task)
          error("two-tasks", clause.place,
                "the robot '" + name + "' is used by the task '" + at->second.task->name + "' in line " +
                    std::to_string(at->second.place.line) + ", too",
                "a robot belongs to one task; where they take turns, use it inside a `lock`");
      }
      robots_in(s.body, task, robots);
      robots_in(s.handler, task, robots);
      for (const Branch& branch : s.branches) robots_in(branch.body, task, robots);
    }
  }

  void error(std::string code, Place place, std::string what, std::string advice) {
    scope_.error(std::move(code), place, std::move(what), std::move(advice));
  }

  const Program& program_;
  Scope& scope_;
};
}  // namespace

void check_tasks(const Program& program, Scope& scope) {
  TaskCheck(program, scope).run();
}

}  // namespace polyarm::program
