/// Goals of the trajectory controller: how they arrive, begin, lead joints and end. Control thread.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "polyarm/joint_control/joint_trajectory_controller.hpp"

namespace polyarm::controllers {

namespace {
/// A joint that leaves the path to stop brakes this many times as hard as its limit; drives give what they
/// can.
constexpr double kCutFactor = 10;
/// Relative; a path is made for this period, or for another one.
constexpr double kSamePeriod = 1e-6;

bool is_in_order(const std::vector<std::uint32_t>& joints) {
  for (std::size_t k = 0; k < joints.size(); ++k)
    if (joints[k] != k) return false;
  return true;
}
}  // namespace

void JointTrajectoryController::refuse(TrajectoryGoal* goal, GoalRefusal reason) noexcept {
  status_.reason.store(reason, std::memory_order_relaxed);
  status_.refused.store(goal->id, std::memory_order_release);
  if (goal->action) events_.push(GoalEvent{goal->id, GoalOutcome::aborted, -1});
  inbox_.put_back(goal);
}

/// One that leads no joint any more goes back to be freed.
void JointTrajectoryController::retire(std::size_t i, bool finished) noexcept {
  Track& track = tracks_[i];
  if (!track.goal) return;
  (finished ? status_.finished : status_.discarded).store(track.goal->id, std::memory_order_release);
  if (status_.active.load(std::memory_order_relaxed) == track.goal->id)
    status_.active.store(0, std::memory_order_release);
  if (leading_.load(std::memory_order_relaxed) == track.goal)
    leading_.store(nullptr, std::memory_order_release);
  inbox_.put_back(track.goal);
  track = {};
  while (tracks_used_ > 0 && !tracks_[tracks_used_ - 1].goal) --tracks_used_;
}

void JointTrajectoryController::take_joint(std::size_t j) noexcept {
  braking_[j].on = false;
  const int old = leader_[j];
  leader_[j] = -1;
  if (old < 0) plan_velocity_[j] = plan_acceleration_[j] = 0;
  if (old >= 0 && --tracks_[static_cast<std::size_t>(old)].joints == 0)
    retire(static_cast<std::size_t>(old), false);
}

void JointTrajectoryController::drop_all() noexcept {
  for (std::size_t i = 0, used = tracks_used_; i < used; ++i) retire(i, false);
  std::fill(leader_.begin(), leader_.end(), -1);
}

/// What a goal does not say is the controller's own.
void JointTrajectoryController::judge_by(const Tolerances& wanted) noexcept {
  const auto pick = [](double given, double own) { return std::isnan(given) ? own : given; };
  const auto of = [&](const Tolerances::Of& given, const Tolerances::Of& own) {
    return Tolerances::Of{pick(given.position, own.position), pick(given.velocity, own.velocity),
                          pick(given.acceleration, own.acceleration)};
  };
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    judged_.tolerances.path[j] = of(wanted.path[j], default_tolerances_.path[j]);
    judged_.tolerances.goal[j] = of(wanted.goal[j], default_tolerances_.goal[j]);
  }
  judged_.tolerances.goal_time = pick(wanted.goal_time, default_tolerances_.goal_time);
}

/// Whether a goal fits this controller and begins where the joints are commanded to be.
GoalRefusal JointTrajectoryController::check_start(const TrajectoryGoal& goal) noexcept {
  timing::PathFollower* planned = goal.planned.get();
  const std::size_t named = goal.joints.empty() ? joints_.size() : goal.joints.size();
  if (planned ? planned->joints() != joints_.size() || !goal.joints.empty() || goal.bridged
              : goal.trajectory.joints() != named)
    return GoalRefusal::wrong_size;
  if (planned && !(std::abs(planned->period() - period_s_) <= kSamePeriod * period_s_))
    return GoalRefusal::wrong_period;
  if (goal.bridged) return GoalRefusal::none;
  std::size_t hint = 0;
  if (planned)
    planned->sample(sample_position_, sample_velocity_, sample_acceleration_);
  else
    goal.trajectory.sample(0, sample_position_, {}, {}, hint);
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (!(std::abs(sample_position_[j] - position_[j]) <= kJumpTolerance) ||
        (planned && !(std::abs(sample_velocity_[j] - velocity_[j]) <=
                      planned->limits()[j].max_acceleration * period_s_)))
      return GoalRefusal::jump;
  return GoalRefusal::none;
}

void JointTrajectoryController::arrive(TrajectoryGoal* goal, const Cycle& cycle) noexcept {
  if (const GoalRefusal no = check_start(*goal); no != GoalRefusal::none) return refuse(goal, no);
  if (goal->action) {
    end_action(GoalOutcome::aborted, -1);  // one goal at a time: the older is preempted
    judged_.id = goal->id;
    judged_.trajectory = goal->id;
    judge_by(goal->tolerances);
    events_.push(GoalEvent{goal->id, GoalOutcome::accepted});
  }
  for (TrajectoryGoal*& other : waiting_)  // what would begin later than this is replaced by it
    if (other && other->start >= goal->start) {
      status_.discarded.store(other->id, std::memory_order_release);
      inbox_.put_back(std::exchange(other, nullptr));
    }
  if (goal->start > cycle.time) {
    for (TrajectoryGoal*& other : waiting_)
      if (!other) {
        other = goal;
        any_waiting_ = true;
        return;
      }
    return refuse(goal, GoalRefusal::busy);
  }
  begin(goal, 0);
  status_.started_cycle.store(cycle.index + 1, std::memory_order_release);
}

/// The first segment, from where each joint is to where the trajectory's first point wants it: never a jump
/// of position, and where the joint moves, none of velocity.
void JointTrajectoryController::bridge(TrajectoryGoal& goal) noexcept {
  const trajectory::TrajectoryPoint& first = goal.first;
  measure();
  const double duration = goal.trajectory.end_of(0);
  constexpr double kAtRest = 1e-6, kTurn = 2 * std::numbers::pi;
  // Per second of the trajectory, which passes slower or faster than the clock.
  const double speed = std::max(1e-3, scale_.value() * factor_);
  for (std::size_t k = 0; k < goal.joints.size(); ++k) {
    const std::size_t j = goal.joints[k];
    const bool desired = replacement_ || from_desired_;
    const double p = desired ? position_[j] : measured_position_[j];
    const double v = desired ? velocity_[j] : measured_velocity_[j];
    trajectory::SplineEnd from{p, std::isfinite(v) ? v / speed : 0,
                               desired ? acceleration_[j] / (speed * speed) : 0};
    trajectory::SplineEnd to{first.positions[k]};
    int degree = 1;
    if (!first.velocities.empty()) {
      to.velocity = first.velocities[k];
      degree = 3;
      if (!first.accelerations.empty()) {
        to.acceleration = first.accelerations[k];
        degree = 5;
      }
    } else if (std::abs(from.velocity) > kAtRest && !rules_.step) {
      to.velocity = goal.leaving[k];
      degree = 3;
    }
    double shift = 0;
    if (goal.relative) shift = p;
    if (continuous_[j]) shift -= kTurn * std::round((to.position + shift - p) / kTurn);
    if (shift != 0) goal.trajectory.shift(k, shift);
    to.position += shift;
    auto piece = trajectory::spline_piece(degree, from, to, duration);
    if (rules_.step) piece = {p, 0, 0, 0, 0, 0};
    goal.trajectory.set_piece(0, k, piece);
  }
}

void JointTrajectoryController::begin(TrajectoryGoal* goal, double into) noexcept {
  if (goal->bridged) bridge(*goal);
  if (goal->planned) goal->planned->begin(scale_.value() * factor_);
  const std::size_t count = goal->joints.empty() ? joints_.size() : goal->joints.size();
  if (!replacement_)  // the others hold where they are
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      if (leader_[j] >= 0) velocity_[j] = acceleration_[j] = 0;
      take_joint(j);
    }
  for (std::size_t k = 0; k < count; ++k) take_joint(goal->joints.empty() ? k : goal->joints[k]);
  std::size_t free = 0;
  while (free < tracks_.size() && tracks_[free].goal) ++free;  // there is one for each joint, and one more
  tracks_[free] = {goal, into, 0, count, count == joints_.size() && is_in_order(goal->joints)};
  tracks_used_ = std::max(tracks_used_, free + 1);
  for (std::size_t k = 0; k < count; ++k)
    leader_[goal->joints.empty() ? k : goal->joints[k]] = static_cast<int>(free);
  // Whoever sees the goal must not see the time of the one before.
  status_.time.store(goal->planned ? goal->planned->time() : into, std::memory_order_relaxed);
  status_.active.store(goal->id, std::memory_order_release);
  const auto leads = std::count_if(tracks().begin(), tracks().end(), [](const Track& t) { return t.goal; });
  leading_.store(!goal->planned && leads == 1 ? goal : nullptr, std::memory_order_release);
  over_since_ = -1;
  timed_out_ = false;
}

void JointTrajectoryController::end_action(GoalOutcome outcome, int code, int joint, double error,
                                           double tolerance) noexcept {
  if (judged_.id == 0) return;
  events_.push(GoalEvent{judged_.id, outcome, code, joint, error, tolerance});
  judged_.id = 0;
}

/// Everything under way is given up. Held is where the joints are; or they slow down first, each in its own
/// time.
void JointTrajectoryController::hold(bool may_brake) noexcept {
  drop_all();
  drop_shift();
  measure();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    position_[j] = measured_position_[j];
    const double v = measured_velocity_[j];
    velocity_[j] = acceleration_[j] = effort_[j] = 0;
    if (may_brake && brake_on_cancel_ && most_braking_[j] > 0 && std::isfinite(v) && v != 0)
      braking_[j] = {true, position_[j], v, most_braking_[j], 0};
    any_braking_ = any_braking_ || braking_[j].on;
  }
}

/// Every joint that is led brakes by itself from the speed that it is commanded; the motion is given up.
/// `all`: also those that nothing leads.
void JointTrajectoryController::cut(bool all) noexcept {
  if (tracks_used_ == 0 && !all) return;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double v = velocity_[j], limit = dynamics_[j].deceleration;
    if ((leader_[j] < 0 && !all) || !std::isfinite(v) || v == 0) continue;
    const double most = std::isfinite(limit) && limit > 0 ? kCutFactor * limit : std::abs(v) / period_s_;
    braking_[j] = {true, position_[j], v, most, 0};
    any_braking_ = true;
  }
  end_action(GoalOutcome::aborted, -1);
  drop_all();
}

}  // namespace polyarm::controllers
