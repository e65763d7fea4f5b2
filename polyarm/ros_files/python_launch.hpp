#pragma once
/// What a Python launch file of ROS 2 says in so many words: argument defaults, the description and how it is
/// expanded, parameter files. The file is read as text; no Python is run. What is computed (conditions,
/// loops, functions of other modules) is listed as not taken.
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/ros_files/launch_substitution.hpp"

namespace polyarm::ros_files {

struct PythonLaunchArgument {
  std::string name;
  std::string value;   ///< given from outside, else the default
  bool known = false;  ///< false: no default, or one that is computed
  bool given = false;  ///< from outside
};

struct PythonLaunchDescription {
  std::filesystem::path file;
  std::vector<std::pair<std::string, std::string>> arguments;  ///< NAME:=VALUE of xacro, in their order
  Location where;
};

struct PythonLaunchFile {
  std::filesystem::path file;
  Location where;
};

struct PythonLaunch {
  std::vector<PythonLaunchArgument> arguments;
  std::vector<PythonLaunchDescription> descriptions;  ///< of `xacro` commands and xacro.process_file
  std::vector<PythonLaunchFile> parameters;           ///< YAML files given to nodes
  /// What could not be taken: "the value of use_fake_hardware is computed".
  std::vector<std::pair<Location, std::string>> not_taken;

  /// The values of `$(var NAME)` in the parameter files that an argument of the launch file has.
  std::vector<std::pair<std::string, std::string>> variables() const;
  /// "polyarm run --description … --controllers … NAME:=VALUE": what to type; empty without a description.
  std::string line() const;
};

/// `args` are NAME:=VALUE from outside. Bounded: text of at most 1 MiB, expressions 64 deep, 100,000 tokens;
/// what lies beyond is not taken. Throws Error("not-python") where the text is not that of a launch file.
PythonLaunch read_python_launch(std::string_view text, const std::filesystem::path& path,
                                const std::map<std::string, std::string>& args, const PackageSearch& find);

}  // namespace polyarm::ros_files
