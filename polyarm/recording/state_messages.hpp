#pragma once
/// Where everything is, as messages of ROS 2 say it: joints and frames out of the states of a cycle.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/hardware/interface_table.hpp"
#include "polyarm/messages/types.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::recording {

/// A time of ROS from nanoseconds.
messages::builtin_interfaces::msg::Time stamp_of(std::int64_t nanoseconds);

/// A frame in another, without a time.
messages::geometry_msgs::msg::TransformStamped transform(const std::string& parent, const std::string& child,
                                                         const Pose& pose);
/// What a robot's link is called among frames: as in the description; of several with the robot's name.
std::string frame_of(const cell::CellRobot& robot, int link, bool several);

/// Messages about one cell's robots. Names become indices when it is made (cell thread), so that any one
/// thread may fill messages from the states of whatever cycle it has; no allocation after the first time.
/// Frames and joints are called as in the description; with several robots the robot's name and a slash
/// stand before. Lengths in m, angles in rad.
class StateMessages {
 public:
  /// The robots must outlive it. `drives`: which of them have a base that moves, whose frame is not fixed to
  /// the world; shorter: the rest have none.
  StateMessages(const cell::CellRobots& robots, const hardware::InterfaceTable& table,
                const std::vector<bool>& drives = {});

  /// Every joint that is measured, with velocity and effort where any joint has them (a number that is none
  /// where this one has not).
  const messages::sensor_msgs::msg::JointState& joint_states(std::span<const double> states,
                                                             std::int64_t stamp);
  /// What never moves: /tf_static.
  const messages::tf2_msgs::msg::TFMessage& fixed_frames() const { return fixed_; }
  /// A frame for each joint that moves: /tf. A joint whose position is not known stands at zero.
  const messages::tf2_msgs::msg::TFMessage& moving_frames(std::span<const double> states, std::int64_t stamp);

 private:
  struct Measured {
    int position = -1, velocity = -1, effort = -1;  ///< states; -1: there is none
  };
  struct Moving {
    const description::Joint* joint;
    int state;  ///< whose value it has; -1: none
  };
  void add_robot(const cell::CellRobot& robot, const cell::CellRobot* carrier,
                 const hardware::InterfaceTable& table, bool several, bool drives);

  messages::sensor_msgs::msg::JointState joints_;
  std::vector<Measured> measured_;
  messages::tf2_msgs::msg::TFMessage fixed_, frames_;
  std::vector<Moving> moving_;
};

}  // namespace polyarm::recording
