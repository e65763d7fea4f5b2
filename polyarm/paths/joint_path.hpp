#pragma once
/// Paths in joint space through waypoints: straight lines with rounded corners, or a spline. The functions
/// allocate and throw, so they do not run in the control cycle; their results may.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/paths/path.hpp"
#include "polyarm/paths/path_warning.hpp"

namespace polyarm::paths {

struct JointWaypoint {
  std::vector<double> q;  ///< rad or m, one value for each joint
  /// The largest distance of the path from the waypoint: in the joint norm, or in metres at the TCP (see
  /// JointPathOptions). 0: the path passes exactly through the waypoint and stops there if the direction
  /// changes. Ignored for the first and the last waypoint.
  double radius = 0;
  std::string name;  ///< for messages; empty: "waypoint 3", counted from 0
};

/// The distance, m, between the TCP's positions at two joint states.
using TcpDistance = std::function<double(std::span<const double>, std::span<const double>)>;

struct JointPathOptions {
  /// The weight of each joint, per rad or m, in the joint norm: the root of the sum of squared weighted
  /// differences; empty: 1 each.
  std::vector<double> weights;
  /// If set, radii are metres at the TCP.
  TcpDistance tcp_distance;
};

/// One path for each section from stop to stop.
struct PathSections {
  std::vector<std::unique_ptr<const Path>> sections;  ///< at least one
  std::vector<PathWarning> warnings;                  ///< "blend-shrunk", "waypoint-repeated"
};

/// Straight lines in joint space. The parameter is the way in the joint norm; on lines its derivative has the
/// norm 1.
/// A corner is rounded between the points of both lines at distance d, by the curve whose derivative turns
/// from one direction u to the other v as u + (v - u) (3 t² - 2 t³), where t is the fraction of its length 2
/// d. This is the polynomial of fifth degree (here of fourth) through both ends that is continuous to the
/// second derivative. It passes the waypoint at 3/8 d |sin(turn / 2)| and stays within the ball of radius d.
/// d is the radius, reduced with a warning to half of the shorter neighbour; where the path reverses, d is 0
/// and the path stops.
/// Waypoints equal to the previous one (to 1e-9 of the norm) count once, with the smaller radius; the path
/// ends exactly at the last. Throws Error with all faults: "no-waypoints", "wrong-size", "bad-number",
/// "bad-radius", "bad-weight".
PathSections joint_lines(std::span<const JointWaypoint> waypoints, const JointPathOptions& options = {});

/// The natural cubic spline through all waypoints as one path, continuous to the second derivative. The
/// parameter is approximately the length of the curve in the joint norm. Radii are ignored. Repeated
/// waypoints count once. Errors as for joint_lines().
PathSections joint_spline(std::span<const JointWaypoint> waypoints, const JointPathOptions& options = {});

}  // namespace polyarm::paths
