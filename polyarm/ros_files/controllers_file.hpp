#pragma once
/// Controllers YAML of every generation: `ros__parameters` under node names as ROS 2 has it, and the plain
/// names of ROS 1. docs/ros-controllers-files.md says which keys there are.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/ros_files/manager_parameters.hpp"
#include "polyarm/ros_files/parameter_file.hpp"

namespace polyarm::ros_files {

/// How a controller with `is_async: true` runs beside the cycle.
struct AsyncParameters {
  double thread_priority = 50;       ///< 0 to 99
  std::vector<double> cpu_affinity;  ///< cores; empty: any
  std::string scheduling_policy = "synchronized";
  bool print_warnings = true;
};

struct ControllerEntry {
  std::string name;  ///< without namespace
  std::string type;  ///< "joint_trajectory_controller/JointTrajectoryController"
  /// Its own parameters. `type`, `update_rate`, `is_async` and `async_parameters` are taken out of them in a
  /// ROS 2 file; in a ROS 1 file only `type`.
  controllers::Parameters parameters;
  Location where;        ///< of its type
  std::string ns = "/";  ///< "/" or "/MyRobot"
  bool ros1 = false;
  double update_rate = 0;  ///< Hz; 0: that of the manager
  bool is_async = false;
  AsyncParameters async;
  std::vector<std::string> fallback_controllers;
  std::vector<std::string> params_files;  ///< already read into `parameters`
  std::vector<std::string> node_options_args;
  bool spawned = true;   ///< false: a launch file loads its parameters and starts it nowhere
  bool stopped = false;  ///< loaded and configured, and left inactive
  /// "/MyRobot/JointA_EffortController", as its topics begin.
  std::string full_name() const { return ns == "/" ? "/" + name : ns + "/" + name; }
};

struct ControllersFile {
  double update_rate = 0;     ///< Hz; 0: not stated. From the manager, or `loop_hz` of a ROS 1 file
  ManagerParameters manager;  ///< the first of the file
  std::vector<ControllerEntry> controllers;  ///< in the order of the files
  std::vector<JointLimitsSource> joint_limits;
  controllers::Parameters pid_gains;  ///< gazebo_ros_control/pid_gains: "elbow_joint.p" → 100
  std::vector<UnusedKey> unused;      ///< understood, and without effect here
};

/// Reads one file. What is wrong in it is added to `problems` as error or warning with its place; throws
/// Error when nothing can be read at all.
ControllersFile read_controllers_file(const std::filesystem::path& path, Problems& problems);

/// Several files as one: a later value replaces an earlier one key by key, as with the parameters of ROS.
/// `substitution`: what $(var …) in them stands for.
ControllersFile read_controllers_files(const std::vector<std::filesystem::path>& paths, Problems& problems,
                                       const ParameterSubstitution& substitution = {});

/// The same for what a launch file loads.
ControllersFile read_controllers(const std::vector<ParameterSource>& sources, Problems& problems);

}  // namespace polyarm::ros_files
