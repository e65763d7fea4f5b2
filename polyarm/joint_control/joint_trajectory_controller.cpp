#include "polyarm/joint_control/joint_trajectory_controller.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kWorthANote = 0.01;  // rad or m that a joint is off at the end where no tolerance judges it
/// A stop that was asked for as immediate brakes this many times as hard as one within the limits.
constexpr double kImmediateFactor = 3;
/// No change from full speed to rest or back is faster than this, s, unless it is immediate.
constexpr double kShortestRamp = 0.05;
/// Nor is a stop slower than this after it has lasted for long enough, s.
constexpr double kLastRamp = 0.5;
constexpr double kTurn = 2 * std::numbers::pi;

bool is_ended(const TrajectoryGoal& goal) {
  return goal.ends && goal.ends->load(std::memory_order_relaxed);
}

double pace_of(const TrajectoryGoal& goal) {
  return goal.pace ? goal.pace->load(std::memory_order_relaxed) : 1;
}

double shortest(double angle) {
  return angle - kTurn * std::round(angle / kTurn);
}
}  // namespace

JointTrajectoryController::~JointTrajectoryController() {
  for (Track& track : tracks_) delete track.goal;
  for (TrajectoryGoal* goal : waiting_) delete goal;
}

CallbackReturn JointTrajectoryController::on_activate(const Cycle& cycle) noexcept {
  now_.store(cycle.time, std::memory_order_relaxed);
  find_places();
  measure();
  const bool forward = forward_.load(std::memory_order_acquire);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double last = commands_.position[j] >= 0 ? command(static_cast<std::size_t>(commands_.position[j]))
                                                   : std::numeric_limits<double>::quiet_NaN();
    position_[j] = keep_command_ && !forward && std::isfinite(last) ? last : measured_position_[j];
    if (!std::isfinite(position_[j])) return CallbackReturn::error;  // nothing is known of where it is
    velocity_[j] = acceleration_[j] = effort_[j] = 0;
    leader_[j] = -1;
    braking_[j].on = false;
    pids_[j].reset();
  }
  judged_.id = 0;
  shifted_ = false;
  over_since_ = -1;
  factor_ = initial_scaling_;
  requested_factor_.store(factor_, std::memory_order_relaxed);
  scale_ = trajectory::TimeScale();
  stopping_for_ = 0;
  command_all(0);
  if (forward) return CallbackReturn::success;
  // A message that came when it had just ended was meant for then.
  while (TrajectoryGoal* goal = inbox_.take())
    if (goal->bridged)
      refuse(goal, GoalRefusal::busy);
    else
      arrive(goal, cycle);
  return CallbackReturn::success;
}

void JointTrajectoryController::on_deactivate(const Cycle&) noexcept {
  end_action(GoalOutcome::aborted, -1);
  if (hardware::ForwardMoves* const moves = forward_.load(std::memory_order_acquire)) {
    drop_forward(*moves);
    moves->set_pace(0);  // nobody asks for motion any more
  }
  drop_all();
  drop_shift();
  for (TrajectoryGoal*& goal : waiting_)
    if (goal) inbox_.put_back(std::exchange(goal, nullptr));
  while (TrajectoryGoal* goal = inbox_.take()) refuse(goal, GoalRefusal::busy);
  for (std::size_t j = 0; j < joints_.size(); ++j)  // what pushes by itself stops pushing
    for (const int place : {commands_.velocity[j], commands_.acceleration[j], commands_.effort[j]})
      if (place >= 0) set_command(static_cast<std::size_t>(place), 0);
}

bool JointTrajectoryController::standing() const noexcept {
  if (const hardware::ForwardMoves* const moves = forward_.load(std::memory_order_acquire))
    return moves->flow().standing;
  if (any_braking_ || (shifted_ && !shift_.load(std::memory_order_acquire)->standing())) return false;
  for (const Track& track : tracks())
    if (track.goal && !(track.goal->planned ? track.goal->planned->stands() : scale_.value() <= 0))
      return false;
  return true;
}

inline void JointTrajectoryController::take_requests(const Cycle& cycle) noexcept {
  for (std::uint64_t id = 0; cancels_.pop(id);) {
    if (judged_.id != id) continue;
    end_action(GoalOutcome::canceled, 0);
    hold(true);
  }
  if (std::exchange(any_waiting_, false))
    for (TrajectoryGoal*& goal : waiting_) {
      if (goal && goal->start <= cycle.time) {
        begin(std::exchange(goal, nullptr), 0);
        status_.started_cycle.store(cycle.index + 1, std::memory_order_release);
      }
      any_waiting_ = any_waiting_ || goal;
    }
  if (TrajectoryGoal* goal = inbox_.take()) arrive(goal, cycle);
}

// --- a cycle ----------------------------------------------------------------------------------------------

void JointTrajectoryController::measure() noexcept {
  const auto read = [&](int place) {
    return place < 0 ? std::numeric_limits<double>::quiet_NaN() : state(static_cast<std::size_t>(place));
  };
  for (std::size_t j = 0; j < joints_.size(); ++j) measured_position_[j] = read(states_.position[j]);
  for (std::size_t j = 0; j < joints_.size(); ++j) measured_velocity_[j] = read(states_.velocity[j]);
}

double JointTrajectoryController::position_error(std::size_t j) const noexcept {
  const double error = position_[j] - measured_position_[j];
  return continuous_[j] ? shortest(error) : error;
}

double JointTrajectoryController::scaling() noexcept {
  double wanted = requested_factor_.load(std::memory_order_relaxed);
  if (scaling_state_ >= 0) wanted = state(static_cast<std::size_t>(scaling_state_));
  if (std::isfinite(wanted) && wanted >= 0) factor_ = wanted;
  if (scaling_command_ >= 0) set_command(static_cast<std::size_t>(scaling_command_), factor_);
  return factor_;
}

/// What the joints allow the speed of time to change by. Of joints that nothing leads nobody asks.
trajectory::ScaleRates JointTrajectoryController::scale_rates(bool immediate) const noexcept {
  const double harder = immediate ? kImmediateFactor : 1;
  trajectory::ScaleRates out = trajectory::ScaleRates::of_ramp(kShortestRamp / harder);
  // A rate has its whole effect two cycles later, when a joint that turns round here is faster already.
  const double s = scale_.value(), ahead = 2 * period_s_;
  const double soon = std::clamp(s + scale_.rate() * ahead, s, 1.0);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (leader_[j] < 0) continue;
    const trajectory::JointDynamics& d = dynamics_[j];
    const trajectory::JointDynamics most{harder * d.acceleration, harder * d.deceleration,
                                         harder * harder * d.jerk};
    const double v = plan_velocity_[j] * factor_, a = plan_acceleration_[j] * factor_ * factor_;
    out.narrow(v, a, s, most);
    out.narrow(v + a * s * ahead, a, soon, most);
  }
  if (stopping_for_ > longest_stop_)  // of a plan that breaks its limits itself
    out.down = std::max(out.down, 1 / kLastRamp), out.change = std::max(out.change, 20 / kLastRamp);
  return out;
}

/// Is what every joint moves no more than it may lose in one cycle?
bool JointTrajectoryController::stands_in_one_cycle() const noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (leader_[j] < 0) continue;
    const double most = std::isfinite(dynamics_[j].deceleration) ? dynamics_[j].deceleration * period_s_ : 0;
    if (!(std::abs(plan_velocity_[j] * factor_) * scale_.value() <= most)) return false;
  }
  return true;
}

/// The seconds of the trajectories that pass in this cycle: towards the speed that the verdict asks for, as
/// fast as the joints can.
inline double JointTrajectoryController::pass_time(const Verdict& verdict) noexcept {
  const bool stops = !(verdict.speed > 0);
  stopping_for_ = stops && scale_.value() > 0 ? stopping_for_ + period_s_ : 0;
  const bool led = std::any_of(leader_.begin(), leader_.end(), [](int track) { return track >= 0; });
  if (!led || (stops && scale_.rate() == 0 && stands_in_one_cycle())) {
    scale_.jump(verdict.speed);
    return period_s_ * scale_.value();
  }
  if (scale_.value() == verdict.speed && scale_.rate() == 0) return period_s_ * scale_.value();
  return scale_.advance(period_s_, verdict.speed, scale_rates(verdict.immediate));
}

void JointTrajectoryController::brake(std::size_t j, double dt) noexcept {
  Braking& b = braking_[j];
  const double end = std::abs(b.velocity) / b.acceleration;
  b.time = std::min(b.time + dt, end);
  const double a = std::copysign(b.acceleration, -b.velocity);
  position_[j] = b.position + b.velocity * b.time + 0.5 * a * b.time * b.time;
  b.on = b.time < end;
  velocity_[j] = b.on ? b.velocity + a * b.time : 0;
  acceleration_[j] = b.on ? a : 0;
}

/// One that leads all joints, in their order.
inline void JointTrajectoryController::follow_all(Track& track, double speed) noexcept {
  const TrajectoryGoal& goal = *track.goal;
  goal.trajectory.sample(track.time, position_, plan_velocity_, plan_acceleration_, track.hint);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    velocity_[j] = plan_velocity_[j] * speed;
    acceleration_[j] = plan_acceleration_[j] * speed * speed;
  }
  std::size_t hint = 0;
  if (!goal.effort.empty())
    goal.effort.sample(track.time, effort_, {}, {}, hint);
  else if (rules_.effort)
    std::fill(effort_.begin(), effort_.end(), 0.0);
}

void JointTrajectoryController::follow_some(std::size_t i, double speed) noexcept {
  Track& track = tracks_[i];
  const TrajectoryGoal& goal = *track.goal;
  const std::size_t n = goal.trajectory.joints();
  const auto some = [n](std::span<double> list) { return list.first(n); };
  goal.trajectory.sample(track.time, some(sample_position_), some(sample_velocity_),
                         some(sample_acceleration_), track.hint);
  std::size_t hint = 0;
  if (!goal.effort.empty()) goal.effort.sample(track.time, some(sample_effort_), {}, {}, hint);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t j = goal.joints.empty() ? k : goal.joints[k];
    if (leader_[j] != static_cast<int>(i)) continue;
    position_[j] = sample_position_[k];
    plan_velocity_[j] = sample_velocity_[k];
    plan_acceleration_[j] = sample_acceleration_[k];
    velocity_[j] = sample_velocity_[k] * speed;
    acceleration_[j] = sample_acceleration_[k] * speed * speed;
    effort_[j] = goal.effort.empty() ? 0 : sample_effort_[k];
  }
}

inline void JointTrajectoryController::follow_trajectory(std::size_t i, double dt) noexcept {
  Track& track = tracks_[i];
  const double speed = scale_.value() * factor_;
  track.time += dt;
  if (track.in_order && track.joints == joints_.size())
    follow_all(track, speed);
  else
    follow_some(i, speed);
  status_.time.store(track.time, std::memory_order_relaxed);
  if (track.time >= track.goal->trajectory.duration()) end_track(i);
}

/// Where the path was moved to in this cycle.
void JointTrajectoryController::follow_path(std::size_t i) noexcept {
  timing::PathFollower& path = *tracks_[i].goal->planned;
  path.sample(sample_position_, sample_velocity_, sample_acceleration_);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (leader_[j] != static_cast<int>(i)) continue;
    position_[j] = sample_position_[j];
    velocity_[j] = plan_velocity_[j] = sample_velocity_[j];
    acceleration_[j] = plan_acceleration_[j] = sample_acceleration_[j];
    effort_[j] = 0;
  }
  status_.time.store(path.time(), std::memory_order_relaxed);
  status_.speed.store(path.factor(), std::memory_order_relaxed);
  if (path.finished() || (is_ended(*tracks_[i].goal) && path.stands())) end_track(i);
}

/// Its joints hold where it ended.
void JointTrajectoryController::end_track(std::size_t i) noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (leader_[j] == static_cast<int>(i)) {
      leader_[j] = -1;
      if (!rules_.nonzero_end) velocity_[j] = 0;
      acceleration_[j] = 0;
    }
  retire(i, true);
}

/// A path keeps its own limits on the way to the speed that the verdict asks for.
inline void JointTrajectoryController::advance_paths(const Verdict& verdict) noexcept {
  const double target = verdict.speed > 0 ? verdict.speed * factor_ : 0;
  const bool back = verdict.back > 0 && !verdict.immediate, begins = back && !backing_;
  backing_ = back;
  for (const Track& track : tracks()) {
    timing::PathFollower* path = track.goal ? track.goal->planned.get() : nullptr;
    if (path && begins) path->step_back(verdict.back_time, verdict.back_way);
    if (path && back)
      path->advance_back(verdict.back);
    else if (path)
      path->advance(is_ended(*track.goal) ? 0 : target * pace_of(*track.goal), verdict.immediate);
  }
}

inline void JointTrajectoryController::advance(double dt) noexcept {
  bool moving = false;
  for (std::size_t i = 0; i < tracks_used_; ++i) {  // one that ends is gone afterwards
    if (!tracks_[i].goal) continue;
    moving = true;
    if (tracks_[i].goal->planned)
      follow_path(i);
    else
      follow_trajectory(i, dt);
  }
  if (std::exchange(any_braking_, false))
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (braking_[j].on) {
        brake(j, period_s_);
        any_braking_ = any_braking_ || braking_[j].on;
      }
  if (!moving && over_since_ < 0) over_since_ = 0;
}

/// Whether what is desired may still be commanded: looks at how far the joints are off.
bool JointTrajectoryController::judge(const Cycle&) noexcept {
  const Tolerances& t = judged_.id ? judged_.tolerances : default_tolerances_;
  bool moving = false;
  for (const Track& track : tracks()) moving = moving || track.goal;
  const bool velocity_counts =
      !commands_.velocity.empty() && (commands_.velocity[0] >= 0 || commands_.effort[0] >= 0);
  const auto beyond = [&](std::size_t j, const Tolerances::Of& of) {
    if (of.position > 0 && !(std::abs(error_[j]) <= of.position)) return 1;
    if (velocity_counts && of.velocity > 0 && !(std::abs(error_velocity_[j]) <= of.velocity)) return 2;
    return 0;
  };
  const auto report = [&](int code, std::size_t j, int which, const Tolerances::Of& of) {
    end_action(GoalOutcome::aborted, code, static_cast<int>(j), which == 1 ? error_[j] : error_velocity_[j],
               which == 1 ? of.position : of.velocity);
  };
  if (moving) {
    for (std::size_t j = 0; j < joints_.size(); ++j)
      if (leader_[j] >= 0)
        if (const int which = beyond(j, t.path[j])) {
          report(-4, j, which, t.path[j]);
          return false;
        }
    return true;
  }
  if (judged_.id == 0) return true;
  for (TrajectoryGoal* goal : waiting_)
    if (goal) return true;  // it has not begun
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (const int which = beyond(j, t.goal[j])) {
      if (t.goal_time <= 0 || over_since_ <= t.goal_time) return true;  // there is time
      report(-5, j, which, t.goal[j]);
      return false;
    }
  const int far = farthest_without_tolerance(t);
  end_action(GoalOutcome::succeeded, 0, far, far >= 0 ? error_[static_cast<std::size_t>(far)] : 0);
  return true;
}

/// The joint that is off most, of those that no goal tolerance judges; -1 where none is off worth a note.
int JointTrajectoryController::farthest_without_tolerance(const Tolerances& t) const noexcept {
  int out = -1;
  double most = kWorthANote;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (!(t.goal[j].position > 0) && std::abs(error_[j]) > most) {
      most = std::abs(error_[j]);
      out = static_cast<int>(j);
    }
  return out;
}

/// All joints have the same interfaces.
void JointTrajectoryController::find_places() noexcept {
  const auto find = [this](const std::vector<int>& claimed, std::vector<std::uint32_t>& out) {
    for (std::size_t j = 0; j < out.size(); ++j)
      out[j] = static_cast<std::uint32_t>(bindings().command[static_cast<std::size_t>(claimed[j])]);
  };
  find(commands_.position, position_places_);
  find(commands_.velocity, velocity_places_);
  find(commands_.acceleration, acceleration_places_);
  find(commands_.effort, effort_places_);
}

void JointTrajectoryController::command_all(double dt) noexcept {
  double* const commands = bindings().commands.data();
  const auto put = [=](const std::vector<std::uint32_t>& places, std::span<const double> values) {
    for (std::size_t j = 0; j < places.size(); ++j) commands[places[j]] = values[j];
  };
  asked_.note_positions(position_);
  put(position_places_, position_);
  if (!closed_loop_) {
    put(velocity_places_, velocity_);
    put(acceleration_places_, acceleration_);
    return;
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double velocity_error = velocity_[j] - measured_velocity_[j];
    const double feedback = dt > 0 ? pids_[j].compute(position_error(j), velocity_error, dt) : 0;
    output_[j] = feed_forward_[j] * velocity_[j] + feedback + effort_[j];
  }
  put(velocity_places_, output_);
  put(effort_places_, output_);
}

ReturnType JointTrajectoryController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  now_.store(cycle.time, std::memory_order_relaxed);
  if (hardware::ForwardMoves* const moves = forward_.load(std::memory_order_acquire))
    return update_forward(cycle, verdict, *moves);
  const bool looks = closed_loop_ || checks_ || judged_.id != 0 || state_output_->wanted();
  if (looks) {
    measure();
    for (std::size_t j = 0; j < joints_.size(); ++j) error_[j] = position_error(j);
    for (std::size_t j = 0; j < joints_.size(); ++j)
      error_velocity_[j] = velocity_[j] - measured_velocity_[j];
  }
  const bool was_shifted = shifted_;
  if (shifted_)
    take_path_up(verdict);
  else if (verdict.cut || verdict.discard)
    drop_shift();
  take_requests(cycle);
  if (verdict.discard && standing()) {
    end_action(GoalOutcome::aborted, -1);
    drop_all();
  }
  if (verdict.cut) cut(was_shifted);
  const double factor = scaling();
  const double step = pass_time(verdict);
  status_.speed.store(scale_.value() * factor, std::memory_order_relaxed);
  if (over_since_ >= 0) over_since_ += period_s_;
  if (looks && !judge(cycle)) hold(true);
  advance_paths(verdict);
  advance(step * factor);
  if (cmd_timeout_ > 0 && over_since_ > cmd_timeout_ && !std::exchange(timed_out_, true)) {
    end_action(GoalOutcome::aborted, -5);
    if (rules_.nonzero_end)
      for (std::size_t j = 0; j < joints_.size(); ++j) velocity_[j] = 0;
  }
  shift(cycle, verdict);
  command_all(period_s_);
  publish(cycle);
  answer_sample(cycle);
  return ReturnType::ok;
}

void JointTrajectoryController::publish(const Cycle& cycle) noexcept {
  if (!state_output_->wanted()) return;
  double* out = state_output_->draft().values.data();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    for (const double value :
         {position_[j], velocity_[j], acceleration_[j], measured_position_[j], measured_velocity_[j],
          position_error(j), velocity_[j] - measured_velocity_[j], closed_loop_ ? output_[j] : position_[j]})
      *out++ = value;
  }
  *out = status_.time.load(std::memory_order_relaxed);
  state_output_->publish(cycle.time);
}

}  // namespace polyarm::controllers
