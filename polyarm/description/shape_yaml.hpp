#pragma once
#include <vector>

#include "polyarm/base/yaml.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

/// Keys that say a shape: `box: [x, y, z]`, `cylinder: {radius, height}`, `sphere: {radius}`, `capsule:
/// {radius, length}`.
const std::vector<std::string>& shape_keys();
/// The shape that `yaml` says, at its own origin; throws Error when it says none or more than one.
Shape read_shape(const Yaml& yaml);

}  // namespace polyarm::description
