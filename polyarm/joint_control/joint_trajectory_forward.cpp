/// The joint trajectory controller of a robot whose own controller interpolates: it hands moves over, follows
/// the measured joints, and commands none.
#include <algorithm>
#include <cmath>

#include "polyarm/joint_control/joint_trajectory_controller.hpp"

namespace polyarm::controllers {

namespace {
/// rad or m: a motion that begins farther from the measured joints is refused.
constexpr double kForwardStart = 0.05;
}  // namespace

void JointTrajectoryController::begin_forward(const Cycle& cycle) noexcept {
  TrajectoryGoal* const goal = inbox_.take();
  if (!goal) return;
  if (!goal->forward || goal->forward->joints() != joints_.size())
    return refuse(goal, GoalRefusal::wrong_size);
  if (tracks_used_ > 0) return refuse(goal, GoalRefusal::busy);
  if (!(goal->forward->off_start(measured_position_) <= kForwardStart))
    return refuse(goal, GoalRefusal::jump);
  tracks_[0] = {goal, 0, 0, joints_.size(), true};
  tracks_used_ = 1;
  std::fill(leader_.begin(), leader_.end(), 0);
  forward_sent_ = 0;
  forward_ends_ = false;
  status_.time.store(0, std::memory_order_relaxed);  // not that of the goal before
  status_.active.store(goal->id, std::memory_order_release);
  status_.started_cycle.store(cycle.index + 1, std::memory_order_release);
}

/// Nothing of the motion is left, here and at the robot's controller.
void JointTrajectoryController::drop_forward(hardware::ForwardMoves& moves) noexcept {
  if (tracks_used_ == 0) return;
  moves.clear();
  drop_all();
}

void JointTrajectoryController::lead_forward(hardware::ForwardMoves& moves, bool may_send) noexcept {
  TrajectoryGoal& goal = *tracks_[0].goal;
  status_.time.store(goal.forward->find(measured_position_, period_s_), std::memory_order_relaxed);
  if (goal.ends && goal.ends->load(std::memory_order_relaxed) && !std::exchange(forward_ends_, true))
    moves.clear();
  const auto all = goal.forward->moves();
  while (may_send && !forward_ends_ && forward_sent_ < all.size()) {
    hardware::ForwardMove& next = all[forward_sent_];
    next.id = forward_id_ + 1;
    if (!moves.accept(next)) break;
    ++forward_id_;
    ++forward_sent_;
  }
  const hardware::ForwardFlow flow = moves.flow();
  if (!flow.idle || !flow.standing) return;
  const bool all_done = forward_sent_ == all.size() && (all.empty() || flow.done >= forward_id_);
  if (!forward_ends_ && !all_done) return;
  if (!forward_ends_) status_.time.store(goal.forward->duration(), std::memory_order_relaxed);
  end_track(0);
}

ReturnType JointTrajectoryController::update_forward(const Cycle& cycle, const Verdict& verdict,
                                                     hardware::ForwardMoves& moves) noexcept {
  measure();
  for (std::uint64_t id = 0; cancels_.pop(id);) {
  }  // there are no actions
  begin_forward(cycle);
  if (verdict.cut || (verdict.discard && moves.flow().standing)) drop_forward(moves);
  const std::shared_ptr<std::atomic<double>>* const pace =
      tracks_used_ > 0 && tracks_[0].goal->pace ? &tracks_[0].goal->pace : nullptr;
  const double asked = pace ? (*pace)->load(std::memory_order_relaxed) : 1;
  const double share = std::clamp(verdict.speed * scaling() * asked, 0.0, 1.0);
  moves.set_pace(share);
  status_.speed.store(share, std::memory_order_relaxed);
  if (tracks_used_ > 0) lead_forward(moves, share > 0);
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (std::isfinite(measured_position_[j])) position_[j] = measured_position_[j];
    velocity_[j] = std::isfinite(measured_velocity_[j]) ? measured_velocity_[j] : 0;
    acceleration_[j] = 0;
    error_[j] = error_velocity_[j] = 0;
  }
  command_all(period_s_);
  publish(cycle);
  answer_sample(cycle);
  return ReturnType::ok;
}

}  // namespace polyarm::controllers
