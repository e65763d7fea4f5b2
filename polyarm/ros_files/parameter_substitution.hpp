#pragma once
/// Replaces `$(var …)` and similar in parameter files, as ROS 2 launch files do before a node reads them.
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "polyarm/base/error.hpp"
#include "polyarm/launch/launch_substitution.hpp"

namespace polyarm::ros_files {

/// Sources of the values; each may be empty.
struct ParameterSubstitution {
  std::function<std::optional<std::string>(const std::string& name)> var;  ///< $(var NAME); may throw Error
  PackageSearch find;                                                      ///< $(find-pkg-share NAME)
};

/// Returns `text` of `file` with $(var NAME), $(env NAME [DEFAULT]), $(find-pkg-share NAME) and $(dirname)
/// replaced, also if nested. Line numbers and comments stay as they are. A substitution without a value, or
/// of another kind, is an error with its location, and is not replaced.
std::string substitute_parameters(std::string_view text, const std::string& file,
                                  const ParameterSubstitution& with, Problems& problems);

}  // namespace polyarm::ros_files
