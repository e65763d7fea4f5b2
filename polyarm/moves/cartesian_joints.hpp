#pragma once
/// From a path of the TCP to a path of the joints. Not for the control cycle (it allocates and throws); what
/// it makes is, for any thread. Metres, radians, poses of the TCP in the world.
#include <memory>
#include <span>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/paths/polynomial_path.hpp"

namespace polyarm::moves {

struct FollowOptions {
  double position_tolerance = 1e-7;     ///< m, of the TCP from its path, between nodes too
  double orientation_tolerance = 1e-7;  ///< rad
};

/// What the joints do while the TCP follows `path`, over the same parameter. Each piece is a polynomial of
/// seventh degree between two nodes, at which the joints and their first three derivatives are exact (from
/// the Jacobian and its derivatives); nodes are as far apart as the tolerances allow, which is judged between
/// them. breaks() are those of `path`; within them the third derivative is continuous.
///
/// Begins at `seed` (a joint state of the chain) if that is where the path begins, to 1e-4 m and rad; else at
/// the joint state nearest to it that is. From there the joints go on without a jump; nothing is left out and
/// no other configuration taken. An arm with more than six joints moves them as little as the path allows
/// (least squares of the derivatives, at every place). Joints that do not move the TCP keep the seed's
/// values.
///
/// Throws Error: "wrong-size"; "unreachable" (no joint state leads to the path from a place on); "limit"
/// (which joint, which limit, where); "singular" (which joint would have to turn how fast, where); "branch"
/// (the path goes on, but only in another configuration). Places are in the path's parameter: metres.
std::unique_ptr<const paths::PolynomialPath> joints_along(const kinematics::Chain& chain,
                                                          const paths::CartesianPath& path,
                                                          std::span<const double> seed,
                                                          const FollowOptions& options = {});

/// All sections, one after the other; `path`'s warnings go with them. In errors the places count from the
/// beginning of the first section.
paths::PathSections joints_along(const kinematics::Chain& chain, const paths::CartesianSections& path,
                                 std::span<const double> seed, const FollowOptions& options = {});

/// For JointPathOptions: radii in metres at the TCP. Keeps a reference to `chain`.
paths::TcpDistance tcp_distance(const kinematics::Chain& chain);

}  // namespace polyarm::moves
