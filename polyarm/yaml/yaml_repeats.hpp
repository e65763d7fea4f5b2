#pragma once
/// Finds keys that a map of a YAML file defines more than once.
#include "polyarm/base/error.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm {

/// Adds an error for each key that a map in `node`, or below it, defines a second time.
void check_repeats(const Yaml& node, Problems& problems);

}  // namespace polyarm
