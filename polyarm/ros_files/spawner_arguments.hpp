#pragma once
/// The command line of `spawner` in ROS 1's controller_manager.
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::ros_files {

struct SpawnerArguments {
  std::vector<std::string> names;    ///< names of controllers, or of YAML files
  std::string ns;                    ///< --namespace as written; empty: the node's namespace
  bool stopped = false;              ///< --stopped: load, but leave inactive
  std::vector<std::string> unknown;  ///< options that spawner does not have
};

/// Throws Error("bad-value"), without a location, if an option lacks its value.
SpawnerArguments read_spawner_arguments(std::string_view args);

/// A hint for an unknown option, such as "; did you mean '--stopped'?".
std::string spawner_option_hint(const std::string& option);

/// "/a/b" from a namespace and a name in it; a name that begins with '/' is complete.
std::string resolve_name(const std::string& ns, const std::string& name);

}  // namespace polyarm::ros_files
