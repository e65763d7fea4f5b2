#pragma once
/// Reads a ROS 1 launch file for what a cell needs: description, parameters, and controllers to start.
/// Everything else is listed by line as not applicable. docs/ros-controllers-files.md lists what is
/// supported.
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

/// An <arg> of the top-level launch file, to list what can be set.
struct LaunchArg {
  std::string name, doc;
  std::string value;      ///< final value
  bool fixed = false;     ///< has a value= and cannot be set from outside
  bool required = false;  ///< has no default
  Location where;
};

/// A robot_description, or robot_description_semantic (SRDF).
struct LaunchedDescription {
  std::string parameter;       ///< full name: "/MyRobot/robot_description"
  std::filesystem::path file;  ///< URDF, SRDF or xacro; empty if the text is in the launch file
  bool xacro = false;          ///< expand `file` with `arguments`
  std::vector<std::pair<std::string, std::string>> arguments;  ///< NAME:=VALUE, in order
  std::string text;
  Location where;
};

/// A controller that a spawner starts.
struct SpawnedController {
  std::string name, ns;  ///< "JointA_EffortController", "/MyRobot"
  bool stopped = false;  ///< loaded, but left inactive
  Location where;
  std::string full_name() const { return ns == "/" ? "/" + name : ns + "/" + name; }
};

/// An element without meaning for a cell, with one sentence about it.
struct NotApplicable {
  Location where;
  std::string what;  ///< "'rviz' (rviz/rviz) is a ROS node"
};

struct LaunchedCell {
  std::vector<LaunchArg> args;
  std::vector<LaunchedDescription> descriptions;  ///< in order; usually one
  std::vector<LaunchedDescription> semantics;     ///< SRDF
  std::vector<ParameterSource> parameters;        ///< YAML and single values; later ones override earlier
                                                  ///< ones
  std::vector<SpawnedController> spawned;
  std::vector<NotApplicable> not_applicable;
};

/// Reads a launch file and the files it includes. `args` are NAME:=VALUE; `find` locates ROS packages.
/// Mistakes become problems with file, line and the chain of includes. Throws Error if the file itself cannot
/// be read, is not a launch file, or is one of ROS 2.
LaunchedCell read_launch_file(const std::filesystem::path& path,
                              const std::map<std::string, std::string>& args, const PackageSearch& find,
                              Problems& problems);

/// The controllers of a launched cell with its parameters; each one is marked as spawned, stopped or neither.
/// A spawner that names a controller without a type is an error at its line. Throws as the other
/// read_controllers() does.
ControllersFile read_controllers(const LaunchedCell& cell, Problems& problems);

}  // namespace polyarm::ros_files
