#pragma once
#include <atomic>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::controllers {

/// Opens and closes a gripper, as parallel_gripper_action_controller/GripperActionController does: the action
/// `gripper_cmd` ends when the joint is within `goal_tolerance`, or has stalled for `stall_timeout` (which is
/// a success where `allow_stalling` says so). It commands the joint's position. A new goal replaces the one
/// under way; a cancel holds the joint where it is.
class GripperActionController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override { end(GoalOutcome::aborted, -1); }
  bool standing() const noexcept override { return goal_ == 0; }
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;
  bool cancel(std::uint64_t goal) override { return goal < next_id_ && cancels_.push(goal); }
  std::optional<GoalEvent> next_goal_event() override;

 private:
  struct Command {
    std::uint64_t id = 0;
    double position = 0, velocity = 0, effort = 0;
  };
  void end(GoalOutcome outcome, int code) noexcept;

  std::size_t position_ = 0, command_ = 0;
  int velocity_ = -1, speed_command_ = -1, effort_command_ = -1;
  double tolerance_ = 0.01, stall_velocity_ = 0.001, stall_timeout_ = 1, max_effort_ = 10,
         max_velocity_ = 0.1;
  bool allow_stalling_ = false;
  double period_s_ = 1e-3, lower_ = 0, upper_ = 0;

  std::uint64_t goal_ = 0;  // under way; 0: none
  double wanted_ = 0, slow_for_ = 0, last_position_ = 0, speed_ = 0.1, effort_ = 10;
  std::uint64_t next_id_ = 1;
  realtime::Queue<Command> inbox_{8};
  realtime::Queue<std::uint64_t> cancels_{8};
  realtime::Queue<GoalEvent> events_{64};
  Output* output_ = nullptr;
};

}  // namespace polyarm::controllers
