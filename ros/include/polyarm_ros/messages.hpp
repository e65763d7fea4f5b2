#pragma once
/// Polyarm's messages for controllers as messages of ROS, and results of goals as Polyarm's events.
#include <cstring>
#include <functional>
#include <string>
#include <typeinfo>
#include <variant>
#include <vector>

#include "control_msgs/action/follow_joint_trajectory.hpp"
#include "control_msgs/action/gripper_command.hpp"
#include "control_msgs/action/parallel_gripper_command.hpp"
#include "control_msgs/msg/dynamic_interface_group_values.hpp"
#include "control_msgs/msg/dynamic_joint_state.hpp"
#include "control_msgs/msg/multi_dof_command.hpp"
#include "geometry_msgs/msg/twist.hpp"
#include "geometry_msgs/msg/twist_stamped.hpp"
#include "polyarm/controllers/messages.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/time.hpp"
#include "std_msgs/msg/float64.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"
#include "trajectory_msgs/msg/joint_trajectory.hpp"

namespace polyarm_ros {

namespace pc = ::polyarm::controllers;

/// ROS time of cell time; joints without the robot's name.
struct Naming {
  std::int64_t epoch = 0;
  std::string robot;
  std::string local(const std::string& name) const {
    const std::string prefix = robot + "/";
    return !robot.empty() && name.compare(0, prefix.size(), prefix) == 0 ? name.substr(prefix.size()) : name;
  }
  builtin_interfaces::msg::Time stamp(polyarm::Nanoseconds cell) const {
    return rclcpp::Time(epoch + cell, RCL_ROS_TIME);
  }
};

inline builtin_interfaces::msg::Duration span(double seconds) {
  return rclcpp::Duration::from_seconds(seconds);
}

inline trajectory_msgs::msg::JointTrajectory to_ros(const pc::TrajectoryMessage& from, const Naming& names) {
  trajectory_msgs::msg::JointTrajectory out;
  if (from.start) out.header.stamp = names.stamp(*from.start);
  for (const std::string& joint : from.joints) out.joint_names.push_back(names.local(joint));
  for (const auto& p : from.points) {
    trajectory_msgs::msg::JointTrajectoryPoint point;
    point.positions = p.positions, point.velocities = p.velocities;
    point.accelerations = p.accelerations, point.effort = p.effort;
    point.time_from_start = span(p.time_from_start);
    out.points.push_back(std::move(point));
  }
  return out;
}
inline control_msgs::msg::JointTolerance to_ros(const pc::JointTolerance& from, const Naming& names) {
  control_msgs::msg::JointTolerance out;
  out.name = names.local(from.joint);
  out.position = from.position, out.velocity = from.velocity, out.acceleration = from.acceleration;
  return out;
}
inline control_msgs::action::FollowJointTrajectory::Goal goal_to_ros(const pc::TrajectoryMessage& from,
                                                                      const Naming& names) {
  control_msgs::action::FollowJointTrajectory::Goal out;
  out.trajectory = to_ros(from, names);
  for (const auto& each : from.path_tolerance) out.path_tolerance.push_back(to_ros(each, names));
  for (const auto& each : from.goal_tolerance) out.goal_tolerance.push_back(to_ros(each, names));
  if (from.goal_time_tolerance) out.goal_time_tolerance = span(*from.goal_time_tolerance);
  return out;
}
inline geometry_msgs::msg::Twist to_ros(const pc::Twist& from) {
  geometry_msgs::msg::Twist out;
  out.linear.x = from.linear.x, out.linear.y = from.linear.y, out.linear.z = from.linear.z;
  out.angular.x = from.angular.x, out.angular.y = from.angular.y, out.angular.z = from.angular.z;
  return out;
}

/// One kind of message: its names in Polyarm, its type in ROS, and how it is handed on. `hand` is false if the
/// input is another kind.
struct Conversion {
  const char* name;
  const std::type_info* type;
  std::function<bool(const pc::Input&, const Naming&, const std::function<void(const void*)>&)> hand;
};
template <typename From, typename To, typename Make>
Conversion conversion(const char* name, Make make) {
  return {name, &typeid(To), [make](const pc::Input& input, const Naming& names, const auto& take) {
            const From* from = std::get_if<From>(&input);
            if (!from) return false;
            const To message = make(*from, names);
            take(&message);
            return true;
          }};
}

inline const std::vector<Conversion>& conversions() {
  using geometry_msgs::msg::TwistStamped;
  static const std::vector<Conversion> all = {
      conversion<pc::Numbers, std_msgs::msg::Float64MultiArray>(
          "std_msgs/Float64MultiArray",
          [](const pc::Numbers& from, const Naming&) {
            std_msgs::msg::Float64MultiArray out;
            out.data = from.values;
            return out;
          }),
      conversion<pc::Numbers, std_msgs::msg::Float64>("std_msgs/Float64",
                                                      [](const pc::Numbers& from, const Naming&) {
                                                        std_msgs::msg::Float64 out;
                                                        if (!from.values.empty())
                                                          out.data = from.values.front();
                                                        return out;
                                                      }),
      conversion<pc::Twist, TwistStamped>("geometry_msgs/TwistStamped",
                                          [](const pc::Twist& from, const Naming& names) {
                                            TwistStamped out;
                                            out.twist = to_ros(from);
                                            if (from.stamp) out.header.stamp = names.stamp(*from.stamp);
                                            return out;
                                          }),
      conversion<pc::Twist, geometry_msgs::msg::Twist>(
          "geometry_msgs/Twist", [](const pc::Twist& from, const Naming&) { return to_ros(from); }),
      conversion<pc::TrajectoryMessage, trajectory_msgs::msg::JointTrajectory>(
          "trajectory_msgs/JointTrajectory",
          [](const pc::TrajectoryMessage& from, const Naming& names) { return to_ros(from, names); }),
      conversion<pc::NamedValues, control_msgs::msg::MultiDOFCommand>(
          "control_msgs/MultiDOFCommand",
          [](const pc::NamedValues& from, const Naming& names) {
            control_msgs::msg::MultiDOFCommand out;
            for (const std::string& name : from.names) out.dof_names.push_back(names.local(name));
            out.values = from.values;
            return out;
          }),
      conversion<pc::TrajectoryMessage, control_msgs::action::FollowJointTrajectory::Goal>(
          "control_msgs/FollowJointTrajectory",
          [](const pc::TrajectoryMessage& from, const Naming& names) { return goal_to_ros(from, names); }),
      conversion<pc::GripperCommand, control_msgs::action::GripperCommand::Goal>(
          "control_msgs/GripperCommand",
          [](const pc::GripperCommand& from, const Naming&) {
            control_msgs::action::GripperCommand::Goal out;
            out.command.position = from.position;
            out.command.max_effort = from.max_effort.value_or(0);
            return out;
          }),
      conversion<pc::GripperCommand, control_msgs::action::ParallelGripperCommand::Goal>(
          "control_msgs/ParallelGripperCommand",
          [](const pc::GripperCommand& from, const Naming&) {
            control_msgs::action::ParallelGripperCommand::Goal out;
            out.command.position = {from.position};
            if (from.max_velocity) out.command.velocity = {*from.max_velocity};
            if (from.max_effort) out.command.effort = {*from.max_effort};
            return out;
          })};
  return all;
}
inline const Conversion* find_conversion(const std::type_info& type) {
  for (const Conversion& each : conversions())
    if (*each.type == type) return &each;
  return nullptr;
}

/// What the result of a goal of the type says, in Polyarm's codes.
inline void read_result(const std::type_info& goal, const void* result, pc::GoalEvent& out) {
  using Follow = control_msgs::action::FollowJointTrajectory;
  using Gripper = control_msgs::action::GripperCommand;
  using Parallel = control_msgs::action::ParallelGripperCommand;
  if (goal == typeid(Follow::Goal)) out.code = static_cast<const Follow::Result*>(result)->error_code;
  if (goal == typeid(Gripper::Goal)) {
    const auto& r = *static_cast<const Gripper::Result*>(result);
    out.gripper = pc::GripperResult{r.position, r.effort, r.stalled, r.reached_goal};
  }
  if (goal == typeid(Parallel::Goal)) {
    const auto& r = *static_cast<const Parallel::Result*>(result);
    out.gripper = pc::GripperResult{r.state.position.empty() ? 0 : r.state.position[0],
                                    r.state.effort.empty() ? 0 : r.state.effort[0], r.stalled,
                                    r.reached_goal};
  }
}

}  // namespace polyarm_ros
