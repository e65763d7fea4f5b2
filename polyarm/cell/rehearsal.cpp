#include "polyarm/cell/rehearsal.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "polyarm/cell/cell.hpp"
#include "polyarm/cell/relative_moves.hpp"
#include "polyarm/program/interpreter.hpp"
#include "polyarm/program/parser.hpp"

namespace polyarm::cell {

namespace {

constexpr std::size_t kMostMoves = 500;
constexpr int kMostSteps = 20000;
constexpr int kStatements = 50;   // at a time
constexpr int kMostStalls = 100;  // without a statement begun
constexpr std::uint64_t kPasses = 2;
constexpr int kPathSamples = 40;

/// What the program takes for its cell.
class Stage : public program::Host {
 public:
  Stage(Cell& cell, bool with_paths) : cell_(cell), moves_(*cell.program_moves()), with_paths_(with_paths) {
    for (const auto& robot : cell.robots()) arms_.push_back({robot.get(), robot->start, {}, nullptr, false});
  }

  const data::Value* find(std::string_view name) const override {
    const data::Value* value = cell_.store().find(name);
    const data::Point* point = value ? value->as_point() : nullptr;
    if (!point || point->frame().empty()) return value;
    data::Value& out = in_world_[std::string(name)];
    out = moves_.in_world(*point);
    return &out;
  }
  std::vector<std::string> names() const override { return cell_.store().names(); }
  void set(const std::string& name, data::Value value, const Location&) override {
    cell_.store().set(name, std::move(value), "check");
  }
  std::uint64_t data_version() const override { return cell_.store().version(); }

  program::Handle start_move(const program::Move& move, const Location& where) override {
    if (move.of_base()) return 1;
    try {
      queue(moves_.prepare(is_relative(move) ? from_now(move) : move, where), where);
    } catch (const Error& e) {
      tell(e.problems().front(), where);
    }
    return 1;
  }
  program::Progress poll_move(program::Handle) override { return arrive(); }
  bool room_for_move(const std::string&) override { return true; }
  program::Handle start_arrival(const std::string&) override {
    arrive();
    return 1;
  }
  void end_move(program::Handle, const Location&) override {}
  program::Travel travel(program::Handle) const override {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    return {kFar, 0, std::numeric_limits<Nanoseconds>::max(), 0};
  }
  data::Value here(const std::string& robot, const std::string& tool,
                   const std::string& frame) const override {
    return moves_.here_at(robot, tool, frame, [this](std::size_t arm) { return arms_[arm].at; });
  }
  program::Handle start_load(const std::string&, program::LoadForm, const Location&) override { return 1; }
  program::Progress poll_load(program::Handle) override { return program::Progress::done(); }
  program::Handle start_ask(const std::string&, const Location&) override { return 1; }
  program::Progress poll_ask(program::Handle) override { return program::Progress::done(); }
  Nanoseconds now() const override { return now_; }
  void hold(const std::string&, const Location&) override {}
  void log(const std::string&, const Location&) override {}

  void wait_until(Nanoseconds time) { now_ = std::max(now_ + 1'000'000, time); }
  /// Turns a boolean over, for a wait that reads it. False where there is none of that name.
  bool turn_over(const std::string& name) {
    const data::Value* value = find(name);
    const bool* now = value ? value->as_boolean() : nullptr;
    if (!now) return false;
    helped_ = true;
    set(name, data::Value(!*now), {});
    return true;
  }
  /// The program has failed with the values that there are. A person, a link or the PLC may have set others
  /// by then, so this is a warning; what the program raises itself is meant.
  void tell_failure(const program::TaskStatus& status) {
    out_.reached = status.where;
    const std::vector<std::string> own = {"user",    "expect",   "timeout",     "ended",       "discarded",
                                          "refused", "no-robot", "unreachable", "nobody-there"};
    if (!status.problem || std::find(own.begin(), own.end(), status.problem->code) != own.end()) return;
    Problem problem = *status.problem;
    problem.severity = Severity::warning;
    out_.problems.add(std::move(problem));
  }
  bool enough() const { return out_.moves >= kMostMoves; }
  Rehearsal& result() { return out_; }

 private:
  struct Arm {
    const CellRobot* robot;
    std::vector<double> at;  ///< after all moves planned so far
    std::vector<std::pair<moves::Move, Location>> waiting;
    std::shared_ptr<const moves::RobotFacts> with;
    bool lost;  ///< nobody knows where it is
  };

  /// Where a move leads that says by how much.
  program::Move from_now(const program::Move& move) {
    arrive();
    data::Point place = *here(move.robot, move.tool, move.frame_pose ? std::string{} : move.frame).as_point();
    if (move.frame_pose) place.pose = inverse(*move.frame_pose) * place.pose;
    const auto named = [&](const Arm& arm) {
      return move.robot.empty() || arm.robot->entry.name == move.robot;
    };
    const auto arm = std::find_if(arms_.begin(), arms_.end(), named);  // here() has found it
    return from_here(move, place, *arm->robot, arm->at);
  }

  program::Progress arrive() {
    for (Arm& arm : arms_) plan(arm);
    return program::Progress::done();
  }

  void queue(ProgramMoves::Prepared move, const Location& where) {
    Arm& arm = arms_[move.arm];
    if (arm.with != move.with) plan(arm);
    arm.with = move.with;
    for (moves::Move& one : move.moves) {
      arm.waiting.push_back({std::move(one), where});
      if (arm.waiting.back().first.blend <= 0) plan(arm);
    }
  }

  void plan(Arm& arm) {
    while (!arm.waiting.empty()) {
      if (arm.lost) {
        find_again(arm);
        continue;
      }
      std::vector<moves::Move> moves;
      for (const auto& [move, where] : arm.waiting) moves.push_back(move);
      const moves::RobotFacts& facts = arm.with ? *arm.with : *arm.robot->facts;
      try {
        moves::MovePlan plan = moves::plan_moves(facts, arm.at, moves, cell_.plan_options());
        if (with_paths_) keep_paths(arm, facts, plan);
        arm.at = std::move(plan.end);
        tell_where(arm);
        out_.moves += moves.size();
        arm.waiting.clear();
      } catch (const moves::MoveError& e) {
        tell(e.problems().front(), arm.waiting[e.move].second);
        arm.lost = true;
        out_.moves += e.move + 1;
        arm.waiting.erase(arm.waiting.begin(),
                          std::next(arm.waiting.begin(), static_cast<std::ptrdiff_t>(e.move)));
      }
    }
  }

  void keep_paths(const Arm& arm, const moves::RobotFacts& facts, const moves::MovePlan& plan) {
    std::vector<double> q(arm.at.size());
    for (const moves::PlannedMotion& motion : plan.motions) {
      RehearsedPath kept{arm.robot->entry.name, arm.waiting[motion.first].second, motion.path.duration(), {}};
      std::size_t hint = 0;
      for (int k = 0; k <= kPathSamples; ++k) {
        motion.path.sample(kept.seconds * k / kPathSamples, q, {}, {}, {}, hint);
        kept.tcp.push_back(facts.chain.forward(q).position);
      }
      out_.paths.push_back(std::move(kept));
    }
  }

  /// After a move that cannot be made: as if it had arrived some other way, if its end can be reached at all.
  void find_again(Arm& arm) {
    const moves::MoveTarget end = arm.waiting.front().first.end();
    arm.waiting.erase(arm.waiting.begin());
    const moves::RobotFacts& facts = arm.with ? *arm.with : *arm.robot->facts;
    try {
      if (const auto* joints = std::get_if<std::vector<double>>(&end.at)) {
        moves::check_joints(facts, *joints, end.name);
        arm.at = *joints;
      } else {
        arm.at = moves::joints_for(facts, std::get<Pose>(end.at), arm.at, end.name);
      }
      arm.lost = false;
      tell_where(arm);
    } catch (const Error&) {  // from the next that can
    }
  }

  /// What hangs on the robot goes with it.
  void tell_where(const Arm& arm) {
    const auto index = static_cast<std::size_t>(&arm - arms_.data());
    if (cell_.motion(index)) cell_.motion(index)->set_planned(arm.at);
  }

  void tell(Problem problem, const Location& where) {
    if (problem.where.file.empty()) problem.where = where;
    if (!told_.insert({problem.where.text(), problem.code}).second) return;
    if (helped_) problem.severity = Severity::warning;
    out_.problems.add(std::move(problem));
  }

  Cell& cell_;
  ProgramMoves& moves_;
  std::vector<Arm> arms_;
  Nanoseconds now_ = 0;
  bool helped_ = false, with_paths_ = false;
  std::set<std::pair<std::string, std::string>> told_;
  mutable std::map<std::string, data::Value, std::less<>> in_world_;  ///< of points that name a frame
  Rehearsal out_;
};

/// Helps tasks that wait. One thing at a time, so that what waits for one of two sees one of them.
class Prompter {
 public:
  explicit Prompter(Stage& stage) : stage_(stage) {}
  /// False where nothing helps.
  bool help(const std::vector<program::TaskStatus>& tasks) {
    for (const program::TaskStatus& task : tasks) {
      if (task.state != program::TaskState::waiting) continue;
      where_ = task.where;
      if (task.waiting.kind == program::WaitKind::time) {
        stage_.wait_until(task.waiting.until.value_or(0));
        return true;
      }
    }
    for (const program::TaskStatus& task : tasks) {
      if (task.state != program::TaskState::waiting) continue;
      const std::vector<std::string>& names = task.waiting.names;
      int& tried = tried_[task.where.text()];
      for (const int most = 2 * static_cast<int>(names.size()); tried < most;)
        if (stage_.turn_over(names[static_cast<std::size_t>(tried++) % names.size()])) return true;
    }
    stage_.wait_until(0);
    return ++stalls_ < kMostStalls;
  }
  void went_on() {
    stalls_ = 0;
    tried_.clear();
  }
  const Location& where() const { return where_; }

 private:
  Stage& stage_;
  std::map<std::string, int> tried_;
  int stalls_ = 0;
  Location where_;
};

}  // namespace

Rehearsal rehearse(Cell& cell, bool with_paths) {
  if (!cell.program() || !cell.program_moves()) return {};
  Stage stage(cell, with_paths);
  try {
    program::Interpreter interpreter(cell.program()->interpreter().compiled(), stage);
    interpreter.limit_passes(kPasses);
    Prompter prompter(stage);
    for (int step = 0;; ++step) {
      const program::StepResult result = interpreter.step(kStatements);
      if (result.state != program::TaskState::running && result.state != program::TaskState::waiting) {
        if (result.state == program::TaskState::failed) stage.tell_failure(interpreter.overview());
        break;
      }
      if (result.executed > 0)
        prompter.went_on();
      else if (!prompter.help(interpreter.status()))
        step = kMostSteps;
      if (step < kMostSteps && !stage.enough() && interpreter.overview().passes < kPasses) continue;
      if (interpreter.overview().passes < kPasses) stage.result().reached = interpreter.overview().where;
      break;
    }
    stage.start_arrival({});
  } catch (const Error&) {  // what else is wrong with it others tell
  }
  return std::move(stage.result());
}

}  // namespace polyarm::cell
