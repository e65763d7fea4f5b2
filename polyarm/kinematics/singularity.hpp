#pragma once
/// How close a joint state is to a singularity. Any thread; allocates nothing.
#include <span>

#include "polyarm/kinematics/chain.hpp"

namespace polyarm::kinematics {

/// How far `q` is from a singularity: the smallest singular value of the Jacobian with lengths measured in
/// reaches of the robot, over the joints that move the TCP. 0 at a singularity; ordinary poses of six-joint
/// arms have 0.05 to 0.4.
double smallest_singular_value(const Chain& chain, std::span<const double> q);
inline constexpr double kSingular = 0.01;  // of smallest_singular_value()

}  // namespace polyarm::kinematics
