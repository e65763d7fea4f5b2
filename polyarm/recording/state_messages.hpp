#pragma once
/// Converts the joint states of a cycle into ROS 2 messages: joint states and frames.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::recording {

/// ROS time from nanoseconds.
messages::builtin_interfaces::msg::Time stamp_of(std::int64_t nanoseconds);

/// A transform without a time stamp.
messages::geometry_msgs::msg::TransformStamped transform(const std::string& parent, const std::string& child,
                                                         const Pose& pose);
/// Frame name of a robot's link: as in the description; with `several` robots, with the robot's name in
/// front.
std::string frame_of(const cell::CellRobot& robot, int link, bool several);

/// Messages about the robots of one cell. Names are resolved to indices in the constructor (cell thread).
/// After that, any one thread may fill messages from the states of a cycle; only the first call allocates.
/// Names of frames and joints are those of the description; with several robots, "ROBOT/" stands in front. m,
/// rad.
class StateMessages {
 public:
  /// The robots must outlive this. `drives`: by robot, true if its base moves, so that its root frame is not
  /// fixed to the world. Missing entries mean false.
  StateMessages(const cell::CellRobots& robots, const hardware::InterfaceTable& table,
                const std::vector<bool>& drives = {});

  /// All joints with a measured position. Velocity and effort are included if any joint has them (NaN for
  /// joints without).
  const messages::sensor_msgs::msg::JointState& joint_states(std::span<const double> states,
                                                             std::int64_t stamp);
  /// The fixed frames: /tf_static.
  const messages::tf2_msgs::msg::TFMessage& fixed_frames() const { return fixed_; }
  /// One frame per movable joint: /tf. A joint whose position is unknown is shown at zero.
  const messages::tf2_msgs::msg::TFMessage& moving_frames(std::span<const double> states, std::int64_t stamp);

 private:
  struct Measured {
    int position = -1, velocity = -1, effort = -1;  ///< indices of states; -1: none
  };
  struct Moving {
    const description::Joint* joint;
    int state;  ///< index of the state with its position; -1: none
  };
  void add_robot(const cell::CellRobot& robot, const cell::CellRobot* carrier,
                 const hardware::InterfaceTable& table, bool several, bool drives);

  messages::sensor_msgs::msg::JointState joints_;
  std::vector<Measured> measured_;
  messages::tf2_msgs::msg::TFMessage fixed_, frames_;
  std::vector<Moving> moving_;
};

}  // namespace polyarm::recording
