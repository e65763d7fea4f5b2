#pragma once
#include <vector>

#include "polyarm/trajectory/splines.hpp"
namespace polyarm::trajectory {
inline void upsample_positions(std::vector<TrajectoryPoint>&, double) {}
inline void integrate_points(std::vector<TrajectoryPoint>&, std::size_t) {}
}  // namespace polyarm::trajectory
