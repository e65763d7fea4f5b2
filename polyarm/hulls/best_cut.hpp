#pragma once
/// Finds where to cut a mesh so that the hulls of both sides have the smallest volume. Any thread;
/// deterministic.
#include <vector>

#include "polyarm/hulls/hull.hpp"
#include "polyarm/hulls/triangle_tree.hpp"

namespace polyarm::hulls {

struct Halves {
  std::vector<Triangle> below, above;
};

/// Sorts triangles by their side of the plane. Triangles that cross the plane are cut.
Halves cut(const std::vector<Triangle>& triangles, const Plane& plane);

struct BestCut {
  Plane plane;         ///< a zero normal: the mesh is too small to cut
  bool saves = false;  ///< the saved volume is worth one more piece
};

/// Tries planes across the principal axes of the hull and across x, y and z. If none saves volume, it looks
/// one cut further: a tube, for example, must be cut twice before a cut saves volume. `least`: smallest
/// thickness of a half, m.
BestCut best_cut(const std::vector<Triangle>& triangles, const Hull& hull, double least);

}  // namespace polyarm::hulls
