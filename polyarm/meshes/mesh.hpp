#pragma once
/// Triangle meshes, read from any supported file format.
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::meshes {

/// Triangles of one colour. Positions in m in the mesh's own frame, x right, y ahead, z up as its file says.
struct MeshPart {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;  ///< one per position
  std::vector<std::uint32_t> triangles;       ///< three indices each
  std::array<float, 4> color{0.8f, 0.8f, 0.8f, 1};
  bool colored = false;  ///< true if the file gives a colour
  float roughness = 0.6f, metallic = 0.1f;  ///< finish, 0 to 1, as in glTF
};
using Mesh = std::vector<MeshPart>;

/// Limits; larger files and meshes are refused.
inline constexpr std::uintmax_t kLargestFile = bounds::kMeshBytes;
inline constexpr std::size_t kMostTriangles = bounds::kMeshTriangles;

/// Reads STL (binary and ASCII), OBJ (with its MTL), Collada, and the formats of mesh_process.hpp. Does not turn a
/// mesh whose format has y up, as RViz does not. Any thread. Throws Error("no-mesh" |
/// "bad-mesh" | "large-mesh" | "unknown-mesh") that names the file and says what to do.
Mesh read_mesh(const std::filesystem::path& path);

// The readers; `name` is for errors.
Mesh read_stl(const std::string& bytes, const std::string& name);
/// `materials`: the text of its MTL files.
Mesh read_obj(const std::string& text, const std::string& name, const std::string& materials = {});
/// Returns metres. Ignores `up_axis`, as RViz does.
Mesh read_collada(const std::string& text, const std::string& name);

/// Makes boxes, cylinders, spheres and capsules in the frame of the shape; nothing for a mesh.
Mesh mesh_of_shape(const description::Shape& shape);

/// Merges corners with equal position and normal and drops triangles without area. Missing normals are
/// computed; they are smooth where triangles meet at less than 30 degrees.
void tidy(MeshPart& part);

}  // namespace polyarm::meshes
