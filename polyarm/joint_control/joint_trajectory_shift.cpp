/// The motion that is added to the one that a joint trajectory controller follows.
#include <algorithm>
#include <utility>

#include "polyarm/joint_control/joint_trajectory_controller.hpp"

namespace polyarm::controllers {

/// Between cycles the desired state is the shifted one; a cycle begins with that of the path. A motion that
/// is given up stays where it was shifted to.
void JointTrajectoryController::take_path_up(const Verdict& verdict) noexcept {
  MotionShift& shift = *shift_.load(std::memory_order_acquire);
  if (verdict.cut || (verdict.discard && standing()) || !shift.active()) {
    shift.drop();
    shifted_ = false;
    return;
  }
  std::copy(path_position_.begin(), path_position_.end(), position_.begin());
  std::copy(path_velocity_.begin(), path_velocity_.end(), velocity_.begin());
  std::copy(path_acceleration_.begin(), path_acceleration_.end(), acceleration_.begin());
}

void JointTrajectoryController::shift(const Cycle& cycle, const Verdict& verdict) noexcept {
  MotionShift* const shift = shift_.load(std::memory_order_acquire);
  if (!shift || !shift->active() || any_braking_) return;
  std::copy(position_.begin(), position_.end(), path_position_.begin());
  std::copy(velocity_.begin(), velocity_.end(), path_velocity_.begin());
  std::copy(acceleration_.begin(), acceleration_.end(), path_acceleration_.begin());
  const MotionShift::Request request{cycle.time, period_s_, verdict.speed, verdict.immediate};
  const MotionShift::Outcome outcome = shift->apply(request, {position_, velocity_, acceleration_});
  shifted_ = outcome == MotionShift::Outcome::shifted;
  if (outcome != MotionShift::Outcome::ended || tracks_used_ == 0) return;
  end_action(GoalOutcome::aborted, -1);  // a path that goes on would jump to where it is without the shift
  drop_all();
}

/// Gives up the shift, also one that has not begun.
void JointTrajectoryController::drop_shift() noexcept {
  MotionShift* const shift = shift_.load(std::memory_order_acquire);
  if (std::exchange(shifted_, false) || (shift && shift->active())) shift->drop();
}

}  // namespace polyarm::controllers
