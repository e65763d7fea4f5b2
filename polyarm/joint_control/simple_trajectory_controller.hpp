#pragma once
#include <memory>

#include "polyarm/joint_control/asked_limits.hpp"
#include "polyarm/realtime/handover.hpp"

namespace polyarm::controllers {

/// The simplest controller of trajectories there is: positions and velocities between two points in
/// proportion to time, from the moment that the trajectory arrives, and at its end a velocity of zero. A new
/// trajectory replaces the one under way at once. It plays the RobotController of ros2_control's example 7,
/// which differs in that it steps where this one interpolates. Parameters: `joints`, `command_interfaces`,
/// `state_interfaces`. Input: `joint_trajectory`. What it lacks the joint trajectory controller has.
class SimpleTrajectoryController : public Controller {
 public:
  ~SimpleTrajectoryController() override;
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  bool standing() const noexcept override { return points_ == nullptr; }
  std::vector<InputPort> inputs() const override {
    return {{"joint_trajectory", {"trajectory_msgs/JointTrajectory"}}};
  }
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;

 private:
  using Points = std::vector<trajectory::TrajectoryPoint>;
  void check_limits(const TrajectoryMessage& message, const std::vector<std::size_t>& order) const;
  void stop() noexcept;

  std::vector<std::string> joints_, announced_;
  RequestedLimits asked_;
  std::vector<int> position_command_, velocity_command_;
  std::size_t first_position_state_ = 0;
  double time_ = 0, period_s_ = 1e-3;
  std::size_t at_ = 0;
  Points* points_ = nullptr;  // the first is where it began
  realtime::Handover<Points> inbox_{8};
};

}  // namespace polyarm::controllers
