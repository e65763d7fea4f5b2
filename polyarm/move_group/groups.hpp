#pragma once
/// The planning groups of a robot, as MoveIt's SRDF names them, and the controllers that move their joints.
/// Any thread.
#include <string>
#include <vector>

#include "polyarm/control/controller_manager.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::move_group {

/// A controller that accepts trajectories or gripper goals.
struct Actor {
  std::string name, type, action;   ///< "arm_controller", "FollowJointTrajectory", "follow_joint_trajectory"
  std::vector<std::string> joints;  ///< the robot's joints, in the controller's order
  bool active = false;
  bool gripper() const { return type != "FollowJointTrajectory"; }
};

/// "arm/elbow_joint/position" → "elbow_joint" for robot `arm`; "" for another robot.
std::string joint_of(const std::string& interface, const std::string& robot);

/// The controllers that move joints of this robot.
std::vector<Actor> actors_of(const control::ControllerManager& controllers, const std::string& robot);

/// The joints from the root to the tool's mounting link, including fixed ones.
std::vector<int> joints_to_tool(const description::RobotModel& model);

/// Leaves the groups of a description as they are. A model without any gets the arm up to its tool, named
/// `arm`, and the joints of each gripper as an end effector.
void add_groups(description::RobotModel& model, const std::string& arm, const std::vector<Actor>& actors);

/// True if the joints of the group are one chain with at least three that move, so that it has an inverse.
bool has_chain(const description::RobotModel& model, const description::GroupInfo& group);

}  // namespace polyarm::move_group
