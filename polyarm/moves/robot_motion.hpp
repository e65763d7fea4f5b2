#pragma once
/// The moves of one robot: queues and plans them, and hands them to its controller. Cell thread.
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/force/compliance.hpp"
#include "polyarm/joint_control/joint_trajectory_controller.hpp"
#include "polyarm/moves/frame_ride.hpp"
#include "polyarm/moves/move_plan.hpp"
#include "polyarm/moves/obstacles.hpp"
#include "polyarm/moves/robot_facts.hpp"

namespace polyarm::moves {

/// running: queued, planned or under way. failed: planning failed. refused: the controller did not accept it.
/// discarded: cancelled, or an earlier move failed.
enum class MoveState { running, done, failed, refused, discarded };

/// Progress of moves at the TCP: m, and s of the plan. Infinite for moves without a plan yet.
struct Travel {
  double covered = 0, left = 0, elapsed = 0, remaining = 0;
};

/// Synchronises moves of several robots: they begin in the same cycle and end together, at the pace of the
/// slowest. Created with the number of robots, and shared by all their moves. Cell thread only.
class InStep {
 public:
  explicit InStep(std::size_t members) : members_(members) {}
  /// Removes one robot.
  void leave() { --members_; }

 private:
  friend class RobotMotion;
  std::size_t members_, planned_ = 0, ready_ = 0;
  double longest_ = 0;
  Nanoseconds start_ = -1;
  bool failed_ = false;
};

/// A queue of moves that run one after the other, with blends where requested. Cell thread only; planning is
/// posted to the cell's executor. A move that blends into the next waits for the next move, or for close().
/// So the moves of one run of a program form one path, whatever their number.
class RobotMotion {
 public:
  /// Runs a job, immediately or on another thread.
  using Post = std::function<void(std::function<void()>)>;
  /// The largest number of moves that wait for planning.
  static constexpr std::size_t kMostWaiting = 1000;
  /// The largest number of moves that a program may queue ahead: waiting, being planned, ready and under way.
  static constexpr std::size_t kMostAhead = 1000;
  /// A program also waits while at least two motions are ready and take more than this time together, s. The
  /// limit is needed because a long motion takes about 0.1 MB per second.
  static constexpr double kSecondsAhead = 60;

  /// All arguments must outlive this object and the posted jobs.
  RobotMotion(const RobotFacts& robot, controllers::JointTrajectoryController& controller, Post post);

  /// Whether the robot's own controller interpolates. `measured` returns the robot's measured joints, where
  /// the next move begins after one that was ended early. Null: this computer interpolates. Only when idle().
  void set_forward(std::function<std::vector<double>()> measured) { measured_ = std::move(measured); }
  bool forward() const { return static_cast<bool>(measured_); }
  /// True if a program may queue another move now; else the program waits until a move has finished.
  bool has_room() const {
    return waiting_.size() < kMostWaiting && last_id_ - settled_ < kMostAhead && !is_far_ahead();
  }
  /// Returns the move's id, which counts up from 1. `with`: the robot with another TCP (null: unchanged);
  /// only moves with the same TCP blend. Throws Error("busy") if there is no room, Error("forward-mode") if
  /// the robot's own controller cannot carry it out. `step`: waits for the moves of the other robots of the
  /// step. Consecutive moves with the same step are one motion of the robot; they do not blend with other
  /// moves.
  std::uint64_t queue(Move move, std::shared_ptr<const RobotFacts> with = nullptr,
                      std::shared_ptr<InStep> step = nullptr);
  /// Ends the blending: the last move does not wait for a next move.
  void close();
  /// Call it in every tick with the cell's time: plans, hands over the next motion, and detects arrivals.
  void tick(Nanoseconds now);
  /// Discards everything that has not been handed over.
  void drop();
  /// Stops a move on its path as fast as the limits allow, and drops the moves after it. They count as done
  /// when the robot is at standstill.
  void end(std::uint64_t id);

  /// Stops on the path and sets the present move and all moves behind it apart; moves queued from then on are
  /// carried out first. Once only, until resumed() again.
  void suspend();
  /// True when the robot is at standstill after suspend().
  bool suspended() const { return apart_ && apart_->phase != Apart::Phase::stopping; }
  /// After the moves in between have arrived: goes back by a joint move, at the pace of the last of them, to where
  /// suspend() stopped the robot, and goes on along the path.
  void resume();
  /// True when the moves that were set apart are the present ones again.
  bool resumed() const { return !apart_; }
  /// Why the robot did not get back to its place after resume(), once; nothing if it did.
  std::optional<Problem> take_return_failure() { return std::exchange(return_failure_, std::nullopt); }
  /// The newest move that is not set apart; 0 if there is none.
  std::uint64_t newest_present() const { return apart_ && apart_->last == last_id_ ? 0 : last_id_; }

  /// From now on the robot follows the frame, which has this travel, at rest or on the paths of moves that
  /// are queued from now on. These are planned as if the frame stood still, and arrive when the robot is
  /// synchronised. Only at_end(). `lead`: of FrameRide.
  void begin_ride(const MovingFrame& frame, double travel, double lead = 0);
  /// In each tick of a ride, before tick().
  void feed_ride(const FrameTravel& travel) { ride_->feed(travel); }
  /// After the moves that are queued, the robot comes to rest beside the frame. riding() becomes false then,
  /// and planned() is where the robot stands.
  void end_ride() { ride_ends_ = true; }
  /// Ends the ride at once: the moves that are left fail with this problem.
  void fail_ride(const Problem& why);
  bool riding() const { return riding_; }
  /// True from end_ride() or fail_ride() on, until riding() becomes false: queue no moves meanwhile.
  bool ride_ends() const { return riding_ && ride_ends_; }
  /// True if the robot cannot follow any more; call fail_ride().
  bool ride_lost() const { return riding_ && ride_->lost(); }
  /// What has moved the planned paths in the world so far; identity without a ride.
  Pose ride_moved() const { return riding_ ? ride_->moved() : Pose{}; }

  /// From now on the robot yields to forces, at rest and on the paths of moves. Only at_end(), and not in a
  /// ride. Throws Error if it cannot.
  void begin_compliance(const ComplianceSettings& settings);
  /// In each tick of it, before tick().
  void feed_wrench(const controllers::SixVector& wrench, Nanoseconds time) { comply_->feed(wrench, time); }
  /// The robot stays where it is, after the moves that are queued. complying() becomes false then.
  void end_compliance() { compliance_ends_ = true; }
  /// Ends it at once: the moves that are left fail with this problem.
  void fail_compliance(const Problem& why);
  bool complying() const { return complying_; }
  bool compliance_ends() const { return complying_ && compliance_ends_; }
  const Compliance& compliance() const { return *comply_; }
  /// True if no move is present: the robot has arrived, in the moving frame during a ride.
  bool at_end() const { return goal_ == 0 && ready_.empty() && !job_ && waiting_.empty(); }

  MoveState state_of(std::uint64_t id) const;
  /// True if the move `id` or a later one failed, was refused or was discarded. O(log n).
  bool ended_badly_from(std::uint64_t id) const;
  /// The progress of the moves `first` to `last`.
  Travel travel(std::uint64_t first, std::uint64_t last) const;
  /// The reason why a move failed.
  std::optional<Problem> problem_of(std::uint64_t id) const;
  /// Warnings of plans since the last call, with their moves.
  struct Warning {
    std::uint64_t move;
    Problem problem;
  };
  std::vector<Warning> take_warnings() { return std::exchange(warnings_, {}); }
  /// True when nothing is queued, planned or under way, and the robot follows no frame.
  bool idle() const;
  std::uint64_t last_id() const { return last_id_; }

  /// The end of all planned moves, or the commanded position; the next move begins there.
  const std::vector<double>& planned() const { return planned_; }
  /// Sets the commanded position: at the start, and after another controller has moved the robot. Only when
  /// idle.
  void set_planned(std::span<const double> joints) { planned_.assign(joints.begin(), joints.end()); }
  void set_planned(std::size_t joint, double position) { planned_[joint] = position; }
  /// Applies to the next plans.
  void set_options(const MovePlanOptions& options) { options_ = options; }
  const MovePlanOptions& options() const { return options_; }
  /// How moves around obstacles see what is around them when they are planned: such a move waits until the
  /// moves before it have arrived. Null: they go straight.
  void set_find_obstacles(LookAround look) { find_obstacles_ = std::move(look); }
  /// The options of the motion under way; null if there is none.
  const MovePlanOptions* options_under_way() const { return goal_ != 0 ? &active_.options : nullptr; }
  const RobotFacts& robot() const { return robot_; }
  /// The motion that the controller follows; valid until the next tick. `goal` identifies it.
  struct UnderWay {
    const PlannedMotion* motion;
    const RobotFacts* robot;  ///< with the TCP of the plan
    std::uint64_t goal;
    double time;  ///< s of the plan
    double speed;         ///< share of the planned speed now
    bool begun;           ///< the controller follows it
    const InStep* step;   ///< null: not in step with other robots
  };
  std::optional<UnderWay> under_way() const;
  /// The motion under way goes on at this share of its speed, 0 to 1, until the next call; the next motion
  /// begins with 1.
  void set_pace(double share);
  /// The id of the present or the next move; 0 if nothing is queued, planned or under way.
  std::uint64_t move_under_way() const;

 private:
  struct Waiting {
    std::uint64_t id;
    Move move;
    std::shared_ptr<const RobotFacts> with;
    std::shared_ptr<InStep> step;
  };
  /// Moves that are planned together; the other thread writes `plan` or `failure`, then `done`.
  struct Job {
    std::uint64_t first_id;
    std::shared_ptr<const RobotFacts> with;
    std::shared_ptr<InStep> step;  ///< used by the cell thread only
    std::vector<double> from;
    std::vector<Move> moves;
    std::shared_ptr<Obstacles> obstacles;  ///< null: no move goes around them
    MovePlanOptions options;
    double period;
    MovePlan plan;
    bool forward = false;
    std::vector<std::unique_ptr<timing::PathFollower>> followers;  ///< of the plan's motions
    std::vector<std::unique_ptr<controllers::ForwardMotion>> forwards;  ///< instead, with `forward`
    std::optional<Problem> failure;
    std::size_t failed = 0;
    std::atomic<bool> done{false};
  };
  struct Ready {
    std::uint64_t first_id = 0;  ///< of motion.first
    std::uint64_t last_id = 0;   ///< of the moves that have arrived at its end
    PlannedMotion motion;
    std::unique_ptr<timing::PathFollower> follower;
    std::unique_ptr<controllers::ForwardMotion> forward;  ///< instead of a follower
    std::shared_ptr<const std::vector<Move>> moves;       ///< of the plan, with `forward`
    std::shared_ptr<const RobotFacts> with;
    std::shared_ptr<InStep> step;
    bool leads = false;  ///< the first motion of the robot in the step
    bool waits = false;  ///< waits for the other robots, and is counted
    double share = 0;    ///< fraction of the total duration of the step's motions
    MovePlanOptions options;
    std::shared_ptr<std::atomic<bool>> ends;
    std::shared_ptr<std::atomic<double>> pace;
    std::vector<trajectory::MotionLimits> limits;  ///< of the follower
  };

  /// The moves that suspend() has set apart.
  struct Apart {
    enum class Phase { stopping, away, returning } phase = Phase::stopping;
    std::uint64_t settled = 0, last = 0;  ///< they have the ids from settled + 1 to last
    std::uint64_t back = 0;               ///< id of the move back
    std::vector<double> held;             ///< where the robot stopped
    std::vector<double> planned;          ///< the end of all moves that are planned
    std::optional<Ready> active;          ///< the motion that was under way
    double time = 0;                      ///< s of its plan
    bool ending = false;                  ///< end() had stopped it already
    std::deque<Waiting> waiting;
    std::shared_ptr<Job> job;
    std::deque<Ready> ready;
    bool holds(std::uint64_t id) const { return id > settled && id <= last; }
  };

  static std::vector<double> begin_of(const Ready& ready);
  std::vector<double> place_of_stop(const Ready& ready, double time) const;
  void go_on_from(Ready& ready, double time);
  void look_at_return();
  void look_at_ride();
  void look_at_compliance();
  void fail_rest(const Problem& why);
  void give_up_apart();
  bool is_far_ahead() const;
  void plan();
  void collect();
  void hand_over(Nanoseconds now);
  bool in_step(Ready& ready, Nanoseconds now);
  const RobotFacts& facts(const std::shared_ptr<const RobotFacts>& with) const {
    return with ? *with : robot_;
  }
  void add_travel(const Ready& ready, double time, std::uint64_t first, std::uint64_t last,
                  Travel& out) const;
  void watch();
  void end_badly(std::uint64_t first, MoveState outcome);

  const RobotFacts& robot_;
  controllers::JointTrajectoryController& controller_;
  Post post_;
  std::function<std::vector<double>()> measured_;  ///< null: this computer interpolates
  LookAround find_obstacles_;
  MovePlanOptions options_;
  std::vector<double> planned_;
  std::deque<Waiting> waiting_;
  std::shared_ptr<Job> job_;
  std::deque<Ready> ready_;
  std::uint64_t goal_ = 0;  ///< of the controller, under way; 0: none
  Ready active_;            ///< the motion of that goal
  std::uint64_t last_id_ = 0, settled_ = 0;
  std::optional<Apart> apart_;
  Move back_;  ///< without targets: at the pace of the last move
  std::map<std::uint64_t, MoveState> ended_badly_;
  std::map<std::uint64_t, Problem> problems_;
  std::vector<Warning> warnings_;
  std::optional<Problem> return_failure_;
  std::shared_ptr<FrameRide> ride_;  ///< shared with the controller
  bool riding_ = false, ride_ends_ = false;
  std::shared_ptr<Compliance> comply_;
  bool complying_ = false, compliance_ends_ = false;
};

}  // namespace polyarm::moves
