#pragma once
/// Where to cut a mesh so that the hulls of both sides have least volume. Any thread; deterministic.
#include <vector>

#include "polyarm/hulls/hull.hpp"
#include "polyarm/hulls/triangle_tree.hpp"

namespace polyarm::hulls {

struct Halves {
  std::vector<Triangle> below, above;
};

/// Sorts triangles by their side. Those that the plane meets are cut.
Halves cut(const std::vector<Triangle>& triangles, const Plane& plane);

struct BestCut {
  Plane plane;         ///< a zero normal: the mesh is too small to be cut
  bool saves = false;  ///< it saves volume worth a piece
};

/// Tries planes across the principal axes of the hull and across x, y and z. Where none saves volume, it
/// looks one cut further: a tube has to be cut twice before a cut pays. `least`: no half is thinner than
/// this, m.
BestCut best_cut(const std::vector<Triangle>& triangles, const Hull& hull, double least);

}  // namespace polyarm::hulls
