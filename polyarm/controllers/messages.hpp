#pragma once
/// What goes into controllers and comes out of them, in the shapes of the ROS messages that carry the same.
/// Standard types only: plugins include this.
#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/realtime/latest.hpp"
#include "polyarm/trajectory/splines.hpp"

namespace polyarm::controllers {

/// std_msgs/Float64MultiArray, and std_msgs/Float64 with one value.
struct Numbers {
  std::vector<double> values;
};

/// geometry_msgs/Twist; with `stamp`, TwistStamped (cell time).
struct Twist {
  Vec3 linear, angular;
  std::optional<Nanoseconds> stamp;
};

/// control_msgs/DynamicJointState and MultiDOFCommand: values of named interfaces, "name/interface".
struct NamedValues {
  std::vector<std::string> names;
  std::vector<double> values;
};

/// control_msgs/GripperCommand and ParallelGripperCommand: rad or m, per s, N m or N.
struct GripperCommand {
  double position = 0;
  std::optional<double> max_velocity, max_effort;
};

/// How far a joint may be from where it should: 0 takes the controller's default, -1 switches the check off.
struct JointTolerance {
  std::string joint;
  double position = 0, velocity = 0, acceleration = 0;
};

/// trajectory_msgs/JointTrajectory, and the goal of control_msgs/FollowJointTrajectory around it.
struct TrajectoryMessage {
  std::optional<Nanoseconds> start;  ///< cell time; empty: at once
  std::vector<std::string> joints;
  std::vector<trajectory::TrajectoryPoint> points;
  // Of a goal only:
  std::vector<JointTolerance> path_tolerance, goal_tolerance;
  std::optional<double> goal_time_tolerance;  ///< s
};

using Input = std::variant<Numbers, Twist, NamedValues, GripperCommand, TrajectoryMessage>;

/// A message that comes out of a controller: numbers with the names of their fields ("pose.position.x"),
/// written in the control loop, read by one other thread.
class Output {
 public:
  struct Sample {
    Nanoseconds time = 0;
    std::vector<double> values;
  };
  Output(std::string name, std::string type, std::vector<std::string> fields)
      : name_(std::move(name)), type_(std::move(type)), fields_(std::move(fields)) {
    outbox_.reset({0, std::vector<double>(fields_.size(), 0.0)});
  }
  const std::string& name() const { return name_; }  ///< "odom", "joint_states", "controller_state"
  const std::string& type() const { return type_; }  ///< "nav_msgs/Odometry"
  const std::vector<std::string>& fields() const { return fields_; }

  /// Before either thread uses it: the values of fields that nobody fills.
  void begin_with(const std::vector<double>& values) { outbox_.reset({0, values}); }
  /// Control thread: the sample to fill; publish() when it is whole.
  Sample& draft() noexcept { return outbox_.draft(); }
  void publish(Nanoseconds time) noexcept {
    outbox_.draft().time = time;
    outbox_.publish();
  }
  /// Control thread: whether anybody has ever asked; what is costly to fill need not be filled before.
  bool wanted() const noexcept { return wanted_.load(std::memory_order_relaxed); }
  /// Reader: true if there is a new sample since the last call.
  bool fetch() noexcept {
    wanted_.store(true, std::memory_order_relaxed);
    return outbox_.fetch();
  }
  const Sample& value() const noexcept { return outbox_.value(); }

  /// Texts that belong to the message and never change: "frame_id", "child_frame_id".
  std::map<std::string, std::string> texts;

 private:
  std::string name_, type_;
  std::vector<std::string> fields_;
  realtime::Latest<Sample> outbox_;
  std::atomic<bool> wanted_{false};
};

/// A message that a controller takes.
struct InputPort {
  std::string name;                           ///< "commands", "joint_trajectory", "cmd_vel"
  std::vector<std::string> types;             ///< "geometry_msgs/TwistStamped", "geometry_msgs/Twist"
  bool action = false;                        ///< goals are answered through GoalEvent
  std::string feedback = "controller_state";  ///< the output that tells of a goal under way
};

/// What became of a goal; codes are those of control_msgs/FollowJointTrajectory.
enum class GoalOutcome : std::uint8_t { accepted, succeeded, aborted, canceled };
/// What a gripper tells of a goal, as the results of control_msgs/GripperCommand and ParallelGripperCommand
/// do.
struct GripperResult {
  double position = 0, effort = 0;  ///< rad or m; N m or N, as commanded
  bool stalled = false, reached_goal = false;
};
struct GoalEvent {
  std::uint64_t goal = 0;
  GoalOutcome outcome = GoalOutcome::accepted;
  std::int32_t code = 0;    ///< 0 successful, -1 invalid goal, -4 path tolerance, -5 goal tolerance
  std::int32_t joint = -1;  ///< the joint at fault, or of success the one far off that no tolerance judged
  double error = 0, tolerance = 0;  ///< rad or m; tolerance 0: none is set
  std::optional<GripperResult> gripper = {};
};

}  // namespace polyarm::controllers
