#pragma once
/// Reads a ROS 2 launch file in Python, XML or YAML for what is written in it literally: argument defaults,
/// the description and how it is expanded, parameter files, spawned controllers, and included launch files.
/// The files are read as text; no Python is run. Loops over literal lists, conditions with known values and
/// functions of the same file are followed. What is computed (by functions of other modules) is listed as not
/// taken.
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/launch/launch_substitution.hpp"

namespace polyarm::ros_files {

struct PythonLaunchArgument {
  std::string name;
  std::string value;                 ///< value from outside, else the default
  bool known = false;                ///< false: no default, or a computed one
  bool given = false;                ///< value comes from outside
  std::vector<std::string> choices;  ///< empty: any value
};

/// A NAME:=VALUE that the user must provide.
struct PythonLaunchNeed {
  std::string name;
  std::string argument;  ///< argument of the launch file that sets it; empty: it is computed
  bool operator==(const PythonLaunchNeed&) const = default;
};

struct PythonLaunchDescription {
  std::filesystem::path file;
  std::vector<std::pair<std::string, std::string>> arguments;  ///< NAME:=VALUE for xacro, in order
  std::vector<PythonLaunchNeed> unknown;  ///< xacro arguments with unknown values
  Location where;
};

struct PythonLaunchFile {
  std::filesystem::path file;
  Location where;
};

struct PythonLaunch {
  std::vector<PythonLaunchArgument> arguments;
  /// From `xacro` and `cat` commands, xacro.process_file, open(), MoveItConfigsBuilder and
  /// robot_state_publisher.
  std::vector<PythonLaunchDescription> descriptions;
  std::vector<PythonLaunchFile> parameters;   ///< YAML files given to nodes
  std::vector<std::string> spawned;           ///< controllers that are started, as far as known
  bool spawned_known = true;                  ///< false: there may be more or fewer
  std::vector<std::string> missing_packages;  ///< packages of named files that were not found
  /// What could not be read: "the value of use_fake_hardware is computed".
  std::vector<std::pair<Location, std::string>> not_taken;

  /// Values for `$(var NAME)` in the parameter files, from arguments of the launch file.
  std::vector<std::pair<std::string, std::string>> variables() const;
  /// What the first description and the parameter files need but has no known value: xacro arguments without
  /// a default, and those set from an argument of the launch file without one.
  std::vector<PythonLaunchNeed> needed() const;
  /// The reason why line() has no --activate although controllers are started. Empty if it has, or if none
  /// are started.
  std::string why_no_activate() const;
  /// The command to type: "polyarm VERB --description … --controllers … NAME:=VALUE", with a NAME:=VALUE for
  /// each of needed(). Empty without a description.
  std::string line(const std::string& verb = "run") const;
};

/// `args` are NAME:=VALUE from outside. Throws Error if XML or YAML is invalid. Limits: 1 MiB of text,
/// expressions 64 deep, 100,000 tokens, 50 included files up to 8 deep; the rest is ignored.
PythonLaunch read_python_launch(std::string_view text, const std::filesystem::path& path,
                                const std::map<std::string, std::string>& args, const PackageSearch& find);

/// True for a ROS 2 launch file: Python, or XML or YAML with elements that ROS 1 does not have.
bool is_ros2_launch(std::string_view text, const std::filesystem::path& path);

/// Lines like PythonLaunch::line for a launch file that names no description. Uses the files of its package
/// and of the packages beside it: descriptions that no other file includes, each with the first controllers
/// file of the same package. At most five; none if there is no package.
std::vector<std::string> lines_of_package(const std::filesystem::path& launch, const std::string& verb);

}  // namespace polyarm::ros_files
