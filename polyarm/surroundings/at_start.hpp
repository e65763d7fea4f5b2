#pragma once
/// Mistakes in the places of a scene: parts inside something where they start or where a feeder brings them,
/// and fixtures in the way of belts. Metres, in the world. Any thread; allocates.
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/scene.hpp"

namespace polyarm::surroundings {

/// A warning of code part-in-contact (part, other, depth_m) for each part that starts more than 2 mm inside
/// the floor, a fixture or a part before it, and for each feeder whose first part would. Physics pushes such
/// a part out. Meshes without pieces are left out.
std::vector<Problem> parts_inside(const description::Scene& scene);

/// A warning of code belt-blocked (fixture, belt, depth_m) for each shape of a fixture or a bin that is more
/// than 2 mm inside a belt and rises more than 2 mm above its surface: parts cannot pass. Movers are left
/// out, and meshes without pieces.
std::vector<Problem> belts_blocked(const description::Scene& scene);

}  // namespace polyarm::surroundings
