#pragma once
/// Keys that a map of a YAML file defines more than once.
#include <string>

#include "polyarm/base/error.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm {

/// Adds an error for each key that a map in `node`, or below it, defines a second time.
void check_repeats(const Yaml& node, Problems& problems);

/// Reads a file of ROS, or one whose repeated keys another reader reports: of a repeated key the last value
/// counts. Otherwise as Yaml::load.
Yaml load_with_repeats(const std::string& path);

}  // namespace polyarm
