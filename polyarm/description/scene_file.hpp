#pragma once
#include <string>

#include "polyarm/base/yaml.hpp"
#include "polyarm/description/scene.hpp"

namespace polyarm::description {

/// Reads `polyarm: scene/1`. Throws Error with everything that is wrong in it, names checked against each
/// other.
Scene read_scene(const std::string& path);
Scene read_scene(const Yaml& yaml);
/// The same; `warnings` gets what the file leaves to be assumed and a simulation depends on.
Scene read_scene(const std::string& path, Problems& warnings);
Scene read_scene(const Yaml& yaml, Problems& warnings);

}  // namespace polyarm::description
