#pragma once
/// Reads and writes JointTrajectory messages as files: YAML as `ros2 topic echo`, `rostopic echo` and `pub`
/// use it, or JSON. Not for the control cycle. rad or m, s.
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/messages.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/timing/timed_path.hpp"
#include "polyarm/trajectory/trajectory.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::ros_files {

/// Reads a message {header, joint_names, points}; time_from_start is {sec, nanosec}, {secs, nsecs} or
/// seconds. Throws Error("bad-message", "bad-value" …) that names location, point and joint. Does not check
/// that the lists have one value per joint.
controllers::TrajectoryMessage trajectory_of(const Yaml& yaml);

/// A trajectory for the joints of a robot, in the robot's order.
struct JointTrajectoryFile {
  controllers::TrajectoryMessage message;
  std::vector<Location> where;  ///< of each point
};

/// Parses the text of a file called `name`. A goal or RobotTrajectory around the trajectory is removed. If
/// there are several messages, the first is used. Throws Error with all mistakes: those that trajectory_of()
/// finds, and "wrong-size", "bad-time" (negative, or not after the previous point), "no-points",
/// "repeated-joint".
JointTrajectoryFile parse_trajectory(std::string_view text, const std::string& name);
/// Reads and parses a file. Also throws Error("no-file" | "unreadable").
JointTrajectoryFile read_trajectory_file(const std::string& path);

/// Sorts the values into the order of `names`, the joints of a robot. A name may begin with "robot/" or a
/// common prefix. Joints that are not in the file stay at `start`; the warning "joint-left-out" lists them.
/// Throws Error("unknown-joint").
void order_joints(JointTrajectoryFile& file, const std::vector<std::string>& names,
                  const std::vector<double>& start, Problems& warnings);

/// The trajectory with the times of the file, interpolated by the rules of ros2_control's joint trajectory
/// controller (trajectory/splines.hpp). It begins at `start` at time 0, unless the first point has time 0.
/// `continuous` marks continuous joints. Throws Error with the location of the wrong point.
trajectory::Trajectory as_timed(const JointTrajectoryFile& file, const std::vector<double>& start,
                                const std::vector<bool>& continuous = {});
/// Only the positions, as waypoints named "point 3" (counted from 1) with the blend `radius`. Throws
/// Error("no-positions").
std::vector<paths::JointWaypoint> as_waypoints(const JointTrajectoryFile& file, double radius = 0);

/// Samples a timed path every 1 / `rate` seconds and at its end: position, velocity and acceleration.
controllers::TrajectoryMessage sampled(const timing::TimedPath& timed, double rate,
                                       const std::vector<std::string>& joints);
/// The same with as few points as needed: quintic splines between them, which the joint trajectory controller
/// uses, follow the timed path within `tolerance` (rad or m).
controllers::TrajectoryMessage knots_of(const timing::TimedPath& timed, double tolerance,
                                        const std::vector<std::string>& joints);
/// Appends `next`, which begins where `message` ends.
void append(controllers::TrajectoryMessage& message, const controllers::TrajectoryMessage& next);

/// The names of times: sec and nanosec, or (ros1) secs and nsecs.
enum class TimeWords { ros2, ros1 };
/// Numbers parse back to the same bits, also in YAML 1.1. Times are whole nanoseconds.
std::string to_yaml(const controllers::TrajectoryMessage& message, TimeWords words = TimeWords::ros2);
std::string to_json(const controllers::TrajectoryMessage& message, TimeWords words = TimeWords::ros2);

}  // namespace polyarm::ros_files
