#pragma once
/// The meshes of a robot as one file for a browser.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::meshes {

struct RobotMeshes {
  /// glTF 2.0, binary; empty if the robot has no meshes. Each link with a visual mesh has a node of its name,
  /// in the link's frame, in m, z up as in URDF.
  std::string glb;
  /// One sentence per missing or broken mesh. The node of its link then holds the collision geometry.
  std::vector<Problem> warnings;
  /// What is drawn in another way than the files have it: images that are left out, meshes that are
  /// simplified. Said once: a result from the cache has none.
  std::vector<Problem> notes;
};

/// Triangles of a robot that are drawn; more are simplified.
inline constexpr std::size_t kDrawnTriangles = bounds::kDrawnTriangles;

/// True if a link has a visual mesh. Its node in the GLB then holds all its visual meshes.
bool has_mesh(const description::Link& link);

/// Hash of everything that the GLB depends on, including sizes and times of the mesh files, but not of their
/// materials and images: 16 hexadecimal digits;
/// empty if the robot has no meshes. Reads only these file attributes from disk.
std::string mesh_hash(const description::RobotModel& model);

/// Converts the visual geometry, or takes the result from `cache`, where it is stored under its hash until
/// the files change. An empty path disables the cache. Slow, reads the disk: any thread except those of a
/// cell. `most_triangles` limits all meshes together; links beyond it show their collision geometry. Meshes
/// with more than `drawn` triangles together are simplified.
RobotMeshes robot_meshes(const description::RobotModel& model, const std::filesystem::path& cache,
                         std::size_t most_triangles = bounds::kRobotTriangles,
                         std::size_t drawn = kDrawnTriangles);

}  // namespace polyarm::meshes
