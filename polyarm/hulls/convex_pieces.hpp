#pragma once
/// Divides a mesh into a few convex pieces that together contain all its triangles: a body for physics.
/// Lengths in metres, in the frame of the mesh. Any thread; deterministic.
///
/// A plane cuts the mesh in two, repeatedly, where the cut saves most volume. Each piece is the hull of its
/// triangles. Therefore open, inverted or overlapping meshes need no repair.
#include <cstddef>
#include <vector>

#include "polyarm/hulls/hull.hpp"
#include "polyarm/hulls/triangle_tree.hpp"

namespace polyarm::hulls {

struct PieceOptions {
  std::size_t most_pieces = 16;
  std::size_t most_corners = 64;  ///< of each piece
  /// Parts are cut until the mean excess is below this fraction of the mesh's largest extent.
  double desired_excess = 0.006;
};

struct ConvexPieces {
  std::vector<Hull> pieces;
  double size = 0;  ///< diagonal of the mesh's bounding box, m
  /// The distance of the pieces' surface from the mesh, m, measured at samples on that surface. Samples
  /// inside the mesh or inside another piece count as 0.
  double mean_excess = 0, largest_excess = 0;
};

/// Throws Error("bad-mesh") if there is no triangle or if a corner is not finite.
ConvexPieces convex_pieces(const std::vector<Triangle>& triangles, const PieceOptions& options = {});

}  // namespace polyarm::hulls
