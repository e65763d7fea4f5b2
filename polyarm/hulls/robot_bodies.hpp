#pragma once
/// Gives the collision meshes of robots and scenes a body for physics: convex pieces that contain the mesh.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/robot_model.hpp"

namespace polyarm::hulls {

/// One mesh and its body, for reports.
struct BodyReport {
  std::string mesh;  ///< the path of the file
  std::size_t triangles = 0, pieces = 0;
  double size = 0, mean_excess = 0, largest_excess = 0;  ///< m; see ConvexPieces
  bool cached = false;
};

struct BodiesMade {
  std::vector<BodyReport> reports;
  std::vector<Problem> warnings;  ///< one for each mesh without a body, because its file is missing, broken
                                  ///< or too large; and for each that is as large as if its unit were wrong
};

/// The folder in which this user's bodies are cached; empty without a home folder.
std::filesystem::path bodies_cache();

/// Sets a process-wide listener. It is called before bodies are computed, which may take minutes, and after each one: with
/// how many of how many are made; not for cached bodies. Calls come one at a time, from any thread. Set it before the
/// first make_bodies.
void listen_to_making(std::function<void(std::size_t made, std::size_t meshes)> listener);

/// Fills `pieces` of each collision mesh of the robot. Meshes of the same file and scale are computed once,
/// in parallel on all processors. `cache`: a folder of the user that stores results by the content of the
/// mesh; an empty path disables it. Slow, reads the disk: any thread except those of a cell.
BodiesMade make_bodies(description::RobotModel& model, const std::filesystem::path& cache);
/// The same for single shapes, such as those of a tool or a fixture. Shapes that are not meshes do not
/// change.
BodiesMade make_bodies(const std::vector<description::Shape*>& shapes, const std::filesystem::path& cache);

}  // namespace polyarm::hulls
