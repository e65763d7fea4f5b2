#pragma once
/// A few spheres that together contain convex bodies. Metres, in the frame of the bodies. Deterministic; any
/// thread.
///
/// The bodies are cut by planes, again where the sphere around a piece stands out most, and each piece gets
/// the sphere around it. So every point of a body lies in at least one sphere.
#include <cstddef>
#include <vector>

#include "polyarm/collision/convex_body.hpp"

namespace polyarm::collision {

struct CoverOptions {
  std::size_t most_spheres = 20;
  double desired_excess = 0.006;  ///< m; pieces are cut until no sphere stands out farther
};

struct SphereCover {
  std::vector<Ball> spheres;
  double largest_excess = 0;  ///< how far a sphere stands out of the bodies, m; by samples over its surface
};

SphereCover cover(const std::vector<ConvexBody>& bodies, const CoverOptions& options = {});

}  // namespace polyarm::collision
