#pragma once
/// Distances to the triangles of a mesh, and rays through them, by a tree of boxes. Lengths in metres.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"

namespace polyarm::hulls {

using Triangle = std::array<Vec3, 3>;

/// Built once, then const: any number of threads. Finite triangles, one at least.
class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles);

  /// From a point to the nearest triangle, m.
  double distance(const Vec3& point) const;
  /// True if a ray from the point in this direction meets no triangle.
  bool escapes(const Vec3& point, const Vec3& direction) const;

 private:
  struct Node {
    Vec3 lower, upper;
    std::uint32_t begin = 0, end = 0;  ///< triangles of a leaf
    std::uint32_t right = 0;           ///< the second child; the first comes next; 0: a leaf
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

/// The point of a triangle that is nearest to `p`. Source: Ericson, Real-Time Collision Detection, 5.1.5.
Vec3 nearest_point(const Triangle& triangle, const Vec3& p);

}  // namespace polyarm::hulls
