#include "polyarm/cell/rehearsal.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/cell/inside.hpp"
#include "polyarm/cell/open_names.hpp"
#include "polyarm/cell/prompter.hpp"
#include "polyarm/cell/rehearsal_stage.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/program/interpreter.hpp"

namespace polyarm::cell {

namespace {

constexpr int kMostSteps = 20000;
constexpr int kStatements = 50;       // at a time
constexpr int kEndlessSteps = 10000;  // without a wait or a move
constexpr int kMostStalls = 100;      // without a statement begun
constexpr std::uint64_t kPasses = 2;
constexpr std::uint64_t kCountedPasses = 50;  // of a loop whose condition compares
constexpr int kMostVariants = 24;             // of values that decide about branches

/// Ends waits. One thing at a time, so that what waits for one of two sees one of them.
class Helper {
 public:
  /// `late`: the place of a wait that always times out; empty: each comes to what it waits for.
  Helper(Stage& stage, const PossibleValues& values, std::string late)
      : stage_(stage), prompter_(values), late_(std::move(late)) {}
  /// False where nothing helps.
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

/// A loop that counts goes on to its end; one that goes on while a name is true is passed twice.
std::uint64_t passes_of(const program::Program& program) {
  for (const program::Statement& s : program.statements)
    if (s.kind == program::Statement::Kind::while_loop && s.expression && compares(*s.expression))
      return kCountedPasses;
  return kPasses;
}

void go_through(Stage& stage, const std::shared_ptr<program::Compiled>& compiled,
                const PossibleValues& values, const std::string& late) {
  program::Interpreter interpreter(compiled, stage);
  stage.attend(&interpreter);
  const std::uint64_t passes = passes_of(compiled->program);
  interpreter.limit_passes(passes);
  Helper helper(stage, values, late);
  std::uint64_t events = 0;
  for (int step = 0, quiet = 0;; ++step, ++quiet) {
    const program::StepResult result = interpreter.step(kStatements);
    if (result.state != program::TaskState::running && result.state != program::TaskState::waiting) {
      if (result.state == program::TaskState::failed) stage.tell_failure(interpreter.overview());
      break;
    }
    if (result.executed > 0)
      helper.went_on();
    else if (!helper.help(interpreter.status()))
      step = kMostSteps;
    if (std::exchange(events, stage.events()) != stage.events()) quiet = 0;
    if (quiet >= kEndlessSteps) {
      stage.tell_endless(interpreter.overview().where, kEndlessSteps * kStatements);
      step = kMostSteps;
    }
    if (step < kMostSteps && !stage.enough() && interpreter.overview().passes < passes) continue;
    if (interpreter.overview().passes < passes) stage.result().reached = interpreter.overview().where;
    break;
  }
  stage.start_arrival({});
}

/// A program, and what runs beside it.
struct Subject {
  CellInside& cell;
  Task& task;
  const Task* other;    ///< null: none
  ProgramMoves* moves;  ///< null: it moves nothing

  const std::shared_ptr<program::Compiled>& compiled() const { return task.interpreter().compiled(); }
  const program::Program* others() const { return other ? &other->interpreter().program() : nullptr; }
};

/// What one pass through the program supposes.
struct Variant {
  std::optional<NamedValue> kept = {};  ///< a name that has one value all the time
  std::string late = {};                ///< the place of a wait that times out
};

/// Once, with values that end its waits.
Rehearsal go_once(const Subject& subject, const PossibleValues& values, const Variant& variant,
                  bool with_paths) {
  Stage stage(subject.cell, subject.compiled()->program, subject.others(), subject.moves, with_paths);
  if (variant.kept) stage.keep(*variant.kept);
  try {
    go_through(stage, subject.compiled(), values, variant.late);
  } catch (const Error&) {  // what else is wrong with it others tell
  }
  return std::move(stage.result());
}

/// What leads to other branches: values of names that others set, and of tags that nobody sets but a person;
/// and each wait that may time out.
std::vector<Variant> variants(const Subject& subject, const PossibleValues& values) {
  const std::set<std::string> open = open_names(subject.cell.data, subject.others());
  const std::set<std::string> own = names_set(subject.compiled()->program);
  std::vector<Variant> out;
  const program::Program& program = subject.compiled()->program;
  program::for_each_statement(program.statements, [&](const program::Statement& s) {
    if (s.kind == program::Statement::Kind::wait && s.second)
      out.push_back({.late = program.at(s.place).text()});
  });
  for (const std::string& name : values.deciding()) {
    const data::Value* now = subject.cell.data.store.find(name);
    const bool of_a_person = subject.cell.data.store.is_tag(name) && !own.contains(name);
    if (!now || (!open.contains(name) && !of_a_person)) continue;
    out.push_back({.kept = NamedValue{name, *now}});
    for (data::Value& value : values.instead_of(name, *now))
      out.push_back({.kept = NamedValue{name, std::move(value)}});
  }
  return out;
}

/// What is wrong in branches that the present values do not lead to.
void add_branches(const Subject& subject, const PossibleValues& values, Rehearsal& out) {
  std::set<std::string> told;
  const auto is_new = [&](const Problem& problem) {
    return told.insert(problem.where.text() + problem.what).second;
  };
  for (const Problem& problem : out.problems.list()) is_new(problem);
  std::size_t moves = 0;
  int count = 0;
  for (const Variant& variant : variants(subject, values)) {
    if (++count > kMostVariants || moves > Stage::kMostMoves) return;
    const Rehearsal found = go_once(subject, values, variant, false);
    moves += found.moves;
    for (const Problem& problem : found.problems.list())
      if (problem.code != "busy-loop" && is_new(problem)) out.problems.add(problem);
  }
}

Rehearsal go_everywhere(const Subject& subject, bool with_paths) {
  const PossibleValues values(subject.compiled()->program, subject.others());
  Rehearsal out = go_once(subject, values, {}, with_paths);
  add_branches(subject, values, out);
  return out;
}
}  // namespace

Rehearsal rehearse(CellInside& cell, bool with_paths) {
  Programs& programs = *cell.programs;
  if (!programs.program() || !programs.moves()) return {};
  return go_everywhere({cell, *programs.program(), programs.plc(), programs.moves()}, with_paths);
}

Rehearsal rehearse_plc(CellInside& cell) {
  Programs& programs = *cell.programs;
  if (!programs.plc()) return {};
  return go_everywhere({cell, *programs.plc(), programs.program(), nullptr}, false);
}

}  // namespace polyarm::cell
