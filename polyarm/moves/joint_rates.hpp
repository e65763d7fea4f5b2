#pragma once
/// Joint derivatives that give the TCP the derivatives of a path. Metres, radians, world axes. Private to
/// this room.
#include <array>
#include <span>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/arm_derivatives.hpp"
#include "polyarm/paths/pose_piece.hpp"

namespace polyarm::moves {

/// For the joints that move the TCP.
using JointValues = std::array<double, kinematics::Chain::kMostMoving>;

/// First to third derivatives, one value for each column of the arm.
struct JointRates {
  std::array<JointValues, 3> d{};
};

/// The error of the TCP: m, and rad for small rotations.
std::array<double, 6> tcp_error(const ArmDerivatives& arm, const Pose& target) noexcept;

/// Moves `q` (all joints of the chain, near the solution) onto `target` by Newton's method, to 1e-12 or to
/// rounding. False if it does not converge. Leaves the arm at q.
bool settle(ArmDerivatives& arm, std::span<double> q, const Pose& target);

/// The derivatives of the joints at the present place of the path. Six joints: the unique solution. More: the
/// smallest first derivatives (the others are their derivatives). Fewer: least squares, exact if the arm can
/// follow at all. False if they are not finite.
bool find_rates(ArmDerivatives& arm, const paths::PoseDerivatives& path, JointRates& out);

/// The joint that has to move fastest at the present place of the path, and its speed, rad or m per unit of
/// the path; infinite at a singularity unless the path passes along it.
struct FastestJoint {
  std::size_t column = 0;
  double rate = 0;
};
FastestJoint fastest_joint(const ArmDerivatives& arm, const paths::PoseDerivatives& path);

}  // namespace polyarm::moves
