#pragma once
/// Reads scene files. SI units.
#include <string>

#include "polyarm/description/scene.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {

/// Reads `polyarm: scene/1`. Throws Error with all faults, including unknown names.
Scene read_scene(const std::string& path);
Scene read_scene(const Yaml& yaml);
/// The same. Adds to `warnings` the values that the file does not state although a simulation depends on
/// them.
Scene read_scene(const std::string& path, Problems& warnings);
Scene read_scene(const Yaml& yaml, Problems& warnings);

}  // namespace polyarm::description
