#pragma once
/// Measures the surfaces of a link's meshes: a few lofts through convex sections that lie close to all that
/// is visible from outside. Lengths in m. No side effects; any thread; deterministic.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "polyarm/hulls/triangle_tree.hpp"
#include "polyarm/meshes/mesh.hpp"
#include "polyarm/shapes/measured_look.hpp"

namespace polyarm::fitting {

struct FitOptions {
  double tolerance = 0.001;  ///< largest distance of a loft's sections from the piece that it describes, m
  double smallest = 0.008;   ///< smaller pieces are left out (screws, letters), m
  std::size_t most_pieces = 11;  ///< of a link
  std::size_t most_text = 3500;  ///< characters of a link in the file; the tolerance grows until it fits
  bool with_colors = false;      ///< each colour of the mesh gets its own lofts
  /// Surfaces of this colour get the paint of the maker's style: the main colour of the whole robot.
  std::array<float, 4> main_color{};
};

/// The lofts of one link, in the frame of `mesh`. Empty if nothing of the mesh is visible.
std::vector<shapes::MeasuredLoft> fit_look(const meshes::Mesh& mesh, const std::string& link,
                                           const FitOptions& options);

/// The colour with the largest surface.
std::array<float, 4> main_color(const meshes::Mesh& mesh);

/// True if straight lines lead away from a point of a surface, on one of its sides, in an eighth of all
/// directions: on an outer surface in half of them, deep in a hole in few. `normal`: of any length.
bool is_visible(const hulls::TriangleTree& tree, const Vec3& point, const Vec3& normal);

}  // namespace polyarm::fitting
