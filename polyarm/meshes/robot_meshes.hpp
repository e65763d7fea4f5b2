#pragma once
/// The meshes of a robot as one file that a browser shows.
#include <filesystem>
#include <string>
#include <vector>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::meshes {

struct RobotMeshes {
  /// glTF 2.0, binary; empty where the robot has no meshes. For each link that looks like a mesh there is a
  /// node of its name, in the link's frame, in m, z up as in URDF.
  std::string glb;
  /// A sentence for each mesh that is missing or broken: its link's node holds what the link collides with.
  std::vector<Problem> warnings;
};

/// Does a link look like a mesh? Then its node in the GLB holds all its visual meshes.
bool has_mesh(const description::Link& link);

/// Of everything that the GLB depends on, the files' sizes and times among it: 16 hexadecimal digits; empty
/// where the robot has no meshes. Asks the disk for these alone.
std::string mesh_hash(const description::RobotModel& model);

/// Converts what the links look like, or takes it from `cache`, where it lies under its hash until the files
/// change. An empty path: no cache. Takes its time and reads the disk: any thread but those of a cell.
/// `most_triangles`: of all meshes; links beyond it are shown by what they collide with.
RobotMeshes robot_meshes(const description::RobotModel& model, const std::filesystem::path& cache,
                         std::size_t most_triangles = bounds::kRobotTriangles);

}  // namespace polyarm::meshes
