#include "polyarm/moves/robot_motion.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "polyarm/base/bounds.hpp"
#include "polyarm/moves/forward_plan.hpp"

namespace polyarm::moves {

static_assert(RobotMotion::kMostAhead == bounds::kMovesAhead);
static_assert(RobotMotion::kSecondsAhead == bounds::kSecondsAhead);

namespace {
/// Number of outcomes of discarded moves that are kept for queries.
constexpr std::size_t kMostKept = 4 * RobotMotion::kMostWaiting;
/// Synchronised moves of several robots begin this long after the last of them is ready, because the other
/// robots are handled in the next tick.
constexpr Nanoseconds kInStepAhead = 10'000'000;

/// True if the next move continues on the same path.
bool keeps_going(const Move& move) {
  return move.blend > 0 || move.through;
}
void end_here(Move& move) {
  move.blend = 0;
  move.through = false;
}

/// s into the motion with this goal: 0 until the controller has begun it, as its status is that of the goal
/// before.
double time_of(const controllers::GoalStatus& status, std::uint64_t goal) {
  const bool begun = status.active.load(std::memory_order_acquire) == goal ||
                     status.finished.load(std::memory_order_acquire) >= goal;
  return begun ? status.time.load(std::memory_order_relaxed) : 0;
}

/// A joint move that is not faster than `move`, and goes around obstacles if it does.
Move paced_like(const Move& move) {
  Move out;
  out.around = move.around;
  out.speed = move.speed, out.acceleration = move.acceleration;
  out.tcp_speed = move.tcp_speed, out.tcp_acceleration = move.tcp_acceleration;
  out.joint_speed = move.joint_speed > 0 ? move.joint_speed : move.turn_speed;
  out.joint_acceleration = move.joint_acceleration > 0 ? move.joint_acceleration : move.turn_acceleration;
  out.joint_pace = move.joint_pace;
  return out;
}
}  // namespace

RobotMotion::RobotMotion(const RobotFacts& robot, controllers::JointTrajectoryController& controller,
                         Post post)
    : robot_(robot),
      controller_(controller),
      post_(std::move(post)),
      ride_(std::make_shared<FrameRide>(robot.chain, robot.limits)),
      comply_(std::make_shared<Compliance>(*robot.model, robot.chain, robot.limits)) {
  struct Both : EitherShift {  // the controller may outlive this object
    Both(std::shared_ptr<FrameRide> ride, std::shared_ptr<Compliance> comply)
        : EitherShift(*ride, *comply), ride_(std::move(ride)), comply_(std::move(comply)) {}
    std::shared_ptr<FrameRide> ride_;
    std::shared_ptr<Compliance> comply_;
  };
  controller_.set_shift(std::make_shared<Both>(ride_, comply_));
}

std::uint64_t RobotMotion::queue(Move move, std::shared_ptr<const RobotFacts> with,
                                 std::shared_ptr<InStep> step) {
  if (waiting_.size() >= kMostWaiting)
    throw Error("busy", "too many moves of " + robot_.name + " wait for being carried out",
                "is the loop running?");
  if (measured_) {
    if (auto no = refuse_forward(move, robot_.name)) throw Error(std::move(*no));
    if (step)
      throw Error(
          "forward-mode",
          "'" + robot_.name + "' has `motion: forward`, and its controller cannot move in step with others",
          "write these moves outside of `together`, or set `motion: stream`");
  }
  if (find_obstacles_ && bends(move)) end_here(move);
  if (!waiting_.empty() &&
      (step != waiting_.back().step || waiting_.back().with != with || (find_obstacles_ && bends(move))))
    end_here(waiting_.back().move);
  back_ = paced_like(move);
  waiting_.push_back({++last_id_, std::move(move), std::move(with), std::move(step)});
  return last_id_;
}

void RobotMotion::close() {
  if (!waiting_.empty()) end_here(waiting_.back().move);
}

void RobotMotion::tick(Nanoseconds now) {
  watch();
  look_at_ride();
  look_at_compliance();
  look_at_return();
  collect();
  plan();
  collect();
  hand_over(now);
  if (!apart_ && at_end()) settled_ = last_id_;
}

bool RobotMotion::idle() const {
  return !apart_ && !riding_ && !complying_ && at_end();
}

bool RobotMotion::is_far_ahead() const {
  if (ready_.size() < 2) return false;
  double seconds = 0;
  for (const Ready& ready : ready_)
    if ((seconds += ready.motion.path.duration()) > kSecondsAhead) return true;
  return false;
}

/// Plans the waiting moves, from the end of the moves before them, up to the first move that does not blend
/// into the next.
void RobotMotion::plan() {
  if (job_ || waiting_.empty()) return;
  // It is not known yet where the robot will stand.
  if (goal_ != 0 && active_.ends->load(std::memory_order_relaxed)) return;
  const bool alone = find_obstacles_ && bends(waiting_.front().move);
  if (alone && (goal_ != 0 || !ready_.empty())) return;  // what is around it may still change
  auto last =
      std::find_if(waiting_.begin(), waiting_.end(), [](const Waiting& w) { return !keeps_going(w.move); });
  if (const auto& step = waiting_.front().step)  // plans all moves of the step together; they stop where the
                                                 // moves require it
    last = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& w) { return w.step != step; });
  else if (last == waiting_.end() && waiting_.size() < kMostWaiting)
    return;
  else if (last != waiting_.end())
    ++last;
  if (alone) last = waiting_.begin() + 1;
  job_ = std::make_shared<Job>();
  job_->first_id = waiting_.front().id;
  job_->with = waiting_.front().with;
  job_->step = waiting_.front().step;
  job_->from = planned_;
  job_->options = options_;
  job_->period = controller_.period();
  job_->forward = forward();
  for (auto w = waiting_.begin(); w != last; ++w) job_->moves.push_back(std::move(w->move));
  waiting_.erase(waiting_.begin(), last);
  if (find_obstacles_ &&
      std::any_of(job_->moves.begin(), job_->moves.end(), [](const Move& m) { return m.around; }))
    job_->obstacles = find_obstacles_();
  post_([job = job_, &robot = facts(job_->with)] {
    try {
      job->plan = plan_moves_around(robot, job->from, job->moves, job->obstacles.get(), job->options);
      for (const PlannedMotion& motion : job->plan.motions)
        if (job->forward)
          job->forwards.push_back(forward_motion(robot, job->moves, motion, 0, job->options.tcp_ceiling));
        else
          job->followers.push_back(
              std::make_unique<timing::PathFollower>(motion.path, job->plan.limits, job->period));
    } catch (const MoveError& why) {
      job->failure = why.problems().front();
      job->failed = why.move;
    } catch (const std::exception& why) {
      job->failure =
          Problem{"not-planned", {}, std::string("a move could not be planned: ") + why.what(), {}};
    }
    job->done.store(true, std::memory_order_release);
  });
}

void RobotMotion::collect() {
  if (!job_ || !job_->done.load(std::memory_order_acquire)) return;
  const std::shared_ptr<Job> job = std::exchange(job_, nullptr);
  if (job->failure) {
    const std::uint64_t failed = job->first_id + job->failed;
    if (job->step) job->step->failed_ = true;
    waiting_.clear();
    end_badly(job->first_id, MoveState::discarded);
    ended_badly_[failed] = MoveState::failed;
    problems_[failed] = *job->failure;
    return;
  }
  const std::uint64_t last = job->first_id + job->moves.size() - 1;
  for (MovePlan::Warning& warning : job->plan.warnings)
    warnings_.push_back({job->first_id + warning.move, std::move(warning.problem)});
  planned_ = job->plan.end;
  if (job->step) {
    ++job->step->planned_;
    if (job->plan.motions.empty()) ++job->step->ready_;  // the robot is already at the end
    job->step->longest_ = std::max(job->step->longest_, job->plan.duration());
  }
  const double total = job->plan.duration();
  const auto moves =
      job->forward ? std::make_shared<const std::vector<Move>>(std::move(job->moves)) : nullptr;
  for (std::size_t i = 0; i < job->plan.motions.size(); ++i) {
    PlannedMotion& motion = job->plan.motions[i];
    Ready ready;
    ready.first_id = job->first_id + motion.first, ready.last_id = job->first_id + motion.last;
    ready.share = motion.path.duration() / total;
    ready.motion = std::move(motion);
    if (job->forward)
      ready.forward = std::move(job->forwards[i]);
    else
      ready.follower = std::move(job->followers[i]);
    ready.moves = moves;
    ready.with = job->with, ready.step = job->step;
    ready.leads = i == 0;
    ready.options = job->options;
    ready.limits = job->plan.limits;
    ready_.push_back(std::move(ready));
  }
  // Moves of zero length finish together with the moves before them.
  if (!ready_.empty())
    ready_.back().last_id = last;
  else if (goal_ != 0)
    active_.last_id = last;
  else
    settled_ = last;
}

/// True if the moves of all robots of the step are ready. Then stretches this robot's moves to the longest
/// duration.
bool RobotMotion::in_step(Ready& ready, Nanoseconds now) {
  InStep& step = *ready.step;
  if (step.failed_) {
    const std::uint64_t first = ready.first_id;
    planned_ = begin_of(ready);  // the robot has not left its place
    ready_.clear(), waiting_.clear();
    job_ = nullptr;
    end_badly(first, MoveState::discarded);
    return false;
  }
  if (ready.leads) {
    if (!std::exchange(ready.waits, true)) ++step.ready_;
    if (step.ready_ < step.members_) return false;
    if (step.start_ < 0) step.start_ = now + kInStepAhead;
  }
  timing::SpeedProfile profile = ready.motion.path.profile();
  const double wanted = step.longest_ * ready.share;
  if (wanted > profile.duration() * (1 + 1e-9)) {
    profile.stretch(wanted / profile.duration());
    ready.motion.path = timing::TimedPath(ready.motion.path.shared_path(), std::move(profile));
    const auto limits = ready.follower->limits();
    ready.follower = std::make_unique<timing::PathFollower>(
        ready.motion.path, std::vector(limits.begin(), limits.end()), controller_.period());
  }
  return true;
}

void RobotMotion::hand_over(Nanoseconds now) {
  if (goal_ != 0 || ready_.empty()) return;
  if (ready_.front().step && !in_step(ready_.front(), now)) return;
  auto goal = std::make_unique<controllers::TrajectoryGoal>();
  goal->id = controller_.new_goal_id();
  goal->planned = std::move(ready_.front().follower);
  goal->forward = std::move(ready_.front().forward);
  goal->ends = ready_.front().ends = std::make_shared<std::atomic<bool>>(false);
  goal->pace = ready_.front().pace = std::make_shared<std::atomic<double>>(1.0);
  if (ready_.front().step && ready_.front().leads) goal->start = ready_.front().step->start_;
  const std::uint64_t id = goal->id;
  if (!controller_.follow(goal)) {  // refused for now: try again in the next tick
    ready_.front().follower = std::move(goal->planned);
    ready_.front().forward = std::move(goal->forward);
    return;
  }
  goal_ = id;
  active_ = std::move(ready_.front());
  ready_.pop_front();
}

void RobotMotion::watch() {
  if (goal_ == 0) return;
  const controllers::GoalStatus& status = controller_.status();
  const bool refused = status.refused.load(std::memory_order_acquire) >= goal_;
  if (refused || status.discarded.load(std::memory_order_acquire) >= goal_) {
    goal_ = 0;
    job_ = nullptr;
    ready_.clear(), waiting_.clear();
    give_up_apart();
    end_badly(settled_ + 1, MoveState::discarded);
    if (refused) ended_badly_[active_.last_id] = MoveState::refused;
  } else if (status.finished.load(std::memory_order_acquire) >= goal_) {
    const bool ends = active_.ends->load(std::memory_order_relaxed);
    if (riding_ && !ends && !ride_->synchronised() && !ride_->over())
      return;  // not yet in its place in the frame
    goal_ = 0;
    if (apart_ && apart_->phase == Apart::Phase::stopping) {
      apart_->time = controller_.status().time.load(std::memory_order_relaxed);
      apart_->held = planned_ = place_of_stop(active_, apart_->time);
      apart_->phase = Apart::Phase::away;
      if (apart_->ending)
        apart_->settled = settled_ = active_.last_id;
      else
        apart_->active = std::move(active_);
      return;
    }
    settled_ = active_.last_id;
    if (active_.ends->load(std::memory_order_relaxed)) {  // stopped early: the next move begins where the
                                                          // robot stopped
      planned_ = place_of_stop(active_, status.time.load(std::memory_order_relaxed));
    }
  }
}

/// Where a motion that was ended early has stopped.
std::vector<double> RobotMotion::place_of_stop(const Ready& ready, double time) const {
  if (measured_) return measured_();  // the robot's controller rounds corners in its own way
  const timing::TimedPath& path = ready.motion.path;
  std::vector<double> out(path.joints());
  std::size_t hint = 0;
  path.sample(time, out, {}, {}, {}, hint);
  return out;
}

/// Readies a motion that was stopped at this time of its plan to be handed over again.
void RobotMotion::go_on_from(Ready& ready, double time) {
  if (ready.moves) {
    ready.forward =
        forward_motion(facts(ready.with), *ready.moves, ready.motion, time, ready.options.tcp_ceiling);
    return;
  }
  ready.follower =
      std::make_unique<timing::PathFollower>(ready.motion.path, ready.limits, controller_.period());
  ready.follower->start_at(time);
}

std::vector<double> RobotMotion::begin_of(const Ready& ready) {
  const timing::TimedPath& path = ready.motion.path;
  std::vector<double> out(path.joints());
  std::size_t hint = 0;
  path.sample(0, out, {}, {}, {}, hint);
  return out;
}

void RobotMotion::suspend() {
  if (apart_) return;
  return_failure_.reset();
  apart_.emplace();
  apart_->settled = settled_, apart_->last = last_id_;
  apart_->planned = planned_;
  if (goal_ != 0) {
    apart_->ending = active_.ends->exchange(true, std::memory_order_relaxed);
  } else {
    apart_->phase = Apart::Phase::away;
    if (!ready_.empty()) {  // not begun yet
      planned_ = begin_of(ready_.front());
    } else if (job_) {
      planned_ = job_->from;
    }
    apart_->held = planned_;
  }
  apart_->waiting = std::exchange(waiting_, {});
  apart_->job = std::exchange(job_, nullptr);
  apart_->ready = std::exchange(ready_, {});
}

void RobotMotion::resume() {
  if (!suspended() || apart_->phase == Apart::Phase::returning) return;
  apart_->phase = Apart::Phase::returning;
  if (planned_ == apart_->held) return;
  Move back = back_;
  back.targets = {{apart_->held, "the place where a trap stopped the robot"}};
  apart_->back = queue(std::move(back));
}

/// Takes the moves that were set apart up again when the robot is back in its place.
void RobotMotion::look_at_return() {
  if (!apart_ || apart_->phase != Apart::Phase::returning) return;
  if (apart_->back != 0 && ended_badly_.contains(apart_->back)) {
    const std::uint64_t first = apart_->settled + 1;
    const auto why = problem_of(apart_->back);
    give_up_apart();
    if (!why) return;
    return_failure_ = *why;
    ended_badly_[first] = MoveState::failed;
    problems_[first] = *why;
    return;
  }
  if (goal_ != 0 || job_ || !ready_.empty() || !waiting_.empty()) return;
  if (apart_->active) {
    go_on_from(*apart_->active, apart_->time);
    apart_->ready.push_front(std::move(*apart_->active));
  }
  waiting_ = std::move(apart_->waiting);
  job_ = std::move(apart_->job);
  ready_ = std::move(apart_->ready);
  planned_ = std::move(apart_->planned);
  settled_ = apart_->settled;
  apart_.reset();
}

void RobotMotion::give_up_apart() {
  if (!apart_) return;
  const std::uint64_t first = apart_->settled + 1, last = apart_->last;
  if (apart_->phase == Apart::Phase::returning)
    return_failure_ = Problem{"discarded", {}, "the way back to where a trap stopped the robot was discarded", {}};
  apart_.reset();
  for (std::uint64_t id = first; id <= last; ++id) ended_badly_.try_emplace(id, MoveState::discarded);
}

void RobotMotion::drop() {
  give_up_apart();
  waiting_.clear(), ready_.clear();
  job_ = nullptr;  // the result of that job is dropped
  end_badly((goal_ != 0 ? active_.last_id : settled_) + 1, MoveState::discarded);
}

void RobotMotion::end(std::uint64_t id) {
  if (apart_ && id <= apart_->last) {  // they end where the robot stands
    apart_.reset();
  }
  while (!waiting_.empty() && waiting_.back().id >= id) waiting_.pop_back();
  if (job_ && job_->first_id + job_->moves.size() > id) job_ = nullptr;
  while (!ready_.empty() && ready_.back().last_id >= id) {
    planned_ = begin_of(ready_.back());
    ready_.pop_back();
  }
  if (goal_ != 0 && active_.last_id >= id) active_.ends->store(true, std::memory_order_relaxed);
}

/// Gives all moves from `first` on this outcome.
void RobotMotion::end_badly(std::uint64_t first, MoveState outcome) {
  for (std::uint64_t id = first; id <= last_id_; ++id)
    if (!ended_badly_.contains(id)) ended_badly_[id] = outcome;
  while (ended_badly_.size() > kMostKept) ended_badly_.erase(ended_badly_.begin());
  while (problems_.size() > kMostKept) problems_.erase(problems_.begin());
}

void RobotMotion::add_travel(const Ready& ready, double time, std::uint64_t first, std::uint64_t last,
                             Travel& out) const {
  constexpr int kSamples = 64;
  if (ready.last_id < first || ready.first_id > last) return;
  const PlannedMotion& motion = ready.motion;
  const auto end_of = [&](std::uint64_t id) {  // s at which a move ends
    if (id < ready.first_id) return 0.0;
    const std::uint64_t i = id - ready.first_id;
    return i < motion.ends.size() ? motion.ends[i] : motion.path.path().length();
  };
  const double from = end_of(first - 1), to = end_of(last);
  std::size_t hint = 0;
  const double now = std::clamp(motion.path.profile().at(time, hint).s, from, to);
  std::vector<double> q(motion.path.joints());
  const auto way = [&](double a, double b) {
    double sum = 0;
    Vec3 before;
    for (int i = 0; i <= kSamples; ++i) {
      motion.path.path().at(a + (b - a) * i / kSamples, {q, {}, {}, {}});
      const Vec3 here = facts(ready.with).chain.forward(q).position;
      if (i > 0) sum += norm(here - before);
      before = here;
    }
    return sum;
  };
  const auto at = [&](double s) { return motion.path.profile().time_at(s); };
  out.covered += way(from, now), out.left += way(now, to);
  out.elapsed += at(now) - at(from), out.remaining += at(to) - at(now);
}

std::optional<RobotMotion::UnderWay> RobotMotion::under_way() const {
  if (goal_ == 0) return std::nullopt;
  const controllers::GoalStatus& status = controller_.status();
  const bool begun = status.active.load(std::memory_order_acquire) == goal_;
  return UnderWay{&active_.motion,
                  &facts(active_.with),
                  goal_,
                  time_of(status, goal_),
                  status.speed.load(std::memory_order_relaxed),
                  begun,
                  active_.step.get()};
}

void RobotMotion::set_pace(double share) {
  if (goal_ != 0) active_.pace->store(share, std::memory_order_relaxed);
}

std::uint64_t RobotMotion::move_under_way() const {
  if (goal_ == 0) return idle() ? 0 : settled_ + 1;
  const PlannedMotion& motion = active_.motion;
  std::size_t hint = 0;
  const double s = motion.path.profile().at(time_of(controller_.status(), goal_), hint).s;
  const auto end = std::lower_bound(motion.ends.begin(), motion.ends.end(), s);
  return std::min(active_.first_id + static_cast<std::uint64_t>(end - motion.ends.begin()), active_.last_id);
}

Travel RobotMotion::travel(std::uint64_t first, std::uint64_t last) const {
  Travel out;
  if (last <= settled_) return out;
  if (goal_ != 0) add_travel(active_, time_of(controller_.status(), goal_), first, last, out);
  for (const Ready& ready : ready_) add_travel(ready, 0, first, last, out);
  const std::uint64_t planned = !ready_.empty() ? ready_.back().last_id
                                : goal_ != 0    ? active_.last_id
                                                : settled_;
  if (planned < last) out.left = out.remaining = std::numeric_limits<double>::infinity();
  return out;
}

MoveState RobotMotion::state_of(std::uint64_t id) const {
  if (const auto bad = ended_badly_.find(id); bad != ended_badly_.end()) return bad->second;
  if (apart_ && apart_->holds(id)) return MoveState::running;
  return id <= settled_ ? MoveState::done : MoveState::running;
}

bool RobotMotion::ended_badly_from(std::uint64_t id) const {
  return ended_badly_.lower_bound(id) != ended_badly_.end();
}

std::optional<Problem> RobotMotion::problem_of(std::uint64_t id) const {
  const auto found = problems_.find(id);
  return found == problems_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace polyarm::moves
