#pragma once
/// The geometry of one arm as its controller states it: read from it, compared with a description, and as
/// axes. SI units.
#include <array>
#include <span>
#include <string>

#include "drivers/ur/primary.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::ur {

/// A joint of a description: its place in the parent link, and its axis in its own frame.
struct JointLine {
  Pose origin;
  Vec3 axis;
};

/// The largest distance between the flange of the controller and the last link of the description, over 64
/// spread joint states, m. The bases may differ by half a turn about z.
double flange_difference(const Kinematics& kinematics, std::span<const JointLine> described);

/// The joint axes at zero joint values and the flange there, in a base that is turned by half a turn about z
/// against the controller's, as in the descriptions of these robots.
struct ArmAxes {
  std::array<Vec3, 6> directions, points;
  Pose flange;
};
ArmAxes axes_of(const Kinematics& kinematics);
/// The flange in the controller's base, and its Jacobian: 6 x 6 by rows, rates of position, then of rotation.
Pose flange_jacobian(const Kinematics& kinematics, const std::array<double, 6>& q, std::array<double, 36>& J);

/// Reads the geometry over the primary interface. Waits at most `timeout` ns. Throws Error("unreachable") or
/// Error("no-answer") with what to check.
Kinematics read_kinematics(const std::string& host, int port, Nanoseconds timeout);

}  // namespace polyarm::ur
