#pragma once
/// Shapes in YAML files. Metres.
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::description {

/// The keys of a shape: `box: [x, y, z]`, `cylinder: {radius, height}`, `sphere: {radius}`, `capsule:
/// {radius, length}`.
const std::vector<std::string>& shape_keys();
/// The shape that `yaml` defines, at its own origin; throws Error if it defines none or more than one.
Shape read_shape(const Yaml& yaml);
/// The same, or `mesh: {file, unit, scale}`: a file (STL, OBJ, Collada, 3MF, GLB, glTF, PLY, STEP) beside the
/// file of `yaml`. Its numbers are in `unit` (m by default; mm, cm or in). Throws Error if there is no such
/// file.
Shape read_shape_or_mesh(const Yaml& yaml);

/// `cloud: {file, unit, radius, cell}`: boxes around the points of a PLY or PCD file beside the file of
/// `yaml`. Throws Error as clouds::read_cloud() does.
std::vector<Shape> read_cloud(const Yaml& yaml);

}  // namespace polyarm::description
