#pragma once
#include <string>

#include "polyarm/base/yaml.hpp"
#include "polyarm/description/scene.hpp"

namespace polyarm::description {

/// Reads `polyarm: scene/1`. Throws Error with everything that is wrong in it, names checked against each
/// other.
Scene read_scene(const std::string& path);
Scene read_scene(const Yaml& yaml);

}  // namespace polyarm::description
