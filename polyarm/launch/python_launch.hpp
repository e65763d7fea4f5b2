#pragma once
/// What a launch file of ROS 2, in Python, XML or YAML, says in so many words: argument defaults, the
/// description and how it is expanded, parameter files, controllers that are spawned, launch files that it
/// includes. The files are read as text; no Python is run. Loops over lists that are written down, conditions
/// whose values are known and functions of the same file are followed. What is computed (functions of other
/// modules) is listed as not taken.
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
  std::string value;                 ///< given from outside, else the default
  bool known = false;                ///< false: no default, or one that is computed
  bool given = false;                ///< from outside
  std::vector<std::string> choices;  ///< empty: any value
};

/// A NAME:=VALUE that a user fills in.
struct PythonLaunchNeed {
  std::string name;
  std::string argument;  ///< of the launch file, where it comes from; empty: it is computed
  bool operator==(const PythonLaunchNeed&) const = default;
};

struct PythonLaunchDescription {
  std::filesystem::path file;
  std::vector<std::pair<std::string, std::string>> arguments;  ///< NAME:=VALUE of xacro, in their order
  std::vector<PythonLaunchNeed> unknown;  ///< arguments of xacro whose values are not known
  Location where;
};

struct PythonLaunchFile {
  std::filesystem::path file;
  Location where;
};

struct PythonLaunch {
  std::vector<PythonLaunchArgument> arguments;
  /// Of `xacro` and `cat` commands, xacro.process_file, open(), MoveItConfigsBuilder, robot_state_publisher.
  std::vector<PythonLaunchDescription> descriptions;
  std::vector<PythonLaunchFile> parameters;   ///< YAML files given to nodes
  std::vector<std::string> spawned;           ///< controllers that are started, as far as known
  bool spawned_known = true;                  ///< false: there may be more, or fewer
  std::vector<std::string> missing_packages;  ///< that files are in, and that are not found
  /// What could not be taken: "the value of use_fake_hardware is computed".
  std::vector<std::pair<Location, std::string>> not_taken;

  /// The values of `$(var NAME)` in the parameter files that an argument of the launch file has.
  std::vector<std::pair<std::string, std::string>> variables() const;
  /// What the first description and the parameter files need and has no value that is known: arguments of
  /// xacro without a default, and those that come from an argument of the launch file without one.
  std::vector<PythonLaunchNeed> needed() const;
  /// Why line() has no --activate though controllers are started; empty where it has, or where none are.
  std::string why_no_activate() const;
  /// "polyarm VERB --description … --controllers … NAME:=VALUE": what to type, with NAME:=VALUE for each of
  /// needed(); empty without a description.
  std::string line(const std::string& verb = "run") const;
};

/// `args` are NAME:=VALUE from outside. Throws Error where XML or YAML is damaged. Bounded: text of at most 1
/// MiB, expressions 64 deep, 100,000 tokens, 50 included files 8 deep; what lies beyond is not taken.
PythonLaunch read_python_launch(std::string_view text, const std::filesystem::path& path,
                                const std::map<std::string, std::string>& args, const PackageSearch& find);

/// A launch file of ROS 2: Python, or XML or YAML with what ROS 1 does not have.
bool is_ros2_launch(std::string_view text, const std::filesystem::path& path);

/// Lines like those of PythonLaunch::line for what lies in the package of a launch file that names no
/// description, and in the packages beside it: the descriptions that nothing includes, each with the first
/// controllers file of the same package. At most five; none where there is no package.
std::vector<std::string> lines_of_package(const std::filesystem::path& launch, const std::string& verb);

}  // namespace polyarm::ros_files
