/// What ros2_control calls `query_state`: where a trajectory under way will be.
#include <algorithm>
#include <thread>

#include "polyarm/joint_control/joint_trajectory_controller.hpp"

namespace polyarm::controllers {

bool JointTrajectoryController::ask_sample(Nanoseconds at) {
  if (asking_.load(std::memory_order_acquire) != Asking::nothing) return false;
  requested_time_ = at;
  asking_.store(Asking::asked, std::memory_order_release);
  return true;
}

const JointTrajectoryController::Sampled* JointTrajectoryController::sampled() {
  return asking_.load(std::memory_order_acquire) == Asking::answered ? &sampled_ : nullptr;
}

void JointTrajectoryController::forget_sample() {
  Asking was = Asking::asked;
  if (asking_.compare_exchange_strong(was, Asking::nothing, std::memory_order_acq_rel)) return;
  // The loop is about to have answered: microseconds.
  while (asking_.load(std::memory_order_acquire) == Asking::answering) std::this_thread::yield();
  asking_.store(Asking::nothing, std::memory_order_release);
}

/// False where the time lies outside the trajectory. Of a path the speed is not known before: it has no
/// times.
bool JointTrajectoryController::sample_track(const Track& track, double ahead) noexcept {
  const TrajectoryGoal& goal = *track.goal;
  const double time = track.time + ahead * factor_;
  if (goal.planned || goal.forward || time < 0 || time > goal.trajectory.duration()) return false;
  const std::size_t n = goal.trajectory.joints();
  const auto some = [n](std::span<double> list) { return list.first(n); };
  std::size_t hint = 0;
  goal.trajectory.sample(time, some(sample_position_), some(sample_velocity_), some(sample_acceleration_),
                         hint);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t j = goal.joints.empty() ? k : goal.joints[k];
    if (leader_[j] < 0 || tracks_[static_cast<std::size_t>(leader_[j])].goal != &goal) continue;
    sampled_.position[j] = sample_position_[k];
    sampled_.velocity[j] = sample_velocity_[k];
    sampled_.acceleration[j] = sample_acceleration_[k];
  }
  return true;
}

void JointTrajectoryController::answer_sample(const Cycle& cycle) noexcept {
  Asking was = Asking::asked;
  if (!asking_.compare_exchange_strong(was, Asking::answering, std::memory_order_acq_rel)) return;
  const double ahead = seconds(requested_time_ - cycle.time);
  sampled_.found = std::all_of(leader_.begin(), leader_.end(), [](int track) { return track >= 0; });
  for (const Track& track : tracks())
    if (track.goal && sampled_.found) sampled_.found = sample_track(track, ahead);
  asking_.store(Asking::answered, std::memory_order_release);
}

}  // namespace polyarm::controllers
