#pragma once
/// Joint derivatives that give the TCP the derivatives of a path.
#include <array>
#include <span>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/moves/arm_derivatives.hpp"
#include "polyarm/paths/pose_piece.hpp"

namespace polyarm::moves {

/// Of the joints that move the TCP.
using JointValues = std::array<double, kinematics::Chain::kMostMoving>;

/// First to third derivatives, one value of each column of the arm.
struct JointRates {
  std::array<JointValues, 3> d{};
};

/// What is between the TCP and where it should be: m, and rad for small turns.
std::array<double, 6> tcp_error(const ArmDerivatives& arm, const Pose& target) noexcept;

/// Moves `q` (all joints of the chain, near the solution) by Newton's method onto `target`, to 1e-12 or what
/// rounding allows. False if it does not get there. Leaves arm.at(q).
bool settle(ArmDerivatives& arm, std::span<double> q, const Pose& target);

/// Where arm.at() is on the path: the derivatives of the joints. Six joints: the one solution. More: the
/// smallest (of first derivatives; the others are derivatives of that). Fewer: least squares, exact if the
/// arm can follow at all. False where they are no numbers.
bool find_rates(ArmDerivatives& arm, const paths::PoseDerivatives& path, JointRates& out);

/// The joint that has to move fastest where arm.at() is on the path, and how fast, rad or m per unit of the
/// path; infinite at a singularity that the path does not pass along.
struct FastestJoint {
  std::size_t column = 0;
  double rate = 0;
};
FastestJoint fastest_joint(const ArmDerivatives& arm, const paths::PoseDerivatives& path);

}  // namespace polyarm::moves
