#include "polyarm/controllers/joint_trajectory_controller.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::controllers {

namespace {
/// A stop that was asked for as immediate runs down this many times faster than one on the path.
constexpr double kImmediateFactor = 8;

/// The time from full speed to a hold that keeps the joint with the least acceleration for its speed within
/// its limit.
double ramp_of(const ControllerContext& context, const std::vector<std::string>& joints) {
  constexpr double kShortest = 0.1, kLongest = 2.0;  // s
  double ramp = kShortest;
  for (const std::string& joint : joints) {
    const JointFacts* facts = context.find_joint(joint);
    if (facts) ramp = std::max(ramp, trajectory::TimeScale::ramp_for(facts->velocity, facts->acceleration));
  }
  return std::min(ramp, kLongest);
}

std::vector<std::string> cross(const std::vector<std::string>& joints, const char* interface) {
  std::vector<std::string> out;
  for (const std::string& joint : joints) out.push_back(joint + "/" + interface);
  return out;
}
}  // namespace

CallbackReturn JointTrajectoryController::on_configure(ControllerContext& context) {
  joints_.clear();
  for (const std::string& joint : context.parameters.list("joints"))
    joints_.push_back(context.whole_joint(joint));
  for (const std::string& name : cross(joints_, "position")) claim_command(name);
  for (const std::string& name : cross(joints_, "position")) claim_state(name);
  for (auto* values : {&position_, &velocity_, &acceleration_, &start_}) values->assign(joints_.size(), 0.0);
  period_s_ = seconds(context.period);
  scale_ = trajectory::TimeScale(ramp_of(context, joints_));
  return joints_.empty() ? CallbackReturn::failure : CallbackReturn::success;
}

CallbackReturn JointTrajectoryController::on_activate(const Cycle&) noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double last = command(j);
    position_[j] = std::isfinite(last) ? last : state(j);
    velocity_[j] = acceleration_[j] = 0;
  }
  command_all();
  return CallbackReturn::success;
}

void JointTrajectoryController::drop_goal() noexcept {
  if (!goal_) return;
  status_.discarded.store(goal_->id, std::memory_order_release);
  inbox_.put_back(goal_);
  goal_ = nullptr;
  status_.active.store(0, std::memory_order_release);
}

void JointTrajectoryController::accept(TrajectoryGoal* goal, const Cycle& cycle) noexcept {
  const auto refuse = [&](GoalRefusal reason) {
    status_.reason.store(reason, std::memory_order_relaxed);
    status_.refused.store(goal->id, std::memory_order_release);
    inbox_.put_back(goal);
  };
  if (goal->trajectory.joints() != joints_.size()) return refuse(GoalRefusal::wrong_size);
  std::size_t hint = 0;
  goal->trajectory.sample(0, start_, {}, {}, hint);
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (!(std::abs(start_[j] - position_[j]) <= kJumpTolerance)) return refuse(GoalRefusal::jump);
  drop_goal();
  goal_ = goal;
  time_ = 0;
  hint_ = 0;
  status_.active.store(goal->id, std::memory_order_release);
  status_.started_cycle.store(cycle.index + 1, std::memory_order_release);
}

void JointTrajectoryController::command_all() noexcept {
  const std::size_t n = joints_.size();
  for (std::size_t j = 0; j < n; ++j) set_command(j, position_[j]);
  if (commands_velocity_)
    for (std::size_t j = 0; j < n; ++j) set_command(n + j, velocity_[j]);
}

ReturnType JointTrajectoryController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  if (TrajectoryGoal* goal = inbox_.take()) accept(goal, cycle);
  if (verdict.discard && scale_.value() <= 0) drop_goal();
  const double dt = period_s_ * (verdict.immediate ? kImmediateFactor : 1.0);
  const double advance = scale_.advance(dt, verdict.speed) / (verdict.immediate ? kImmediateFactor : 1.0);
  if (goal_) {
    time_ += advance;
    goal_->trajectory.sample(time_, position_, velocity_, acceleration_, hint_);
    const double speed = scale_.value();
    for (double& v : velocity_) v *= speed;
    status_.time.store(time_, std::memory_order_relaxed);
    if (time_ >= goal_->trajectory.duration()) {
      status_.finished.store(goal_->id, std::memory_order_release);
      status_.active.store(0, std::memory_order_release);
      inbox_.put_back(goal_);
      goal_ = nullptr;
      std::fill(velocity_.begin(), velocity_.end(), 0.0);
    }
  }
  status_.speed.store(scale_.value(), std::memory_order_relaxed);
  command_all();
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
