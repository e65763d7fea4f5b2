#pragma once
/// Shapes in YAML files. Metres.
#include <vector>

#include "polyarm/base/yaml.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// The keys of a shape: `box: [x, y, z]`, `cylinder: {radius, height}`, `sphere: {radius}`, `capsule:
/// {radius, length}`.
const std::vector<std::string>& shape_keys();
/// The shape that `yaml` defines, at its own origin; throws Error if it defines none or more than one.
Shape read_shape(const Yaml& yaml);

}  // namespace polyarm::description
