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

/// How positions and normals are stored.
enum class Precision {
  exact,   ///< as floats
  compact  ///< a third of the size: positions in steps of 1/4094 of the node's longest side, normals in
           ///< steps of 1/127 (KHR_mesh_quantization). Without images
};

/// Writes all nodes under one scene, each with its meshes and pose. The same nodes give the same bytes.
std::string write_glb(const std::vector<GlbNode>& nodes, Precision precision = Precision::exact);

}  // namespace polyarm::meshes
