#pragma once
/// Parts that are inside something where they start or where a feeder brings them. Metres, in the world. Any
/// thread; allocates.
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/scene.hpp"

namespace polyarm::surroundings {

/// A warning of code part-in-contact (part, other, depth_m) for each part that starts more than 2 mm inside
/// the floor, a fixture or a part before it, and for each feeder whose first part would. Physics pushes such
/// a part out. Meshes without pieces are left out.
std::vector<Problem> parts_inside(const description::Scene& scene);

}  // namespace polyarm::surroundings
