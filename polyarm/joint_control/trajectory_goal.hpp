#pragma once
/// From a message to a trajectory that the control loop can follow: checking, ordering, interpolating. All of
/// it outside the loop.
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/controllers/messages.hpp"
#include "polyarm/joint_control/asked_limits.hpp"
#include "polyarm/joint_control/forward_motion.hpp"
#include "polyarm/timing/path_follower.hpp"
#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::controllers {

/// What the joints may be off: 0 switches a check off. Per joint of the controller, rad or m, per s, per s².
struct Tolerances {
  struct Of {
    double position = 0, velocity = 0, acceleration = 0;
  };
  std::vector<Of> path, goal;
  double goal_time = 0;  ///< s after the end in which the goal must be met; 0: no limit
};

/// A trajectory or a planned path to follow. `id` counts up from 1.
struct TrajectoryGoal {
  std::uint64_t id = 0;
  trajectory::Trajectory trajectory = {};
  /// Instead of a trajectory: all joints of the controller, in order, along a path at any speed. Its period
  /// is the controller's, and it begins at the last command.
  std::unique_ptr<timing::PathFollower> planned = nullptr;
  /// Instead of both: moves for the robot's own controller (set_forward()).
  std::unique_ptr<ForwardMotion> forward = nullptr;
  /// Of a planned path, shared with who sent it: set, it comes to rest on the path as soon as its limits
  /// allow, and is over there as if it were at its end. Null: nobody ends it.
  std::shared_ptr<std::atomic<bool>> ends = nullptr;
  /// Of a planned path, shared with who sent it: a share of the speed, 0 to 1, which may change at any time. 0:
  /// it comes to rest on the path, and goes on when the share rises. Null: 1.
  std::shared_ptr<std::atomic<double>> pace = nullptr;
  /// The controller's joint behind each of the trajectory's; empty: all of them, in order.
  std::vector<std::uint32_t> joints = {};
  trajectory::Trajectory effort = {};  ///< feed-forward, of the same joints; empty: none
  bool action = false;
  Nanoseconds start = -1;      ///< cell time; < 0: when it arrives
  Tolerances tolerances = {};  ///< of an action; NaN where the controller's own holds

  // When bridged, the first segment is made when the goal begins, from where the joints are then.
  bool bridged = false;
  trajectory::TrajectoryPoint first = {};  ///< where the bridge ends
  std::vector<double> leaving = {};  ///< velocity with which the path goes on there, where `first` has none
  bool relative = false;             ///< positions count from where the joints are when it begins
};

enum class GoalRefusal : std::uint32_t { none, jump, wrong_size, busy, wrong_period };

/// What became of the goals; every field may be read from any thread at any time.
struct GoalStatus {
  std::atomic<std::uint64_t> active{0};     ///< goal being followed; 0: none, holding
  std::atomic<std::uint64_t> finished{0};   ///< newest goal that reached its end
  std::atomic<std::uint64_t> discarded{0};  ///< newest goal that was given up or replaced
  std::atomic<std::uint64_t> refused{0};    ///< newest goal that was not accepted
  std::atomic<GoalRefusal> reason{GoalRefusal::none};
  std::atomic<std::uint64_t> started_cycle{
      0};                        ///< cycle in which the newest goal began, plus one; 0: none yet
  std::atomic<double> time{0};   ///< s into the active trajectory or path
  std::atomic<double> speed{1};  ///< share of the planned speed now; below zero: back along a path
};

/// How messages are understood.
struct TrajectoryRules {
  std::vector<std::string> joints;  ///< as messages name them
  std::vector<std::string> whole;   ///< the same with their robot
  std::vector<char> continuous;
  bool step = false;  ///< `interpolation_method: none`
  bool partial = false, nonzero_end = false, integrate = false, effort = false;
  double upsampling = 0;                ///< Hz of the policy behind position chunks; 0: off
  const RequestedLimits* limits = nullptr;  ///< of the same joints; null: none
};

/// Throws Error with every fault: "no-joints", "unknown-joint", "missing-joint", "no-points", "wrong-size",
/// "bad-time", "moves-at-end", "in-the-past", "no-effort", "beyond-limits", "not-a-number". `now` is cell
/// time; `action`: tolerances are taken from the message.
std::unique_ptr<TrajectoryGoal> make_goal(const TrajectoryMessage& message, const TrajectoryRules& rules,
                                          Nanoseconds now, bool action);

}  // namespace polyarm::controllers
