#pragma once
/// Reads controllers YAML of ROS 2 (`ros__parameters` under node names) and of ROS 1 (plain names). The keys
/// are listed in docs/ros-controllers-files.md.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/controllers/controller.hpp"
#include "polyarm/ros_files/manager_parameters.hpp"
#include "polyarm/ros_files/parameter_file.hpp"

namespace polyarm::ros_files {

/// Options of a controller with `is_async: true`, which runs beside the cycle.
struct AsyncParameters {
  double thread_priority = 50;       ///< 0 to 99
  std::vector<double> cpu_affinity;  ///< cores; empty: any
  std::string scheduling_policy = "synchronized";
  bool print_warnings = true;
};

struct ControllerEntry {
  std::string name;  ///< without namespace
  std::string type;  ///< "joint_trajectory_controller/JointTrajectoryController"
  /// The controller's own parameters. Removed from them: `type`, `update_rate`, `is_async` and
  /// `async_parameters` in a ROS 2 file, `type` in a ROS 1 file.
  controllers::Parameters parameters;
  Location where;        ///< of the type
  std::string ns = "/";  ///< "/" or "/MyRobot"
  bool ros1 = false;
  double update_rate = 0;  ///< Hz; 0: the rate of the manager
  bool is_async = false;
  AsyncParameters async;
  std::vector<std::string> fallback_controllers;
  std::vector<std::string> params_files;  ///< already read into `parameters`
  std::vector<std::string> node_options_args;
  bool spawned = true;   ///< false: a launch file loads its parameters but does not start it
  bool stopped = false;  ///< loaded and configured, but left inactive
  /// "/MyRobot/JointA_EffortController"; its topics begin with this.
  std::string full_name() const { return ns == "/" ? "/" + name : ns + "/" + name; }
};

struct ControllersFile {
  double update_rate = 0;     ///< Hz; 0: not given. From the manager, or from `loop_hz` in a ROS 1 file
  ManagerParameters manager;  ///< the first manager in the file
  std::vector<ControllerEntry> controllers;  ///< in the order of the files
  std::vector<JointLimitsSource> joint_limits;
  controllers::Parameters pid_gains;  ///< gazebo_ros_control/pid_gains: "elbow_joint.p" → 100
  std::vector<UnusedKey> unused;      ///< known keys that have no effect here
};

/// Reads one file. Mistakes in it are added to `problems`, as errors or warnings with their location. Throws
/// Error if nothing can be read.
ControllersFile read_controllers_file(const std::filesystem::path& path, Problems& problems);

/// Reads several files as one: a later value replaces an earlier one, key by key, as in ROS. `substitution`:
/// the values for $(var …) in the files.
ControllersFile read_controllers_files(const std::vector<std::filesystem::path>& paths, Problems& problems,
                                       const ParameterSubstitution& substitution = {});

/// The same for the parameters that a launch file loads.
ControllersFile read_controllers(const std::vector<ParameterSource>& sources, Problems& problems);

}  // namespace polyarm::ros_files
