#pragma once
/// Poses for arms with fewer than six axes. Such an arm reaches few poses exactly, and points in files or
/// from measurements are rounded. A pose this near to one that the arm reaches counts as that one. Metres,
/// radians; poses of the TCP in the world. Any thread; allocates.
#include <optional>
#include <span>

#include "polyarm/moves/robot_facts.hpp"

namespace polyarm::moves {

/// Radians with three decimals and degrees with one are within these bounds.
inline constexpr double kRoundedPosition = 1e-5, kRoundedOrientation = 1e-3;

/// `tcp` with its z axis along the first axis of the arm, if the robot has fewer than six axes and not more
/// than kRoundedOrientation lies between. Such an arm reaches these poses over a whole area, so it can follow
/// lines from one to another.
std::optional<Pose> straightened(const RobotFacts& robot, const Pose& tcp);

/// The pose that the robot reaches near `tcp`, if it has fewer than six axes and they lie within the bounds
/// above. The position is kept if the arm can. `why`: explain() for `tcp`.
std::optional<Pose> nearest_reached(const RobotFacts& robot, const ik::InverseKinematics& arm,
                                    const Pose& tcp, const ik::IkExplanation& why);

/// straightened() or nearest_reached(), or `tcp` if the robot reaches it exactly, if nothing is near, or with
/// six axes and more.
Pose reached_pose(const RobotFacts& robot, const Pose& tcp, std::span<const double> current);

}  // namespace polyarm::moves
