#pragma once
/// Finds the joints of a robot that cannot hold it at rest. kg, m, N m (N for sliding joints). Any thread.
#include <cstddef>
#include <vector>

#include "polyarm/moves/torque_limits.hpp"

namespace polyarm::moves {

/// A joint whose effort limit in the description is below the torque that holds the robot at rest.
struct Overload {
  std::size_t joint = 0;         ///< index into RobotModel::actuated
  double torque = 0, limit = 0;  ///< N m or N
};

/// The overloads at `q`, in the order of RobotModel::actuated, without joints that others mimic. Implausible
/// masses do not count, as in physics. Empty if the tree cannot be built.
std::vector<Overload> overloads_at(const description::RobotModel& model, const Pose& T_world_base,
                                   const Payload& payload, const std::vector<double>& q);

}  // namespace polyarm::moves
