#include "polyarm/cell/rehearsal_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <variant>

#include "polyarm/inside/inside.hpp"
#include "polyarm/machine/open_names.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/setup/relative_moves.hpp"

namespace polyarm::cell {

namespace {
constexpr int kPathSamples = 40;

/// Positions of the TCP along a motion, at equal time steps, m.
std::vector<Vec3> places_of(const moves::RobotFacts& facts, const moves::PlannedMotion& motion) {
  std::vector<Vec3> out;
  std::vector<double> q(facts.chain.joints());
  std::size_t hint = 0;
  for (int k = 0; k <= kPathSamples; ++k) {
    motion.path.sample(motion.path.duration() * k / kPathSamples, q, {}, {}, {}, hint);
    out.push_back(facts.chain.forward(q).position);
  }
  return out;
}

/// Length of the TCP's path, m.
double length_of(const moves::RobotFacts& facts, const moves::PlannedMotion& motion) {
  const std::vector<Vec3> places = places_of(facts, motion);
  double out = 0;
  for (std::size_t k = 1; k < places.size(); ++k) out += norm(places[k] - places[k - 1]);
  return out;
}
}  // namespace

Stage::Stage(CellInside& cell, const program::Program& program, const program::Program* others,
             ProgramMoves* moves, bool with_paths)
    : cell_(cell),
      program_(program),
      moves_(moves),
      open_(open_names(cell.data, others)),
      with_paths_(with_paths) {
  for (const auto& robot : cell.setup.robots)
    arms_.push_back({robot.get(), robot->start, {}, nullptr, false, {}});
  for (std::size_t i = 0; i < arms_.size(); ++i)
    arms_[i].base = cell.setup.robots[i]->entry.base * cell.motions->base(i).tracked();
  for (const Arm& arm : arms_) report_where(arm);
}

Stage::~Stage() {
  if (moves_) moves_->set_busy({});
  if (moves_ && moves_->belts()) moves_->belts()->forget_supposed();
  for (auto& [name, value] : before_) cell_.data.store.set(name, std::move(value), "check");
}

void Stage::suppose(const Supposition& supposed) {
  if (supposed.kept) help(supposed.kept->first, supposed.kept->second);
  supposed_ = supposed;
}

const data::Value* Stage::find(std::string_view name) const {
  if (supposed_.kept && supposed_.kept->first == name) return &supposed_.kept->second;
  const data::Value* value = cell_.data.store.find(name);
  const data::Point* point = value ? value->as_point() : nullptr;
  if (!point || !moves_ || point->frame().empty()) return value;
  data::Value& out = in_world_[std::string(name)];
  out = moves_->in_world(*point);
  return &out;
}

void Stage::set(const std::string& name, data::Value value, const Location& where) {
  if (where.line > 0) fail_as_supposed(where);
  if (const data::Value* now = cell_.data.store.find(name)) before_.try_emplace(name, *now);
  cell_.data.store.set(name, std::move(value), "check");
}

program::Handle Stage::start_move(const program::Move& move, const Location& where) {
  ++events_;
  if (!moves_) throw Error(Problem{"no-robot", where, "a PLC's script moves no robot", {}});
  fail_as_supposed(where);
  const Asked asked{where, calls_at(where), move.called, interpreter_->handler()};
  try {
    if (move.of_base())
      drive(move, asked);
    else
      queue(prepare(move, where), asked);
  } catch (const Error& e) {
    tell(e.problems().front(), asked, values_known(asked));
  }
  raise_pending();
  return 1;
}

/// A trap springs between two moves here, because moves take no time.
program::Handle Stage::suspend(const std::vector<std::string>&) {
  arrive();
  held_.clear();
  for (const Arm& arm : arms_) held_.push_back(arm.at);
  return 1;
}

program::Handle Stage::resume(const std::vector<std::string>&) {
  arrive();
  for (std::size_t i = 0; i < held_.size(); ++i) arms_[i].at = held_[i];
  return 1;
}

program::Progress Stage::poll_move(program::Handle) {
  have_arrived();
  if (!pending_) return program::Progress::done();
  return program::Progress::failed(*std::exchange(pending_, std::nullopt));
}

program::Handle Stage::start_load(const std::string&, program::LoadForm, const Location& where) {
  fail_as_supposed(where);
  return 1;
}

program::Handle Stage::start_ask(const std::string& text, const Location& where) {
  asked_ = answer_name(where);
  requested_text_ = text;
  return 1;
}

/// The answer to the last question: Enter's default unless another answer is supposed.
std::string Stage::answer(const data::Value& usual) const {
  questions_.try_emplace(asked_, Question{requested_text_, usual});
  if (!supposed_.answer || supposed_.answer->first != asked_) return {};
  const data::Value& value = supposed_.answer->second;
  const data::Number *number = value.as_number(), *like = usual.as_number();
  if (value.kind() != usual.kind() || (number && like && number->dimension != like->dimension)) return {};
  if (const bool* boolean = value.as_boolean()) return *boolean ? "yes" : "no";
  return value.text();
}

/// Raises the supposed error once, in the `try` that is supposed to fail.
void Stage::fail_as_supposed(const Location& where) {
  if (supposed_.fails.empty() || has_failed_ || !interpreter_) return;
  const std::optional<Location> handler = interpreter_->handler();
  if (!handler || handler->text() != supposed_.fails) return;
  has_failed_ = true;
  throw Error(Problem{"refused", where, "the rehearsal supposes that this line fails", {}});
}

void Stage::raise_pending() {
  if (pending_) throw Error(*std::exchange(pending_, std::nullopt));
}

program::Handle Stage::start_arrival(const std::string&) {
  have_arrived();
  return 1;
}

program::Travel Stage::travel(program::Handle) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  return {kFar, 0, std::numeric_limits<Nanoseconds>::max(), 0};
}

data::Value Stage::here(const std::string& robot, const std::string& tool, const std::string& frame) const {
  if (const auto base = moves_of_program().only_base(robot))
    return moves_->place_in(arms_[*base].base, *base, frame);
  return moves_of_program().here_at(robot, tool, frame, [this](std::size_t arm) { return joints_now(arm); });
}

ProgramMoves& Stage::moves_of_program() const {
  if (!moves_) throw Error("no-robot", "a PLC's script moves no robot");
  return *moves_;
}

std::vector<double> Stage::joints_now(std::size_t arm) const {
  const Location last = arms_[arm].went.empty() ? Location{} : arms_[arm].went.back().asked.where;
  if (!helped_.empty() || supposed_met_) here_known_ = here_known_ && start_known(arms_[arm].went, last);
  return arms_[arm].at;
}

data::JointState Stage::here_joints(const std::string& robot) const {
  return moves_of_program().here_joints(robot, [this](std::size_t arm) { return joints_now(arm); });
}

data::JointState Stage::joints_at(const data::Value& place, const data::JointState* near, const std::string& robot,
                                  const std::string& tool, const std::string& frame) const {
  return moves_of_program().joints_at(place, near, robot, tool, frame,
                                      [this](std::size_t arm) { return joints_now(arm); });
}

data::Value Stage::pose_at(const data::JointState& joints, const std::string& robot, const std::string& tool,
                           const std::string& frame) const {
  return moves_of_program().pose_at(joints, robot, tool, frame);
}

data::List Stage::rows_of(const std::string& file) {
  return rows_in(cell_.setup.file.folder, file);
}

bool Stage::supposes_met(const Location& where, bool has_else) {
  const bool met = has_else != (supposed_.until == where.text());
  if (!met) return false;
  supposed_met_ = true;
  arrive();
  for (Arm& arm : arms_)
    if (!arm.went.empty() && arm.went.back().asked.where.text() == where.text())
      arm.went.back().guessed = true;
  return true;
}

std::uint64_t Stage::seed() const {
  return cell_.setup.file.seed;
}

void Stage::wait_until(Nanoseconds time) {
  now_ = std::max(now_ + 1'000'000, time);
  ++events_;
}

void Stage::help(const std::string& name, const data::Value& value) {
  ++events_;
  if (helped_.insert(name).second) certainty_.reset();
  set(name, value, {});
}

namespace {
/// Errors of a program that a rehearsal causes itself, or that tell() has reported.
bool is_of_rehearsal(const std::string& code) {
  constexpr std::array kCodes = {"user",    "expect",   "timeout",     "ended",       "discarded",
                                 "refused", "no-robot", "unreachable", "nobody-there"};
  return std::find(kCodes.begin(), kCodes.end(), code) != kCodes.end();
}
}  // namespace

/// A value that is wrong in every run, in a `try`: a warning, unless the handler passes the error on.
void Stage::caught(const Problem& problem) {
  const std::optional<Location> handler = interpreter_->handler();
  if (!handler || is_of_rehearsal(problem.code) || problem.code == "no-table") return;
  const bool told = std::any_of(caught_.begin(), caught_.end(), [&](const Caught& each) {
    return each.problem.where.text() == problem.where.text() && problem.what.starts_with(each.raised);
  });
  if (told) return;
  const bool known =
      of_cell_.contains(problem.what) || values_known({problem.where, calls_at(problem.where), {}, {}});
  if (!known || !announced_.insert({problem.where.text(), problem.code}).second) return;
  caught_.push_back({problem, problem.what, *handler});
}

void Stage::report_failure(const program::TaskStatus& status) {
  out_.reached = status.where;
  if (status.problem && report_passed_on(*status.problem)) return;
  if (!status.problem) return;
  if (is_raised_in_every_run(*status.problem)) return out_.problems.add(*status.problem);
  if (is_of_rehearsal(status.problem->code)) return;
  Problem problem = *status.problem;
  bool known = of_cell_.contains(problem.what) || values_known({status.where, calls_at(status.where), {}});
  if (problem.code == "no-table") known = false;  // another program may write it before the run
  if (problem.code == "too-deep") known = known && certainty().conditions_known();
  if (supposed_.kept && !known) {
    if (supposed_.only_tried || problem.code != "zero") return;
    problem.advice = "this happens when '" + supposed_.kept->first + "' is " + supposed_.kept->second.text() +
                     ": test it before";
  }
  if (supposed_.answer && !known)
    problem.advice = "this happens with the answer " + supposed_.answer->second.text() + " to '" +
                     questions_[supposed_.answer->first].text + "': test it before";
  problem.severity = known ? Severity::error : Severity::warning;
  out_.problems.add(std::move(problem));
}

/// True for an error from a `raise` that does not depend on what others set. `expect` and the `else` of an
/// `until` depend on measurements, which a rehearsal does not have.
bool Stage::is_raised_in_every_run(const Problem& problem) const {
  if (problem.code != "user" || supposes() || supposed_.kept || !supposed_.late.empty()) return false;
  bool measures = false;
  program::for_each_statement(program_.statements, [&](const program::Statement& s) {
    measures = measures || s.kind == program::Statement::Kind::expect ||
               std::any_of(s.clauses.begin(), s.clauses.end(), [](const program::Clause& c) { return c.has_else; });
  });
  return !measures && questions_.empty() && here_known_ && certainty().conditions_known();
}

void Stage::report_endless(const Location& where, int statements) {
  out_.problems.warning("busy-loop", where,
                        "the program neither waits nor moves here: it was followed for " +
                            std::to_string(statements) + " statements",
                        "a loop that waits for something needs `wait CONDITION`, or `wait 10ms`");
}

/// Converts a relative move into an absolute one.
program::Move Stage::from_now(const program::Move& move) {
  arrive();
  data::Point place = *here(move.robot, move.tool, move.named_frame()).as_point();
  if (move.frame_pose) place.pose = inverse(*move.frame_pose) * place.pose;
  const auto named = [&](const Arm& arm) {
    return move.robot.empty() || arm.robot->entry.name == move.robot;
  };
  const auto arm = std::find_if(arms_.begin(), arms_.end(), named);  // always found: here() has checked it
  return from_here(move, place, *arm->robot, arm->at);
}

void Stage::arrive() {
  for (Arm& arm : arms_) plan(arm);
}

void Stage::have_arrived() {
  arrive();
  for (Arm& arm : arms_) arm.busy = false;
}

/// As in a run, a frame on a robot with pending moves is an error.
ProgramMoves::Prepared Stage::prepare(const program::Move& move, const Location& where) {
  const program::Move absolute = is_relative(move) ? from_now(move) : move;
  moves_->set_busy([this](std::size_t arm) { return arms_[arm].busy; });
  try {
    ProgramMoves::Prepared out = moves_->prepare(absolute, where);
    moves_->set_busy([](std::size_t) { return false; });
    return out;
  } catch (const Error&) {
    moves_->set_busy([](std::size_t) { return false; });
    throw;
  }
}

void Stage::queue(ProgramMoves::Prepared move, const Asked& asked) {
  Arm& arm = arms_[move.arm];
  arm.busy = true;
  if (arm.with != move.with) plan(arm);
  arm.with = move.with;
  for (moves::Move& one : move.moves) {
    if (moves::bends(one)) plan(arm);  // it is planned alone
    arm.waiting.push_back({std::move(one), asked});
    if (arm.waiting.back().first.blend <= 0 || moves::bends(arm.waiting.back().first)) plan(arm);
  }
}

void Stage::plan(Arm& arm) {
  while (!arm.waiting.empty()) {
    if (arm.lost) {
      find_again(arm);
      continue;
    }
    std::vector<moves::Move> moves;
    for (const auto& [move, asked] : arm.waiting) moves.push_back(move);
    const moves::RobotFacts& facts = arm.with ? *arm.with : *arm.robot->facts;
    try {
      moves::MovePlan plan = moves::plan_moves_around(facts, arm.at, moves, obstacles(arm, moves).get(),
                                                      cell_.motions->plan_options());
      if (with_paths_) keep_paths(arm, facts, plan);
      for (const moves::MovePlan::Warning& warning : plan.warnings)
        tell(warning.problem, arm.waiting[warning.move].second, true);
      for (const moves::PlannedMotion& motion : plan.motions) check_on_the_way(arm, facts, motion);
      arm.at = std::move(plan.end);
      report_where(arm);
      out_.moves += moves.size();
      note_made(arm, moves.size());
    } catch (const moves::MoveError& e) {
      out_.moves += e.move + 1;
      const std::vector<double> before = end_of(arm, e.move);
      note_made(arm, e.move);
      const auto& [move, asked] = arm.waiting.front();
      tell(e.problems().front(), asked,
           values_known(asked) && (is_out_of_reach(arm, move) || start_known(arm.went, asked.where)));
      if (pending_) return stay(arm, before);
      arm.lost = true;
    }
  }
}

/// Null where no move goes around obstacles.
std::shared_ptr<moves::Obstacles> Stage::obstacles(const Arm& arm, const std::vector<moves::Move>& moves) {
  if (std::none_of(moves.begin(), moves.end(), [](const moves::Move& move) { return move.around; }))
    return nullptr;
  AroundOptions options;
  options.clearance = cell_.setup.file.clearance;
  return obstacles_around(fixed_bodies(), moment(), static_cast<std::size_t>(&arm - arms_.data()), options);
}

/// What a move sets on its way, by length or time, is set between its ends.
void Stage::check_on_the_way(const Arm& arm, const moves::RobotFacts& facts,
                             const moves::PlannedMotion& motion) {
  const Asked& asked = arm.waiting[motion.first].second;
  const program::Statement* s =
      motion.first == motion.last ? program::statement_at(program_, asked.where) : nullptr;
  if (!s || s->arguments.size() != 1) return;
  for (const program::Clause& clause : s->clauses) {
    const data::Number* away =
        clause.kind == program::Clause::Kind::at && clause.value ? clause.value->value.as_number() : nullptr;
    if (!away) continue;
    const bool time = away->dimension == Dimension::time;
    const double whole = time ? motion.path.duration() : length_of(facts, motion);
    if (away->value <= whole * 1.001) continue;
    Problem problem{"at-outside", program_.at(clause.place),
                    "the move " + std::string(time ? "takes " : "is ") +
                        data::Value(data::Number{std::round(whole * 1000) / 1000, away->dimension}).text() +
                        (time ? "" : " long") + ": '" + clause.target + "' is set where it " +
                        (clause.from_end ? "begins" : "ends"),
                    time ? "give a shorter time" : "give a shorter length", Severity::warning};
    tell(std::move(problem), asked, true);
  }
}

void Stage::keep_paths(const Arm& arm, const moves::RobotFacts& facts, const moves::MovePlan& plan) {
  for (const moves::PlannedMotion& motion : plan.motions)
    out_.paths.push_back({arm.robot->entry.name, arm.waiting[motion.first].second.where,
                          motion.path.duration(), places_of(facts, motion)});
}

/// Records the first `count` waiting moves as made.
void Stage::note_made(Arm& arm, std::size_t count) {
  const auto end = std::next(arm.waiting.begin(), static_cast<std::ptrdiff_t>(count));
  for (auto at = arm.waiting.begin(); at != end; ++at)
    arm.went.push_back({at->second, std::holds_alternative<std::vector<double>>(at->first.end().at)});
  arm.waiting.erase(arm.waiting.begin(), end);
}

/// Joints after the first `count` waiting moves.
std::vector<double> Stage::end_of(const Arm& arm, std::size_t count) {
  std::vector<double> out = arm.at;
  try {
    for (std::size_t i = 0; i < count; ++i) out = joints_at(arm, arm.waiting[i].first.end(), out);
  } catch (const Error&) {  // use the last reachable end
  }
  return out;
}

/// A move fails and the program catches the error: the robot stays at the end of the move before it, and the
/// queued moves are discarded.
void Stage::stay(Arm& arm, std::vector<double> at) {
  arm.at = std::move(at);
  report_where(arm);
  arm.went.push_back({arm.waiting.front().second, false, true});
  arm.waiting.clear();
}

/// After a move that cannot be made: continue from its end, if that end can be reached at all.
void Stage::find_again(Arm& arm) {
  const auto [move, asked] = std::move(arm.waiting.front());
  arm.waiting.erase(arm.waiting.begin());
  arm.went.push_back({asked, false, true});
  try {
    arm.at = joints_at(arm, move.end(), arm.at);
    arm.lost = false;
    report_where(arm);
  } catch (const Error&) {  // continue with the next move that can be reached
  }
}

std::vector<double> Stage::joints_at(const Arm& arm, const moves::MoveTarget& end,
                                     const std::vector<double>& seed) {
  const moves::RobotFacts& facts = arm.with ? *arm.with : *arm.robot->facts;
  const auto* joints = std::get_if<std::vector<double>>(&end.at);
  if (!joints) return moves::joints_for(facts, std::get<Pose>(end.at), seed, end.name);
  moves::check_joints(facts, *joints, end.name);
  return *joints;
}

/// True if the end of the move cannot be reached from any start.
bool Stage::is_out_of_reach(const Arm& arm, const moves::Move& move) {
  try {
    joints_at(arm, move.end(), arm.robot->facts->home);
    return false;
  } catch (const Error&) {
    return true;
  }
}

/// True if the move at `where` begins at the same place in every run that reaches it.
bool Stage::start_known(const std::vector<Went>& made, Location where) const {
  for (auto went = made.rbegin(); went != made.rend(); ++went) {
    const Location& from = went->asked.where;
    if (went->guessed || !values_known(went->asked) || !certainty().follows(from, where)) return false;
    if (went->to_joints) return true;
    where = from;
  }
  return certainty().follows({}, where);
}

bool Stage::values_known(const Asked& asked) const {
  return here_known_ && certainty().values_known(asked.calls);
}

/// The calls that lead to this line, then the line itself, for the task that executes it.
std::vector<Location> Stage::calls_at(const Location& where) const {
  for (const program::TaskStatus& task : interpreter_->status()) {
    std::vector<Location> calls = interpreter_->calls(task.name);
    if (calls.empty() || calls.back().line != where.line || calls.back().file != where.file) continue;
    calls.back() = where;
    return calls;
  }
  return {where};
}

const program::Certainty& Stage::certainty() const {
  if (!certainty_) {
    std::set<std::string> open = open_;
    open.insert(helped_.begin(), helped_.end());
    certainty_.emplace(program_, std::move(open));
  }
  return *certainty_;
}

/// Updates the planned joints, so parts attached to the robot move with it.
void Stage::report_where(const Arm& arm) {
  const auto index = static_cast<std::size_t>(&arm - arms_.data());
  if (cell_.motions->motion(index)) cell_.motions->motion(index)->set_planned(arm.at);
}

/// Reports a problem of a move. `known`: the move fails in every run that reaches it.
void Stage::tell(Problem problem, const Asked& asked, bool known) {
  if (problem.where.file.empty()) problem.where = asked.where;
  const bool is_caught = asked.handler && problem.severity == Severity::error;
  if (is_caught && (known || !supposes())) pending_ = problem;
  const std::string raised = problem.what;
  problem.what += asked.called;
  if (!announced_.insert({problem.where.text(), problem.code}).second) return;
  if (supposes() && !known) problem.severity = Severity::warning;
  if (is_caught)
    caught_.push_back({std::move(problem), raised, *asked.handler});
  else
    out_.problems.add(std::move(problem));
}

/// True if the program fails with an error that it caught before and raised again unhandled.
bool Stage::report_passed_on(const Problem& problem) {
  const auto at = std::find_if(caught_.begin(), caught_.end(), [&](const Caught& caught) {
    return caught.problem.where.line == problem.where.line &&
           caught.problem.where.file == problem.where.file && problem.what.starts_with(caught.raised);
  });
  if (at == caught_.end()) return false;
  at->problem.advice = "the 'on error' in line " + std::to_string(at->handler.line) + " passes this error on";
  out_.problems.add(std::move(at->problem));
  caught_.erase(at);
  return true;
}

Rehearsal Stage::take_result() {
  for (Caught& caught : caught_) {
    caught.problem.severity = Severity::warning;
    caught.problem.what += "; handled in line " + std::to_string(caught.handler.line);
    out_.problems.add(std::move(caught.problem));
  }
  caught_.clear();
  return std::move(out_);
}

std::vector<std::string> Stage::names() const {
  return cell_.data.store.names();
}

std::uint64_t Stage::data_version() const {
  return cell_.data.store.version();
}

}  // namespace polyarm::cell
