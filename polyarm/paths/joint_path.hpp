#pragma once
/// Paths in joint space through waypoints: straight lines whose corners are rounded, or a spline. Not for
/// the control cycle (they allocate and throw); what they make is.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/paths/path.hpp"

namespace polyarm::paths {

struct JointWaypoint {
  std::vector<double> q;  ///< rad or m, one value of each joint
  /// How far from the waypoint the path may leave its lines: in the joint norm, or metres at the TCP (see
  /// JointPathOptions). 0: exactly through the waypoint, at rest there if the direction changes. Of no
  /// meaning at the first and the last.
  double radius = 0;
  std::string name;  ///< for messages; empty: "waypoint 3", counted from 0
};

/// The distance, m, between the TCP's positions at two joint states.
using TcpDistance = std::function<double(std::span<const double>, std::span<const double>)>;

struct JointPathOptions {
  /// What a radian (or a metre) of each joint counts in the joint norm, the root of the sum of squares of
  /// weighted differences; empty: 1 each.
  std::vector<double> weights;
  /// Where given, radii are metres at the TCP.
  TcpDistance tcp_distance;
};

/// A way from rest to rest is one path; where it has to stop, the next begins.
struct PathSections {
  std::vector<std::unique_ptr<const Path>> sections;  ///< at least one
  std::vector<Problem> warnings;                      ///< "blend-shrunk", "waypoint-repeated"
};

/// Straight lines in joint space. The parameter is the joint norm of the way; on lines its derivative has the
/// norm 1. A corner is rounded between the points of both lines that are d away from it, by the curve whose
/// derivative turns from one direction u to the other v as u + (v - u) (3 t² - 2 t³), t being the share of
/// its length 2 d: the polynomial of fifth degree (here of fourth) through both ends that is continuous to
/// the second derivative. It passes the waypoint at 3/8 d |sin(turn / 2)| and stays within the ball of radius
/// d. d is the radius, shrunk to half of the shorter neighbour where it is larger, with a warning; where the
/// way turns straight back it is 0, and a stop. Waypoints equal to the one before (to 1e-9 of the norm) count
/// once, with the smaller radius; the path ends exactly at the last. Throws Error with everything found:
/// "no-waypoints", "wrong-size", "bad-number", "bad-radius", "bad-weight".
PathSections joint_lines(std::span<const JointWaypoint> waypoints, const JointPathOptions& options = {});

/// The natural cubic spline through all waypoints, one path, continuous to the second derivative; the
/// parameter is nearly the joint norm's length of the curve. Radii have no meaning. Repeated waypoints count
/// once. Errors as of joint_lines().
PathSections joint_spline(std::span<const JointWaypoint> waypoints, const JointPathOptions& options = {});

}  // namespace polyarm::paths
