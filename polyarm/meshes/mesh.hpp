#pragma once
/// Triangle meshes, read from any supported file format.
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/meshes/image.hpp"

namespace polyarm::meshes {

/// Triangles of one colour or with one image. Positions in m in the mesh's own frame, x right, y ahead, z up
/// as its file says.
struct MeshPart {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;  ///< one per position
  std::vector<std::uint32_t> triangles;       ///< three indices each
  std::array<float, 4> color{0.8f, 0.8f, 0.8f, 1};
  bool colored = false;  ///< true if the file gives a colour
  float roughness = 0.6f, metallic = 0.1f;  ///< finish, 0 to 1, as in glTF
  /// Places in the image, one per position: 0 to 1, from its upper left corner to the right and down. Empty
  /// without an image.
  std::vector<std::array<float, 2>> texcoords;
  Image image;  ///< null: none. Its colours are multiplied by `color`
};
using Mesh = std::vector<MeshPart>;

/// Limits; larger files and meshes are refused.
inline constexpr std::uintmax_t kLargestFile = bounds::kMeshBytes;
inline constexpr std::size_t kMostTriangles = bounds::kMeshTriangles;

/// Reads STL (binary and ASCII), OBJ (with its MTL), Collada, 3MF, and the formats of mesh_process.hpp. Does
/// not turn a mesh whose format has y up, as RViz does not. Any thread. Throws Error("no-mesh" | "bad-mesh" |
/// "large-mesh" | "unknown-mesh") that names the file and says what to do. `notes`, if given, gets a warning
/// for each image that is left out; without it no image is read.
Mesh read_mesh(const std::filesystem::path& path, Problems* notes = nullptr);
/// The extensions that read_mesh knows, lower case: ".stl" first.
const std::vector<std::string>& mesh_extensions();

/// Finds an image by the name in a mesh file; null: it is left out.
using FindImage = std::function<Image(const std::string& name)>;

// The readers; `name` is for errors. Without `find`, they leave images out.
Mesh read_stl(const std::string& bytes, const std::string& name);
/// `materials`: the text of its MTL files.
Mesh read_obj(const std::string& text, const std::string& name, const std::string& materials = {},
              const FindImage& find = {});
/// Returns metres. Ignores `up_axis`, as RViz does.
Mesh read_collada(const std::string& text, const std::string& name, const FindImage& find = {});
/// Returns metres: the file says its unit. Colours of base materials and colour groups, no images.
Mesh read_3mf(const std::string& bytes, const std::string& name);

/// Makes boxes, cylinders, spheres and capsules in the frame of the shape; nothing for a mesh.
Mesh mesh_of_shape(const description::Shape& shape);

/// Scales the mesh and moves it to its pose in the frame of its owner, as the shape says.
void place(Mesh& mesh, const description::Shape& shape);

/// Merges corners with equal position and normal and drops triangles without area. Missing normals are
/// computed; they are smooth where triangles meet at less than 30 degrees.
void tidy(MeshPart& part);

/// Joins corners within cells of a grid until at most `most` triangles are left, and makes new normals.
/// Returns the diagonal of a cell: no corner moved further. 0 if nothing had to change.
double simplify(Mesh& mesh, std::size_t most);
std::size_t triangles_of(const Mesh& mesh);

/// What is doubtful about a mesh of this size (the diagonal of its box, m): " is 240 m large …". Empty if
/// nothing is.
std::string doubt_of_size(double size);
inline constexpr const char* kUnitAdvice =
    "if its numbers are millimetres, write scale=\"0.001 0.001 0.001\" in the URDF, or unit: mm in the scene";

}  // namespace polyarm::meshes
