#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "polyarm/controllers/controller.hpp"
#include "polyarm/controllers/pid.hpp"
#include "polyarm/joint_control/motion_shift.hpp"
#include "polyarm/joint_control/trajectory_goal.hpp"
#include "polyarm/realtime/handover.hpp"
#include "polyarm/realtime/queue.hpp"
#include "polyarm/trajectory/time_scale.hpp"

namespace polyarm::controllers {

/// Follows trajectories of any number of joints, as ros2_control's JointTrajectoryController does, with its
/// parameters. Sampling is by time; time runs at the speed that the verdict and speed scaling allow, so that
/// every slow-down, hold and resume stays on the path. Without a goal it holds its last command. Each joint
/// is led by the newest trajectory that names it: a trajectory that begins takes its joints over where they
/// are, with their velocity, and the others go on. A planned path (TrajectoryGoal::planned) is followed at
/// the speed asked for, within the limits it was made with.
///
/// Inputs: `joint_trajectory` (also `command`), action `follow_joint_trajectory`, `speed_scaling_input`.
/// Outputs: `controller_state`.
class JointTrajectoryController : public Controller {
 public:
  /// A goal without a bridge may begin this far from the last command, rad or m.
  static constexpr double kJumpTolerance = 1e-4;

  ~JointTrajectoryController() override;
  CallbackReturn on_configure(ControllerContext& context) override;
  CallbackReturn on_activate(const Cycle& cycle) noexcept override;
  ReturnType update(const Cycle& cycle, const Verdict& verdict) noexcept override;
  void on_deactivate(const Cycle& cycle) noexcept override;
  void on_parameters_changed() noexcept override;
  bool standing() const noexcept override;

  std::vector<InputPort> inputs() const override;
  std::uint64_t receive(const std::string& port, const Input& message, bool goal) override;
  bool cancel(std::uint64_t goal) override;
  std::optional<GoalEvent> next_goal_event() override;
  std::string refuse_changes(const std::vector<ParameterChange>& changes) const override;

  /// Where a trajectory under way will have the joints.
  struct Sampled {
    bool found = false;  ///< every joint is led by a trajectory that has begun by then and not ended
    std::vector<double> position, velocity, acceleration;  ///< of joints(), rad or m, per s, per s²
  };
  /// Cell thread: asks for the cell time `at`, as if time went on as planned; answered with the next update.
  /// False while an earlier question is open. One that nobody waits for any more is taken back.
  bool ask_sample(Nanoseconds at);
  const Sampled* sampled();  ///< null: no answer yet; the address stays until the next question
  void forget_sample();

  /// Cell thread. A number for the next goal.
  std::uint64_t new_goal_id() { return next_id_++; }
  /// Cell thread. False when the inbox is full; the goal stays with the caller.
  bool follow(std::unique_ptr<TrajectoryGoal>& goal) { return inbox_.give(goal); }
  const GoalStatus& status() const noexcept { return status_; }
  /// Cell thread: the trajectory that alone leads joints now, for looking ahead; null: a path, none, or more
  /// than one. It stays valid until this thread gives the controller another goal.
  const TrajectoryGoal* leading() const noexcept { return leading_.load(std::memory_order_acquire); }
  /// Cell thread, at most once: a motion that is added to that of the paths while it is active. It must shift
  /// all joints of the controller, in their order.
  void set_shift(std::shared_ptr<MotionShift> shift) {
    owned_shift_ = std::move(shift);
    shift_.store(owned_shift_.get(), std::memory_order_release);
  }
  /// Cell thread: the robot's own controller, which interpolates; null: this one does. With one it takes no
  /// trajectories, only TrajectoryGoal::forward, and commands the joints to be where they are measured.
  void set_forward(hardware::ForwardMoves* moves) { forward_.store(moves, std::memory_order_release); }
  const std::vector<std::string>& joints() const { return joints_; }
  /// As the user names them.
  const std::vector<std::string>& told_joints() const { return reported_joints_; }
  /// Of its cycles, s; what a planned path must be made for. Once configured.
  double period() const { return period_s_; }

 private:
  struct Interfaces {  // of one quantity, per joint; -1: none
    std::vector<int> position, velocity, acceleration, effort;
  };
  /// A trajectory under way, and how many joints it still leads.
  struct Track {
    TrajectoryGoal* goal = nullptr;
    double time = 0;
    std::size_t hint = 0;
    std::size_t joints = 0;
    bool in_order = false;  ///< the trajectory has all joints of the controller, in its order
  };
  /// The action goal that is judged; its tolerances, copied so that they outlive the trajectory.
  struct Judged {
    std::uint64_t id = 0;  ///< 0: none
    std::uint64_t trajectory = 0;
    Tolerances tolerances;
  };
  struct Braking {  // after a cancel
    bool on = false;
    double position = 0, velocity = 0, acceleration = 0, time = 0;
  };

  void read_interfaces(ControllerContext& context);
  void read_gains(ControllerContext& context);
  void read_tolerances(ControllerContext& context);
  void read_behaviour(ControllerContext& context);
  void note_checks() noexcept;
  void make_output();
  void make_rows();
  void find_places() noexcept;
  int place(bool command, std::size_t joint, const char* quantity);

  // control thread
  std::span<Track> tracks() noexcept { return std::span(tracks_).first(tracks_used_); }
  std::span<const Track> tracks() const noexcept { return std::span(tracks_).first(tracks_used_); }
  ReturnType update_forward(const Cycle& cycle, const Verdict& verdict,
                            hardware::ForwardMoves& moves) noexcept;
  void begin_forward(const Cycle& cycle) noexcept;
  void lead_forward(hardware::ForwardMoves& moves, bool may_send) noexcept;
  void drop_forward(hardware::ForwardMoves& moves) noexcept;
  void take_requests(const Cycle& cycle) noexcept;
  void arrive(TrajectoryGoal* goal, const Cycle& cycle) noexcept;
  void begin(TrajectoryGoal* goal, double into) noexcept;
  void bridge(TrajectoryGoal& goal) noexcept;
  void judge_by(const Tolerances& wanted) noexcept;
  void refuse(TrajectoryGoal* goal, GoalRefusal reason) noexcept;
  void take_joint(std::size_t joint) noexcept;
  void retire(std::size_t track, bool finished) noexcept;
  void drop_all() noexcept;
  void hold(bool brake) noexcept;
  void cut(bool all) noexcept;
  void measure() noexcept;
  void advance(double dt) noexcept;
  void follow_trajectory(std::size_t track, double dt) noexcept;
  void follow_all(Track& track, double speed) noexcept;
  void follow_some(std::size_t track, double speed) noexcept;
  void follow_path(std::size_t track) noexcept;
  void end_track(std::size_t track) noexcept;
  void advance_paths(const Verdict& verdict) noexcept;
  void brake(std::size_t joint, double dt) noexcept;
  bool judge(const Cycle& cycle) noexcept;
  int farthest_without_tolerance(const Tolerances& tolerances) const noexcept;
  void end_action(GoalOutcome outcome, int code, int joint = -1, double error = 0,
                  double tolerance = 0) noexcept;
  void command_all(double dt) noexcept;
  void take_path_up(const Verdict& verdict) noexcept;
  void shift(const Cycle& cycle, const Verdict& verdict) noexcept;
  void drop_shift() noexcept;
  void publish(const Cycle& cycle) noexcept;
  void answer_sample(const Cycle& cycle) noexcept;
  bool sample_track(const Track& track, double ahead) noexcept;
  double position_error(std::size_t joint) const noexcept;
  GoalRefusal check_start(const TrajectoryGoal& goal) noexcept;
  double scaling() noexcept;
  double pass_time(const Verdict& verdict) noexcept;
  bool stands_in_one_cycle() const noexcept;
  trajectory::ScaleRates scale_rates(bool immediate) const noexcept;

  // configuration
  std::vector<std::string> joints_;
  std::vector<std::string> reported_joints_;
  std::vector<char> continuous_;
  Interfaces commands_, states_;
  /// Places of the commands in the table, from activation on; a quantity without commands has none.
  std::vector<std::uint32_t> position_places_, velocity_places_, acceleration_places_, effort_places_;
  bool closed_loop_ = false;  // velocity alone or effort: through PID
  TrajectoryRules rules_;
  RequestedLimits asked_;
  Tolerances default_tolerances_;
  bool replacement_ = true, from_desired_ = false, keep_command_ = true, brake_on_cancel_ = false;
  double cmd_timeout_ = 0;
  double initial_scaling_ = 1;
  std::vector<trajectory::JointDynamics> dynamics_;
  double longest_stop_ = 0;  // s after which a stop no longer waits for what the plan itself does
  int scaling_state_ = -1, scaling_command_ = -1;
  std::vector<double> most_braking_;
  std::vector<PidGains> gains_;
  std::vector<double> feed_forward_;

  // control thread
  std::vector<Pid> pids_;
  /// One number for each joint in each row, all in one block: a controller is a few cache lines.
  std::vector<double> rows_;
  std::span<double> position_, velocity_, acceleration_, effort_;  // desired
  std::span<double> plan_velocity_, plan_acceleration_;            // of what leads, as planned
  std::span<double> sample_position_, sample_velocity_, sample_acceleration_, sample_effort_;
  std::span<double> measured_position_, measured_velocity_;
  std::span<double> error_, error_velocity_, output_;
  std::span<double> path_position_, path_velocity_, path_acceleration_;  // of the path, while it is shifted
  bool shifted_ = false;                                                 // in the cycle before
  std::vector<int> leader_;  // track of each joint; -1: held
  std::vector<Braking> braking_;
  std::vector<Track> tracks_;
  std::size_t tracks_used_ = 0;           // those beyond have no goal
  std::vector<TrajectoryGoal*> waiting_;  // that begin later
  bool any_waiting_ = false;              // there may be one
  Judged judged_;
  bool checks_ = false;            // some tolerance is not 0
  bool reject_when_held_ = false;  // read by who gives it goals
  bool any_braking_ = false;
  bool backing_ = false;    // in the cycle before
  double over_since_ = -1;  // s since every trajectory has ended; < 0: not yet
  bool timed_out_ = false;
  double period_s_ = 1e-3;
  double factor_ = 1;
  trajectory::TimeScale scale_;
  double stopping_for_ = 0;  // s
  std::uint64_t forward_id_ = 0;  // of the last move that was handed over
  std::size_t forward_sent_ = 0;  // moves of the motion under way
  bool forward_ends_ = false;     // the handed-over moves were cleared before their end

  // between the threads
  std::uint64_t next_id_ = 1;
  realtime::Handover<TrajectoryGoal> inbox_{32};
  realtime::Queue<std::uint64_t> cancels_{32};
  realtime::Queue<GoalEvent> events_{256};
  enum class Asking : std::uint8_t { nothing, asked, answering, answered };
  std::atomic<Asking> asking_{Asking::nothing};
  Nanoseconds requested_time_ = 0;
  Sampled sampled_;
  std::atomic<double> requested_factor_{1};
  std::atomic<Nanoseconds> now_{0};
  GoalStatus status_;
  std::atomic<const TrajectoryGoal*> leading_{nullptr};
  std::shared_ptr<MotionShift> owned_shift_;
  std::atomic<MotionShift*> shift_{nullptr};
  std::atomic<hardware::ForwardMoves*> forward_{nullptr};
  Output* state_output_ = nullptr;
};

}  // namespace polyarm::controllers
