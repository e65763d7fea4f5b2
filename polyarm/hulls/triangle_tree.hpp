#pragma once
/// Distances to the triangles of a mesh, and rays through them, with a tree of boxes. Lengths in metres.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/meshes/mesh.hpp"

namespace polyarm::hulls {

using Triangle = std::array<Vec3, 3>;

/// Constant after construction: any number of threads. Needs at least one triangle; all must be finite.
class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles);

  /// The distance from a point to the nearest triangle, m.
  double distance(const Vec3& point) const;
  /// True if a ray from the point in this direction meets no triangle.
  bool escapes(const Vec3& point, const Vec3& direction) const;

 private:
  struct Node {
    Vec3 lower, upper;
    std::uint32_t begin = 0, end = 0;  ///< triangles of a leaf
    std::uint32_t right = 0;           ///< index of the second child; the first child is the next node; 0: a
                                       ///< leaf
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

/// The triangles of all parts of a mesh, scaled.
std::vector<Triangle> surface_of(const meshes::Mesh& mesh, const Vec3& scale = {1, 1, 1});

/// The point of a triangle that is closest to `p`. Source: Ericson, Real-Time Collision Detection, 5.1.5.
Vec3 nearest_point(const Triangle& triangle, const Vec3& p);

}  // namespace polyarm::hulls
