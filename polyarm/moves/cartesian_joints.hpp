#pragma once
/// Converts a path of the TCP into a path of the joints. It allocates and throws: not for the control cycle;
/// any thread. The result may be used on any thread. Metres, radians; poses of the TCP in the world.
#include <memory>
#include <span>

#include "polyarm/kinematics/chain.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "polyarm/paths/joint_path.hpp"
#include "polyarm/paths/polynomial_path.hpp"

namespace polyarm::moves {

struct FollowOptions {
  double position_tolerance = 1e-7;     ///< m, of the TCP from its path, also between nodes
  double orientation_tolerance = 1e-7;  ///< rad
};

/// The joint path for the TCP path `path`, over the same parameter. Each piece is a polynomial of seventh
/// degree between two nodes; at the nodes the joints and their first three derivatives are exact (from the
/// Jacobian and its derivatives). Nodes are as far apart as the tolerances allow, which is checked between
/// them. breaks() are those of `path`; between them the third derivative is continuous.
///
/// Begins at `seed` (a joint state of the chain) if that matches the start of the path to 1e-4 m and rad,
/// else at the matching joint state nearest to it. The joints continue without a jump, a gap or a change of
/// configuration. An arm with more than six joints moves them as little as the path allows (least squares of
/// the derivatives, at every place). Joints that do not move the TCP keep the seed's values.
///
/// Throws Error: "wrong-size"; "unreachable" (no joint state reaches the path from some place on); "limit"
/// (says which joint, which limit, where); "singular" (says which joint would have to turn how fast, where);
/// "branch" (the path continues, but only in another configuration). Places are in the path's parameter:
/// metres.
std::unique_ptr<const paths::PolynomialPath> joints_along(const kinematics::Chain& chain,
                                                          const paths::CartesianPath& path,
                                                          std::span<const double> seed,
                                                          const FollowOptions& options = {});

/// All sections in order; `path`'s warnings are passed on. In errors, places count from the beginning of the
/// first section.
paths::PathSections joints_along(const kinematics::Chain& chain, const paths::CartesianSections& path,
                                 std::span<const double> seed, const FollowOptions& options = {});

/// For JointPathOptions: radii in metres at the TCP. Keeps a reference to `chain`.
paths::TcpDistance tcp_distance(const kinematics::Chain& chain);

}  // namespace polyarm::moves
