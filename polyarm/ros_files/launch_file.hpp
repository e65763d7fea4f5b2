#pragma once
/// What a launch file of ROS 1 says that a cell has: description, parameters, controllers to start. The rest
/// is listed by line as not applicable. docs/ros-controllers-files.md says what is followed.
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/launch/launch_substitution.hpp"
#include "polyarm/ros_files/controllers_file.hpp"
#include "polyarm/ros_files/parameter_file.hpp"

namespace polyarm::ros_files {

/// An <arg> of the launch file that was named, for a list of what can be set.
struct LaunchArg {
  std::string name, doc;
  std::string value;      ///< as it stands after all
  bool fixed = false;     ///< it has a value= and cannot be set from outside
  bool required = false;  ///< it has no default
  Location where;
};

/// A robot_description, or robot_description_semantic (SRDF).
struct LaunchedDescription {
  std::string parameter;       ///< its whole name: "/MyRobot/robot_description"
  std::filesystem::path file;  ///< URDF, SRDF or xacro; empty where the text stands in the launch file
  bool xacro = false;          ///< `file` is expanded with `arguments`
  std::vector<std::pair<std::string, std::string>> arguments;  ///< NAME:=VALUE, in their order
  std::string text;
  Location where;
};

/// A controller that a spawner starts.
struct SpawnedController {
  std::string name, ns;  ///< "JointA_EffortController", "/MyRobot"
  bool stopped = false;  ///< loaded, and left inactive
  Location where;
  std::string full_name() const { return ns == "/" ? "/" + name : ns + "/" + name; }
};

/// An element that means nothing to a cell, in one sentence.
struct NotApplicable {
  Location where;
  std::string what;  ///< "'rviz' (rviz/rviz) is a ROS node"
};

struct LaunchedCell {
  std::vector<LaunchArg> args;
  std::vector<LaunchedDescription> descriptions;  ///< in their order; usually one
  std::vector<LaunchedDescription> semantics;     ///< SRDF
  std::vector<ParameterSource> parameters;        ///< YAML and single values, later over earlier
  std::vector<SpawnedController> spawned;
  std::vector<NotApplicable> not_applicable;
};

/// Reads a launch file and what it includes. `args` are its NAME:=VALUE; `find` tells where ROS packages are.
/// What is wrong becomes a problem with file, line and the chain of includes; throws Error when the file
/// itself cannot be read, is no launch file, or is one of ROS 2.
LaunchedCell read_launch_file(const std::filesystem::path& path,
                              const std::map<std::string, std::string>& args, const PackageSearch& find,
                              Problems& problems);

/// The controllers of a launched cell: with its parameters, each marked as spawned, stopped or neither. A
/// spawner that names a controller without a type is an error at its line. Throws as read_controllers does.
ControllersFile read_controllers(const LaunchedCell& cell, Problems& problems);

}  // namespace polyarm::ros_files
