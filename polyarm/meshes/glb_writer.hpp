#pragma once
/// Writes glTF 2.0 as one binary file. Source: Khronos' glTF 2.0 specification, 4.4 (GLB).
#include <string>
#include <vector>

#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

struct GlbNode {
  std::string name;
  Mesh mesh;
};

/// Writes all nodes under one scene, each with its meshes and pose. The same nodes give the same bytes.
std::string write_glb(const std::vector<GlbNode>& nodes);

}  // namespace polyarm::meshes
