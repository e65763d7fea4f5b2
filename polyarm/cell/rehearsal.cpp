#include "polyarm/cell/rehearsal.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/cell/prompter.hpp"
#include "polyarm/cell/rehearsal_stage.hpp"
#include "polyarm/inside/inside.hpp"
#include "polyarm/machine/open_names.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/vm/interpreter.hpp"

namespace polyarm::cell {

namespace {

constexpr int kMostSteps = 20000;
constexpr int kStatements = 50;       // per step
constexpr int kEndlessSteps = 10000;  // without a wait or a move
constexpr int kMostStalls = 100;      // steps in which no statement began
constexpr std::uint64_t kPasses = 2;
constexpr std::uint64_t kCountedPasses = 50;  // for a loop whose condition compares
constexpr std::size_t kMostVariants = 40;     // supposed values that decide branches
constexpr std::size_t kFewMoves = Stage::kMostMoves / 10;

/// Ends waits by setting values. Changes one value at a time, so a wait for one of two signals sees a single
/// change.
class Helper {
 public:
  /// `late` is the location of a wait that always times out; empty if all waits succeed.
  Helper(Stage& stage, const PossibleValues& values, std::string late)
      : stage_(stage), prompter_(values), late_(std::move(late)) {}
  /// False if no value ends the wait.
  bool help(const std::vector<program::TaskStatus>& tasks) {
    for (const program::TaskStatus& task : tasks) {
      if (task.state != program::TaskState::waiting) continue;
      where_ = task.where;
      const bool times_out = task.waiting.until && task.where.text() == late_;
      if (task.waiting.kind == program::WaitKind::time || times_out) {
        stage_.wait_until(task.waiting.until.value_or(0));
        return true;
      }
    }
    for (const program::TaskStatus& task : tasks) {
      if (task.state != program::TaskState::waiting) continue;
      std::vector<NamedValue> names;
      for (const std::string& name : task.waiting.names)
        if (const data::Value* value = stage_.find(name)) names.emplace_back(name, *value);
      const std::vector<NamedValue>* offer = prompter_.next(task.where, names);
      if (!offer) continue;
      for (const auto& [name, value] : *offer) stage_.help(name, value);
      return true;
    }
    stage_.wait_until(0);
    return ++stalls_ < kMostStalls;
  }
  void went_on() {
    stalls_ = 0;
    prompter_.went_on();
  }
  const Location& where() const { return where_; }

 private:
  Stage& stage_;
  Prompter prompter_;
  std::string late_;
  int stalls_ = 0;
  Location where_;
};

bool compares(const program::Expression& e) {
  return (e.kind == program::Expression::Kind::binary && program::is_comparison(e.op)) ||
         std::any_of(e.parts.begin(), e.parts.end(), [](const auto& part) { return compares(*part); });
}

/// True if the block does not wait, move, ask or call a function that may do so.
bool only_calculates(const program::Block& block) {
  using Kind = program::Statement::Kind;
  bool out = true;
  program::for_each_statement(block, [&](const program::Statement& s) {
    const bool plain = s.kind == Kind::let || s.kind == Kind::set || s.kind == Kind::set_literal ||
                       s.kind == Kind::branch || s.kind == Kind::while_loop || s.kind == Kind::for_loop ||
                       s.kind == Kind::break_loop || s.kind == Kind::continue_loop;
    out = out && plain;
    program::for_each_expression(s, [&](const program::Expression& e) {
      program::for_each_call(e, [&](const program::Expression&) { out = false; });
    });
  });
  return out;
}

/// True if a comparison decides about a `break` of the loop with this body.
bool leaves_by_comparison(const program::Block& body) {
  using Kind = program::Statement::Kind;
  const auto breaks = [](const program::Block& block) {
    return std::any_of(block.begin(), block.end(), [](const auto& s) { return s.kind == Kind::break_loop; });
  };
  return std::any_of(body.begin(), body.end(), [&](const program::Statement& s) {
    bool compared = false;  // in this branch or in one before it, as for an `else`
    return std::any_of(s.branches.begin(), s.branches.end(), [&](const auto& branch) {
      compared = compared || (branch.condition && compares(*branch.condition));
      return compared && breaks(branch.body);
    });
  });
}

/// Number of passes of the main loop to follow: kCountedPasses if its condition, or that of a `break`,
/// compares, because it may count to an end; otherwise kPasses. A comparing loop that only calculates has no
/// limit here, until it counts as endless. `at_breaks`: false disregards each `break`.
std::uint64_t passes_of(const program::Program& program, bool at_breaks) {
  for (const program::Statement& s : program.statements) {
    if (s.kind != program::Statement::Kind::while_loop || !s.expression) continue;
    if (!compares(*s.expression) && !(at_breaks && leaves_by_comparison(s.body))) continue;
    return only_calculates(s.body) ? std::numeric_limits<std::uint64_t>::max() : kCountedPasses;
  }
  return kPasses;
}

void go_through(Stage& stage, const std::shared_ptr<program::Compiled>& compiled,
                const PossibleValues& values, const Supposition& supposed, bool at_breaks) {
  program::Interpreter interpreter(compiled, stage);
  stage.attend(&interpreter);
  // A counting loop may never end if one name is kept constant; then only kPasses are followed.
  const std::uint64_t passes = supposed.kept ? kPasses : passes_of(compiled->program, at_breaks);
  interpreter.limit_passes(passes);
  Helper helper(stage, values, supposed.late);
  std::uint64_t events = 0;
  for (int step = 0, quiet = 0;; ++step, ++quiet) {
    const program::StepResult result = interpreter.step(kStatements);
    if (result.state != program::TaskState::running && result.state != program::TaskState::waiting) {
      if (result.state == program::TaskState::failed) stage.report_failure(interpreter.overview());
      break;
    }
    if (result.executed > 0) {
      helper.went_on();
    } else if (!helper.help(interpreter.status())) {
      if (const auto pulse = interpreter.next_pulse_end())
        stage.wait_until(*pulse);
      else
        step = kMostSteps;
    }
    if (std::exchange(events, stage.events()) != stage.events()) quiet = 0;
    if (quiet >= kEndlessSteps) {
      stage.report_endless(interpreter.overview().where, kEndlessSteps * kStatements);
      step = kMostSteps;
    }
    if (step < kMostSteps && !stage.enough() && interpreter.overview().passes < passes) continue;
    if (interpreter.overview().passes < passes) stage.tell_reached(interpreter.overview().where);
    break;
  }
  stage.start_arrival({});
}

/// A program, and the program that runs in parallel.
struct Subject {
  CellInside& cell;
  Task& task;
  const Task* other;    ///< null if there is none
  ProgramMoves* moves;  ///< null if the program moves nothing

  const std::shared_ptr<program::Compiled>& compiled() const { return task.interpreter().compiled(); }
  const program::Program* others() const { return other ? &other->interpreter().program() : nullptr; }
};

struct Pass {
  Rehearsal found;
  std::map<std::string, Question> questions;
};

/// One pass through the program, with values that end its waits. `at_breaks`: of passes_of().
Pass run_once(const Subject& subject, const PossibleValues& values, const Supposition& supposed,
              bool with_paths, bool at_breaks) {
  Stage stage(subject.cell, subject.compiled()->program, subject.others(), subject.moves, with_paths);
  stage.suppose(supposed);
  try {
    go_through(stage, subject.compiled(), values, supposed, at_breaks);
  } catch (const Error&) {  // other errors are reported elsewhere
  }
  Pass out{{}, stage.questions()};
  out.found = stage.take_result();
  return out;
}

/// The cell's names that may take any value, because no program sets them or because a program calculates
/// them.
std::set<std::string> names_with_any_value(const Subject& subject) {
  std::set<std::string> out = open_names(subject.cell.data, nullptr);
  if (!subject.others()) return out;
  using Kind = program::Statement::Kind;
  program::for_each_statement(subject.others()->statements, [&](const program::Statement& s) {
    if (s.kind == Kind::set && s.expression && s.expression->kind != program::Expression::Kind::literal)
      out.insert(s.name);
  });
  return out;
}

/// Suppositions that lead to other branches, one group per cause: values of names that others set, tags that
/// only a person sets, each wait that may time out, each `try` that may fail.
std::vector<std::vector<Supposition>> groups_of_suppositions(const Subject& subject,
                                                             const PossibleValues& values) {
  const program::Program& program = subject.compiled()->program;
  const std::set<std::string> open = open_names(subject.cell.data, subject.others());
  const std::set<std::string> any_value = names_with_any_value(subject);
  const std::set<std::string> own = names_set(program);
  std::vector<std::vector<Supposition>> out;
  program::for_each_statement(program.statements, [&](const program::Statement& s) {
    if (s.kind == program::Statement::Kind::wait && s.second)
      out.push_back({{.late = program.at(s.place).text()}});
    if (std::any_of(s.clauses.begin(), s.clauses.end(),
                    [](const program::Clause& c) { return c.kind == program::Clause::Kind::until; }))
      out.push_back({{.until = program.at(s.place).text()}});
    if (s.kind == program::Statement::Kind::try_block)
      out.push_back({{.fails = program.at(s.handler_place).text()}});
  });
  for (const std::string& name : values.deciding()) {
    const data::Value* now = subject.cell.data.store.find(name);
    const bool of_a_person = subject.cell.data.store.is_tag(name) && !own.contains(name);
    if (!now || (!open.contains(name) && !of_a_person)) continue;
    const bool only_tried = !any_value.contains(name);
    std::vector<Supposition>& group = out.emplace_back();
    group.push_back({.kept = NamedValue{name, *now}, .only_tried = only_tried});
    for (data::Value& value : values.instead_of(name, *now))
      group.push_back({.kept = NamedValue{name, std::move(value)}, .only_tried = only_tried});
  }
  return out;
}

/// Takes the first of each group, then the second of each, and so on, so a limit leaves out the least likely
/// ones.
std::vector<Supposition> in_turn(std::vector<std::vector<Supposition>> groups) {
  std::vector<Supposition> out;
  for (std::size_t i = 0, more = 1; more > 0; ++i) {
    more = 0;
    for (std::vector<Supposition>& group : groups)
      if (i < group.size()) out.push_back(std::move(group[i])), ++more;
  }
  return out;
}

/// Runs the program repeatedly and explores branches that the present values do not reach.
class Explorer {
 public:
  explicit Explorer(const Subject& subject)
      : subject_(subject),
        values_(subject.compiled()->program, subject.others(),
                [&subject](const std::string& name) { return subject.cell.data.store.find(name); }) {}

  Rehearsal run(bool with_paths) {
    Pass first = run_once(subject_, values_, {}, with_paths, true);
    Rehearsal out = std::move(first.found);
    for (const Problem& problem : out.problems.list()) is_new(problem);
    add_answers(first.questions);
    for (Supposition& each : in_turn(groups_of_suppositions(subject_, values_)))
      todo_.push_back(std::move(each));
    // Loops of many moves that end at a `break` would use up the moves of all other passes.
    const bool at_breaks = out.moves <= kFewMoves;
    std::size_t moves = 0;
    for (; out.variants < todo_.size(); ++out.variants) {
      if (out.variants >= kMostVariants || moves > Stage::kMostMoves) break;
      const Pass pass = run_once(subject_, values_, todo_[out.variants], false, at_breaks);
      moves += pass.found.moves;
      add_answers(pass.questions);
      for (const Problem& problem : pass.found.problems.list())
        if (problem.code != "busy-loop" && is_new(problem)) out.problems.add(problem);
    }
    out.left_out = todo_.size() - out.variants;
    return out;
  }

 private:
  /// Adds answers other than Enter's default, for questions not seen before.
  void add_answers(const std::map<std::string, Question>& questions) {
    std::vector<std::vector<Supposition>> groups;
    for (const auto& [name, question] : questions) {
      if (!asked_.insert(name).second) continue;
      std::vector<Supposition>& group = groups.emplace_back();
      for (data::Value& value : values_.other_answers(name, question.usual))
        group.push_back({.answer = NamedValue{name, std::move(value)}});
    }
    for (Supposition& each : in_turn(std::move(groups))) todo_.push_back(std::move(each));
  }
  bool is_new(const Problem& problem) { return announced_.insert(problem.where.text() + problem.what).second; }

  const Subject& subject_;
  PossibleValues values_;
  std::vector<Supposition> todo_;
  std::set<std::string> asked_, announced_;
};

}  // namespace

Rehearsal rehearse(CellInside& cell, bool with_paths) {
  Programs& programs = *cell.programs;
  if (!programs.program() || !programs.moves()) return {};
  const Subject subject{cell, *programs.program(), programs.plc(), programs.moves()};
  return Explorer(subject).run(with_paths);
}

Rehearsal rehearse_plc(CellInside& cell) {
  Programs& programs = *cell.programs;
  if (!programs.plc()) return {};
  const Subject subject{cell, *programs.plc(), programs.program(), nullptr};
  return Explorer(subject).run(false);
}

}  // namespace polyarm::cell
