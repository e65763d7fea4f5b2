#pragma once
/// ROS's JointTrajectory as a file: in YAML as `ros2 topic echo`, `rostopic echo` and `pub` have it, or JSON.
/// Not for the control cycle. rad or m, s.
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

/// The message that `yaml` holds: {header, joint_names, points}, with time_from_start as {sec, nanosec},
/// {secs, nsecs} or seconds. Throws Error("bad-message", "bad-value" …) that names place, point and joint.
/// That lists have as many values as there are joints is not looked at.
controllers::TrajectoryMessage trajectory_of(const Yaml& yaml);

/// A trajectory for the joints of a robot, in the robot's order.
struct JointTrajectoryFile {
  controllers::TrajectoryMessage message;
  std::vector<Location> where;  ///< of each point
};

/// Reads the text of a file called `name`. A goal or a RobotTrajectory around the trajectory is taken off; of
/// several messages the first counts. Throws Error with all that is wrong: what trajectory_of() finds, and
/// "wrong-size", "bad-time" (negative, or not after the point before), "no-points", "repeated-joint".
JointTrajectoryFile parse_trajectory(std::string_view text, const std::string& name);
/// The same of the file itself; "no-file", "unreadable".
JointTrajectoryFile read_trajectory_file(const std::string& path);

/// Brings the values into the order of `names`, the joints of a robot; a name may have "robot/" or a prefix
/// that all share before it. Joints that the file does not move stay at `start`, if at least one is left out
/// a warning "joint-left-out" says which. Throws Error("unknown-joint").
void order_joints(JointTrajectoryFile& file, const std::vector<std::string>& names,
                  const std::vector<double>& start, Problems& warnings);

/// As it is timed, by the rules of ros2_control's joint trajectory controller (trajectory/splines.hpp), from
/// `start` at time 0 unless the first point is there. `continuous` flags joints that turn without end.
/// Throws Error with the place of the point at fault.
trajectory::Trajectory as_timed(const JointTrajectoryFile& file, const std::vector<double>& start,
                                const std::vector<bool>& continuous = {});
/// Its positions alone, named "point 3", counted from 1; `radius` at each. Throws Error("no-positions").
std::vector<paths::JointWaypoint> as_waypoints(const JointTrajectoryFile& file, double radius = 0);

/// A timed path as points: every 1 / `rate` seconds and at the end, each with position, velocity and
/// acceleration.
controllers::TrajectoryMessage sampled(const timing::TimedPath& timed, double rate,
                                       const std::vector<std::string>& joints);
/// The same as few points as quintics between them need to follow the timed path to `tolerance` (rad or m),
/// which is how the joint trajectory controller goes from point to point.
controllers::TrajectoryMessage knots_of(const timing::TimedPath& timed, double tolerance,
                                        const std::vector<std::string>& joints);
/// Puts `next` behind `message`, whose end it begins at.
void append(controllers::TrajectoryMessage& message, const controllers::TrajectoryMessage& next);

/// ros1: secs and nsecs.
enum class TimeWords { ros2, ros1 };
/// Numbers parse back to the same bits in YAML 1.1 too; times are whole nanoseconds.
std::string to_yaml(const controllers::TrajectoryMessage& message, TimeWords words = TimeWords::ros2);
std::string to_json(const controllers::TrajectoryMessage& message, TimeWords words = TimeWords::ros2);

}  // namespace polyarm::ros_files
