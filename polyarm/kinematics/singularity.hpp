#pragma once
/// Distance of a joint state from a singularity. Any thread; allocates nothing.
#include <span>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kinematics {

/// The smallest singular value of the Jacobian over the joints that move the TCP, with lengths measured in
/// units of the robot's reach. It is 0 at a singularity; ordinary poses of six-joint arms have 0.05 to 0.4.
double smallest_singular_value(const Chain& chain, std::span<const double> q);
inline constexpr double kSingular = 0.01;  // threshold of smallest_singular_value()

}  // namespace polyarm::kinematics
