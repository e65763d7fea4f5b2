#pragma once
/// `$(var …)` and its like in parameter files, as launch files of ROS 2 replace them before a node reads
/// them.
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/launch/launch_substitution.hpp"

namespace polyarm::ros_files {

/// What stands behind the names of a parameter file; each may be empty.
struct ParameterSubstitution {
  std::function<std::optional<std::string>(const std::string& name)> var;  ///< $(var NAME); may throw Error
  PackageSearch find;                                                      ///< $(find-pkg-share NAME)
};

/// `text` of `file` with $(var NAME), $(env NAME [DEFAULT]), $(find-pkg-share NAME) and $(dirname) replaced,
/// also within each other; lines stay lines, and comments as they are. What has no value, and every other
/// $(…), is an error with its place, and stays as it is.
std::string substitute_parameters(std::string_view text, const std::string& file,
                                  const ParameterSubstitution& with, Problems& problems);

}  // namespace polyarm::ros_files
