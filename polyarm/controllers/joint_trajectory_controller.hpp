#pragma once
#include <atomic>
#include <cstdint>
#include <memory>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/realtime/handover.hpp"
#include "polyarm/trajectory/time_scale.hpp"
#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::controllers {

/// A trajectory to follow, for the joints of one controller in its order. `id` counts up from 1.
struct TrajectoryGoal {
  std::uint64_t id = 0;
  trajectory::Trajectory trajectory;
};

enum class GoalRefusal : std::uint32_t { none, jump, wrong_size };

/// What became of the goals; every field may be read from any thread at any time.
struct GoalStatus {
  std::atomic<std::uint64_t> active{0};     ///< goal being followed; 0: none, holding
  std::atomic<std::uint64_t> finished{0};   ///< newest goal that reached its end
  std::atomic<std::uint64_t> discarded{0};  ///< newest goal that was given up or replaced
  std::atomic<std::uint64_t> refused{0};    ///< newest goal that was not accepted
  std::atomic<GoalRefusal> reason{GoalRefusal::none};
  std::atomic<std::uint64_t> started_cycle{
      0};                        ///< cycle in which the newest goal began, plus one; 0: none yet
  std::atomic<double> time{0};   ///< s into the active trajectory
  std::atomic<double> speed{1};  ///< share of the planned speed now
};

/// Follows trajectories of any number of joints, as ros2_control's JointTrajectoryController does: parameters
/// `joints`, `command_interfaces` (position, velocity or both), `state_interfaces`. Sampling is by time, time
/// runs at the speed that the verdict allows, so that every slow-down, hold and resume stays on the path.
/// Without a goal it holds its last command. A goal whose start is not where the last command is, is refused:
/// it would jump.
class JointTrajectoryController : public Controller {
 public:
  /// A goal may begin this far from the last command, rad or m.
  static constexpr double kJumpTolerance = 1e-4;

  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle&) noexcept override { drop_goal(); }
  bool standing() const noexcept override { return !goal_ || scale_.value() <= 0; }

  /// From one other thread. False when the inbox is full; the goal stays with the caller.
  bool follow(std::unique_ptr<TrajectoryGoal>& goal) { return inbox_.give(goal); }
  const GoalStatus& status() const noexcept { return status_; }
  const std::vector<std::string>& joints() const { return joints_; }

 private:
  void accept(TrajectoryGoal* goal, const Cycle& cycle) noexcept;
  void drop_goal() noexcept;
  void command_all() noexcept;

  std::vector<std::string> joints_;
  bool commands_position_ = true, commands_velocity_ = false;
  bool has_velocity_state_ = false;
  std::vector<double> position_, velocity_, acceleration_, start_;
  TrajectoryGoal* goal_ = nullptr;
  double time_ = 0;
  std::size_t hint_ = 0;
  double period_s_ = 1e-3;
  trajectory::TimeScale scale_;
  realtime::Handover<TrajectoryGoal> inbox_;
  GoalStatus status_;

 public:
  ~JointTrajectoryController() override { delete goal_; }
};

}  // namespace polyarm::controllers
