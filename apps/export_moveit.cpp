#include "apps/export_moveit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/plain_urdf.hpp"
#include "polyarm/description/srdf.hpp"
#include "polyarm/hulls/robot_bodies.hpp"
#include "polyarm/move_group/groups.hpp"

namespace polyarm::apps {

namespace {

using description::GroupInfo;
using description::Joint;
using description::RobotModel;
using move_group::Actor;
using move_group::joint_of;

const Joint& joint_at(const RobotModel& model, int index) {
  return model.joints[static_cast<std::size_t>(index)];
}

/// Always with a decimal point, because some YAML readers distinguish integers from floats.
std::string decimal(double value) {
  const std::string text = format_number(value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string kinematics_yaml(const RobotModel& model) {
  std::string out;
  for (const GroupInfo& group : model.groups)
    if (move_group::has_chain(model, group))
      out += fmt::format(
          "{}:\n  kinematics_solver: kdl_kinematics_plugin/KDLKinematicsPlugin\n"
          "  kinematics_solver_search_resolution: 0.005\n  kinematics_solver_timeout: 0.05\n",
          group.name);
  return out.empty() ? "{}\n" : out;
}

std::string joint_limits_yaml(const RobotModel& model) {
  std::string out =
      "default_velocity_scaling_factor: 1.0\ndefault_acceleration_scaling_factor: 1.0\njoint_limits:\n";
  for (const int index : model.actuated) {
    const Joint& joint = joint_at(model, index);
    const auto limit = [&](const char* name, const std::optional<double>& value) {
      out += fmt::format("    has_{0}_limits: {1}\n    max_{0}: {2}\n", name, value ? "true" : "false",
                         decimal(value.value_or(0)));
    };
    out += "  " + joint.name + ":\n";
    limit("velocity", joint.limits.velocity);
    limit("acceleration", joint.limits.acceleration);
    if (joint.limits.acceleration)
      out += "    has_deceleration_limits: true\n    max_deceleration: " +
             decimal(-joint.limits.deceleration.value_or(*joint.limits.acceleration)) + "\n";
    if (joint.limits.jerk) limit("jerk", joint.limits.jerk);
  }
  return out;
}

std::string controllers_yaml(const std::vector<Actor>& actors) {
  std::vector<std::string> names;
  std::string each;
  for (const Actor& actor : actors) {
    names.push_back(actor.name);
    each += fmt::format("  {}:\n    type: {}\n    action_ns: {}\n    default: true\n    joints: [{}]\n",
                        actor.name, actor.type, actor.action, join(actor.joints, ", "));
  }
  return fmt::format(
      "moveit_controller_manager: moveit_simple_controller_manager/MoveItSimpleControllerManager\n"
      "moveit_manage_controllers: true\n"
      "trajectory_execution:\n"
      "  allowed_execution_duration_scaling: 1.2\n  allowed_goal_duration_margin: 0.5\n"
      "  allowed_start_tolerance: 0.01\n"
      "moveit_simple_controller_manager:\n  controller_names: [{}]\n{}",
      join(names, ", "), each);
}

/// The controllers as a ROS 2 controller manager would load them, if the cell has no controllers' file: those
/// whose joints are in the description.
std::string own_controllers_yaml(const cell::CellView& cell, const cell::CellRobot& robot) {
  const double rate = 1e9 / static_cast<double>(cell.period());
  std::string manager =
      fmt::format("controller_manager:\n  ros__parameters:\n    update_rate: {:.0f}\n", rate);
  std::string each;
  for (const control::ListedController& c : cell.controllers().list()) {
    std::vector<std::string> joints;
    std::set<std::string> interfaces;
    bool known = true;
    for (const std::string& interface : c.required_commands) {
      const std::string joint = joint_of(interface, robot.entry.name);
      known &= robot.model.find_joint(joint) >= 0;
      if (!std::count(joints.begin(), joints.end(), joint)) joints.push_back(joint);
      interfaces.insert(interface.substr(interface.rfind('/') + 1));
    }
    if (!known) continue;
    manager += fmt::format("    {}: {{type: {}}}\n", c.name, c.type);
    if (joints.empty()) continue;
    each += fmt::format("{}:\n  ros__parameters:\n    joints: [{}]\n", c.name, join(joints, ", "));
    each += c.type == "forward_command_controller/ForwardCommandController"
                ? fmt::format("    interface_name: {}\n", *interfaces.begin())
                : fmt::format("    command_interfaces: [{}]\n    state_interfaces: [position, velocity]\n",
                              join(std::vector<std::string>(interfaces.begin(), interfaces.end()), ", "));
  }
  return manager + each;
}

constexpr const char* kAdapters = R"(request_adapters:
  - default_planning_request_adapters/ResolveConstraintFrames
  - default_planning_request_adapters/ValidateWorkspaceBounds
  - default_planning_request_adapters/CheckStartStateBounds
  - default_planning_request_adapters/CheckStartStateCollision
response_adapters:
)";
constexpr const char* kValidate =
    "  - default_planning_response_adapters/ValidateSolution\n"
    "  - default_planning_response_adapters/DisplayMotionPath\n";

std::string ompl_yaml(const RobotModel& model) {
  constexpr const char* kPlanners[] = {"RRTConnect", "RRT", "RRTstar", "PRM", "EST", "BiTRRT"};
  std::string out = "planning_plugins: [ompl_interface/OMPLPlanner]\n" + std::string(kAdapters) +
                    "  - default_planning_response_adapters/AddTimeOptimalParameterization\n" + kValidate +
                    "planner_configs:\n";
  std::vector<std::string> names;
  for (const std::string name : kPlanners) {
    out += fmt::format("  {0}: {{type: geometric::{0}}}\n", name);
    names.push_back(name);
  }
  for (const GroupInfo& group : model.groups)
    out += fmt::format(
        "{}:\n  default_planner_config: {}\n  planner_configs: [{}]\n  longest_valid_segment_fraction: "
        "0.005\n",
        group.name, names.front(), join(names, ", "));
  return out;
}

/// Pilz needs velocity and acceleration limits of all joints.
bool pilz_can_plan(const RobotModel& model) {
  return std::all_of(model.actuated.begin(), model.actuated.end(), [&](int index) {
    const description::JointLimits& limits = joint_at(model, index).limits;
    return limits.velocity && limits.acceleration;
  });
}

std::string pilz_yaml() {
  return std::string(
             "planning_plugins: [pilz_industrial_motion_planner/CommandPlanner]\n"
             "default_planner_config: PTP\n") +
         kAdapters + kValidate +
         "capabilities: pilz_industrial_motion_planner/MoveGroupSequenceAction "
         "pilz_industrial_motion_planner/MoveGroupSequenceService\n";
}

/// Limits of lines and arcs, as in the cell's own planner.
std::string cartesian_limits_yaml(const cell::CellView& cell) {
  const moves::TcpLimits& tcp = cell.file().motion.tcp;
  return fmt::format(
      "cartesian_limits:\n  max_trans_vel: {}\n  max_trans_acc: {}\n  max_trans_dec: {}\n  max_rot_vel: "
      "{}\n",
      decimal(tcp.speed), decimal(tcp.acceleration), decimal(-tcp.acceleration), decimal(tcp.turn_speed));
}

constexpr const char* kLaunch =
    R"(# ros2 launch ./moveit.launch.py beside a running cell: polyarm run CELL --ros2
from pathlib import Path

import yaml
from launch import LaunchDescription
from launch_ros.actions import Node

here = Path(__file__).resolve().parent


def read(name):
    return yaml.safe_load((here / name).read_text()) or {{}}


def generate_launch_description():
    description = {{"robot_description": (here / "robot.urdf").read_text()}}
    semantic = {{"robot_description_semantic": (here / "robot.srdf").read_text()}}
    kinematics = {{"robot_description_kinematics": read("kinematics.yaml")}}
    limits = {{"robot_description_planning": read("joint_limits.yaml")}}
    planning = {{
        "planning_pipelines": ["ompl"],
        "default_planning_pipeline": "ompl",
        "ompl": read("ompl_planning.yaml"),
    }}
    if (here / "pilz_industrial_motion_planner_planning.yaml").exists():
        pilz = read("pilz_industrial_motion_planner_planning.yaml")
        planning["planning_pipelines"].append("pilz_industrial_motion_planner")
        planning["pilz_industrial_motion_planner"] = pilz
        planning["capabilities"] = pilz["capabilities"]
        limits["robot_description_planning"].update(read("pilz_cartesian_limits.yaml"))
    scene = {{
        "publish_planning_scene": True,
        "publish_geometry_updates": True,
        "publish_state_updates": True,
        "publish_transforms_updates": True,
        "publish_robot_description_semantic": True,
    }}
    common = [description, semantic, kinematics, limits]
    return LaunchDescription([
        Node(package="moveit_ros_move_group", executable="move_group", output="screen",
             parameters=common + [planning, scene, read("moveit_controllers.yaml")],
             remappings=[("joint_states", "{joint_states}")]),
        Node(package="rviz2", executable="rviz2", output="log", parameters=common + [planning]),
    ])
)";

bool is_at_origin(const Pose& pose) {
  return pose.position.x == 0 && pose.position.y == 0 && pose.position.z == 0 &&
         std::abs(pose.rotation.w) == 1;
}

/// Adds a world link to the description if the robot's base is not at the origin.
std::string in_world(std::string urdf, const RobotModel& model, const Pose& base) {
  const std::string& root = model.links[static_cast<std::size_t>(model.root)].name;
  if (is_at_origin(base) || root == "world") return urdf;
  const Vec3 rpy = to_rpy(base.rotation);
  const std::size_t begin = urdf.find('>', urdf.find("<robot")) + 1;
  urdf.insert(begin,
              fmt::format("\n    <link name=\"world\"/>\n    <joint name=\"world_to_{0}\" type=\"fixed\">"
                          "<parent link=\"world\"/><child link=\"{0}\"/><origin xyz=\"{1} {2} {3}\" "
                          "rpy=\"{4} {5} {6}\"/></joint>",
                          root, base.position.x, base.position.y, base.position.z, rpy.x, rpy.y, rpy.z));
  return urdf;
}

}  // namespace

MoveItFiles moveit_files(const cell::CellView& cell, std::size_t index, int samples) {
  const cell::CellRobot& robot = *cell.robots()[index];
  RobotModel model = robot.model;
  const std::vector<Actor> actors = move_group::actors_of(cell.controllers(), robot.entry.name);
  move_group::add_groups(model, robot.entry.name, actors);
  hulls::make_bodies(model, hulls::bodies_cache());
  const auto pairs = description::needless_pairs(model, samples);
  MoveItFiles out;
  const Pose& base = robot.entry.base;
  out.texts["robot.urdf"] = in_world(description::write_plain_urdf(model), model, base);
  out.texts["robot.srdf"] = description::write_srdf(model, pairs, is_at_origin(base));
  out.texts["kinematics.yaml"] = kinematics_yaml(model);
  out.texts["joint_limits.yaml"] = joint_limits_yaml(model);
  out.texts["ompl_planning.yaml"] = ompl_yaml(model);
  if (pilz_can_plan(model)) {
    out.texts["pilz_industrial_motion_planner_planning.yaml"] = pilz_yaml();
    out.texts["pilz_cartesian_limits.yaml"] = cartesian_limits_yaml(cell);
  }
  out.texts["moveit_controllers.yaml"] = controllers_yaml(actors);
  const std::string of = cell.robots().size() == 1 ? "" : "/" + robot.entry.name;
  out.texts["moveit.launch.py"] = fmt::format(kLaunch, fmt::arg("joint_states", of + "/joint_states"));
  const auto& files = cell.file().controllers;
  for (std::size_t i = 0; i < files.size(); ++i)
    out.texts[files.size() == 1 ? "ros2_controllers.yaml" : fmt::format("ros2_controllers_{}.yaml", i + 1)] =
        read_file(cell.file().folder / files[i]);
  if (files.empty()) out.texts["ros2_controllers.yaml"] = own_controllers_yaml(cell, robot);
  std::vector<std::string> without;
  for (const int joint : model.actuated)
    if (!joint_at(model, joint).limits.acceleration) without.push_back(joint_at(model, joint).name);
  if (!without.empty())
    out.notes.push_back("no limit of acceleration is known of " + join(without, ", ") +
                        ": MoveIt takes 1 rad/s² for each");
  if (std::none_of(actors.begin(), actors.end(), [](const Actor& a) { return !a.gripper(); }))
    out.notes.push_back("no controller of '" + robot.entry.name +
                        "' follows joint trajectories, so MoveIt can plan and not move");
  std::size_t shaped = 0;
  for (const description::Link& link : model.links) shaped += link.collisions.empty() ? 0 : 1;
  if (shaped < 2) out.notes.push_back("the description has no shapes to collide: nothing was compared");
  return out;
}

}  // namespace polyarm::apps
