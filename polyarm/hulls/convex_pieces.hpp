#pragma once
/// A mesh as a few convex pieces that together contain all its triangles: a body for physics. Lengths in
/// metres, in the frame of the mesh. Any thread; deterministic.
///
/// The mesh is cut in two by a plane, again and again, where that saves most volume, and each piece is the
/// hull of its triangles. So open, inverted or overlapping meshes need no repair.
#include <cstddef>
#include <vector>

#include "polyarm/hulls/hull.hpp"
#include "polyarm/hulls/triangle_tree.hpp"

namespace polyarm::hulls {

struct PieceOptions {
  std::size_t most_pieces = 16;
  std::size_t most_corners = 64;  ///< of each piece
  /// Pieces are cut until the mean excess is below this part of the mesh's largest extent.
  double wanted_excess = 0.006;
};

struct ConvexPieces {
  std::vector<Hull> pieces;
  double size = 0;  ///< the diagonal of the mesh's box, m
  /// How far the surface of the pieces lies from the mesh, m, by samples over that surface. What lies inside
  /// of the mesh, or inside of another piece, counts as 0.
  double mean_excess = 0, largest_excess = 0;
};

/// Throws Error("bad-mesh") if there is no triangle or a corner is not finite.
ConvexPieces convex_pieces(const std::vector<Triangle>& triangles, const PieceOptions& options = {});

}  // namespace polyarm::hulls
