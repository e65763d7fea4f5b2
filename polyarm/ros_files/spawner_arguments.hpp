#pragma once
/// What the `spawner` of ROS 1's controller_manager is told on its command line.
#include <string>
#include <string_view>
#include <vector>

namespace polyarm::ros_files {

struct SpawnerArguments {
  std::vector<std::string> names;    ///< of controllers, or of YAML files
  std::string ns;                    ///< --namespace as written; empty: that of the node
  bool stopped = false;              ///< --stopped: load, and leave inactive
  std::vector<std::string> unknown;  ///< options that it does not have
};

/// Throws Error("bad-value"), without a place, where an option lacks its value.
SpawnerArguments read_spawner_arguments(std::string_view args);

/// "; did you mean '--stopped'?" and the like for an unknown option.
std::string spawner_option_hint(const std::string& option);

/// "/a/b" from a namespace and a name in it; a name that begins with '/' is whole already.
std::string resolve_name(const std::string& ns, const std::string& name);

}  // namespace polyarm::ros_files
