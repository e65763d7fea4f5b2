#pragma once
/// Goals of plan() for a pose of the TCP: every branch of the inverse kinematics, and the whole turns of its
/// joints that are within limits. Radians, metres. Any thread; allocates.
#include <vector>

#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/planning/planner.hpp"

namespace polyarm::planning {

/// Nearest to `seed` first, at most `most`. Empty if no joint state within limits reaches the pose;
/// InverseKinematics::explain() says why.
std::vector<JointState> goals_for(const ik::InverseKinematics& solver, const Pose& tcp_in_world,
                                  std::span<const double> seed, std::size_t most = 64);

/// The joint states and those that differ from one of them by a whole turn of one joint, within limits: the
/// robot looks the same. What cannot be reached without passing the robot's own base may be so with another
/// turn.
std::vector<JointState> with_turns(const kinematics::Chain& chain, std::vector<JointState> states,
                                   std::span<const double> seed);

}  // namespace polyarm::planning
