#pragma once
/// Moves of one robot, queued, planned and handed to its controller.
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
#include "polyarm/controllers/joint_trajectory_controller.hpp"
#include "polyarm/moves/move_plan.hpp"
#include "polyarm/moves/robot_facts.hpp"

namespace polyarm::moves {

/// running: queued, planned or under way. failed: it could not be planned. refused: the controller did not
/// take it. discarded: somebody gave it up, or a move before it failed.
enum class MoveState { running, done, failed, refused, discarded };

/// Of moves under way, at the TCP: m, s of the plan. Infinite where it is not planned yet.
struct Travel {
  double covered = 0, left = 0, elapsed = 0, remaining = 0;
};

/// Moves of several robots that begin in the same cycle and end together, at the pace of the slowest. Made
/// for so many robots, and shared by all their moves. Cell thread only.
class InStep {
 public:
  explicit InStep(std::size_t members) : members_(members) {}
  /// One robot less.
  void leave() { --members_; }

 private:
  friend class RobotMotion;
  std::size_t members_, planned_ = 0, ready_ = 0;
  double longest_ = 0;
  Nanoseconds start_ = -1;
  bool failed_ = false;
};

/// A queue of moves that are carried out one after the other, blended where they say so. Cell thread only;
/// planning is posted to whoever the cell has for it. A move that blends into the next waits for that one, or
/// for close(); so what comes from one run of a program is one path, however many moves it has.
class RobotMotion {
 public:
  /// Runs a job, at once or on another thread.
  using Post = std::function<void(std::function<void()>)>;
  /// Most moves that wait for being planned.
  static constexpr std::size_t kMostWaiting = 1000;
  /// A program looks so many moves ahead: those that wait, are planned, are ready and are under way.
  static constexpr std::size_t kMostAhead = 1000;

  /// All outlive this, and what was posted.
  RobotMotion(const RobotFacts& robot, controllers::JointTrajectoryController& controller, Post post)
      : robot_(robot), controller_(controller), post_(std::move(post)) {}

  /// Whether a program may ask for another move now, or has to wait until one has arrived.
  bool has_room() const { return waiting_.size() < kMostWaiting && last_id_ - settled_ < kMostAhead; }
  /// Returns the move's id, which counts up from 1. `with`: the robot with another TCP, which nothing blends
  /// into that has not the same; null: as it is. Throws Error("busy") when there is no room.
  /// `step`: it waits for the moves of the others. What follows each other with the same one is one motion of
  /// the robot, and blends into nothing else.
  std::uint64_t queue(Move move, std::shared_ptr<const RobotFacts> with = nullptr,
                      std::shared_ptr<InStep> step = nullptr);
  /// Nothing more will come that the last move could blend into.
  void close();
  /// Every tick, with the cell's time: plans what can be, hands over what is next, sees what has arrived.
  void tick(Nanoseconds now);
  /// Gives up all that has not been handed over.
  void drop();
  /// Ends a move where it is, on its path, as soon as the limits allow, and whatever was to come after it.
  /// They count as done when the robot stands.
  void end(std::uint64_t id);

  MoveState state_of(std::uint64_t id) const;
  /// Whether the move `id`, or one after it, failed, was refused or was discarded. O(log n).
  bool ended_badly_from(std::uint64_t id) const;
  /// How far the moves from `first` to `last` have come.
  Travel travel(std::uint64_t first, std::uint64_t last) const;
  /// Why a move failed.
  std::optional<Problem> problem_of(std::uint64_t id) const;
  /// Of plans since the last call, with their moves.
  struct Warning {
    std::uint64_t move;
    Problem problem;
  };
  std::vector<Warning> take_warnings() { return std::exchange(warnings_, {}); }
  /// True when nothing is queued, planned or under way.
  bool idle() const;
  std::uint64_t last_id() const { return last_id_; }

  /// Where the robot will be when all moves planned so far are over, or is commanded to be; the next begins
  /// there.
  const std::vector<double>& planned() const { return planned_; }
  /// Tells where the robot is commanded to be, at the start and after somebody else moved it. When idle.
  void set_planned(std::span<const double> joints) { planned_.assign(joints.begin(), joints.end()); }
  void set_planned(std::size_t joint, double position) { planned_[joint] = position; }
  /// For what is planned from now on.
  void set_options(const MovePlanOptions& options) { options_ = options; }
  const MovePlanOptions& options() const { return options_; }
  /// What the motion under way was planned with; null while there is none.
  const MovePlanOptions* options_under_way() const { return goal_ != 0 ? &active_.options : nullptr; }
  const RobotFacts& robot() const { return robot_; }
  /// What the controller follows, until the next tick; `goal` tells one from the next.
  struct UnderWay {
    const PlannedMotion* motion;
    const RobotFacts* robot;  ///< with the TCP that it was planned for
    std::uint64_t goal;
    double time;  ///< s of the plan
  };
  std::optional<UnderWay> under_way() const;
  /// The id of the move that the robot is in, or comes to next; 0 where none is queued, planned or under way.
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
    std::shared_ptr<InStep> step;  ///< the cell thread's
    std::vector<double> from;
    std::vector<Move> moves;
    MovePlanOptions options;
    double period;
    MovePlan plan;
    std::vector<std::unique_ptr<timing::PathFollower>> followers;  ///< of the plan's motions
    std::optional<Problem> failure;
    std::size_t failed = 0;
    std::atomic<bool> done{false};
  };
  struct Ready {
    std::uint64_t first_id = 0;  ///< of motion.first
    std::uint64_t last_id = 0;   ///< of the moves that have arrived when it is over
    PlannedMotion motion;
    std::unique_ptr<timing::PathFollower> follower;
    std::shared_ptr<const RobotFacts> with;
    std::shared_ptr<InStep> step;
    bool leads = false;  ///< the first of those in step
    bool waits = false;  ///< for the others, and is counted
    double share = 0;    ///< of the duration of those in step
    MovePlanOptions options;
    std::shared_ptr<std::atomic<bool>> ends;
  };

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
  MovePlanOptions options_;
  std::vector<double> planned_;
  std::deque<Waiting> waiting_;
  std::shared_ptr<Job> job_;
  std::deque<Ready> ready_;
  std::uint64_t goal_ = 0;  ///< of the controller, under way; 0: none
  Ready active_;            ///< what it is
  std::uint64_t last_id_ = 0, settled_ = 0;
  std::map<std::uint64_t, MoveState> ended_badly_;
  std::map<std::uint64_t, Problem> problems_;
  std::vector<Warning> warnings_;
};

}  // namespace polyarm::moves
