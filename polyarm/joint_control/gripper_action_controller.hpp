#pragma once
#include <atomic>

#include "polyarm/controllers/pid.hpp"
#include "polyarm/controllers/pid_parameters.hpp"
#include "polyarm/joint_control/asked_limits.hpp"
#include "polyarm/realtime/queue.hpp"

namespace polyarm::controllers {

/// Opens and closes a gripper, as the GripperActionControllers of ROS do: the action `gripper_cmd` ends when
/// the joint is within `goal_tolerance` of what it was commanded, or has stalled for `stall_timeout` (which
/// is a success where `allow_stalling` says so). It commands the joint's position, or its effort through the
/// PID `gains.<joint>`, not above the goal's `max_effort`; which, comes with the type's name. A new goal
/// replaces the one under way, which ends as canceled; a cancel holds the joint where it is. Output
/// `gripper_state`.
class GripperActionController : public Controller {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  std::string refuse_changes(const std::vector<ParameterChange>& changes) const override;
  bool standing() const noexcept override { return standing_; }
  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;
  bool cancel(std::uint64_t goal) override;
  std::optional<GoalEvent> next_goal_event() override;

 private:
  struct Settings {
    double tolerance = 0.01, stall_velocity = 0.001, stall_timeout = 1, max_effort = 10, max_velocity = 0.1;
    bool allow_stalling = false;
  };
  struct Command {
    std::uint64_t id = 0;
    double position = 0, velocity = 0, effort = 0;
  };
  std::string read_parameters(Parameters& parameters);
  void claim(ControllerContext& context, const std::string& joint);
  void measure() noexcept;
  void hold() noexcept;
  void take_goals(bool stop) noexcept;
  void judge() noexcept;
  void write_commands() noexcept;
  void publish(const Cycle& cycle) noexcept;
  void tell(std::uint64_t goal, GoalOutcome outcome, int code) noexcept;
  void end(GoalOutcome outcome, int code) noexcept;
  void refuse_waiting() noexcept;

  // configuration
  Settings settings_;
  bool by_effort_ = false;
  std::string speed_interface_, effort_interface_;
  std::size_t position_ = 0, command_ = 0;
  int velocity_ = -1, speed_command_ = -1, effort_command_ = -1;
  double period_s_ = 1e-3, lower_ = 0, upper_ = 0;
  RequestedLimits asked_;
  std::vector<RosControlParameters> gains_;  // one, where efforts are commanded

  // control thread
  Pid pid_;
  std::uint64_t goal_ = 0;  // under way; 0: none
  double at_ = 0, moves_ = 0;
  double wanted_ = 0, speed_ = 0, effort_ = 0, given_effort_ = 0, slow_for_ = 0;
  bool stopped_ = false, standing_ = true, stalled_ = false, reached_ = false;

  // between the threads
  std::uint64_t next_id_ = 1;
  std::atomic<std::uint64_t> ended_{0};  // goals end in their order
  realtime::Queue<Command> inbox_{8};
  realtime::Queue<std::uint64_t> cancels_{8};
  realtime::Queue<GoalEvent> events_{64};
  Output* output_ = nullptr;
};

}  // namespace polyarm::controllers
