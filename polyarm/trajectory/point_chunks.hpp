#pragma once
/// Points that say less than a trajectory needs, completed as ros2_control completes them.
#include <vector>

#include "polyarm/trajectory/splines.hpp"

namespace polyarm::trajectory {

/// Positions that a policy gives in even steps of 1 / `frequency` seconds (Hz): the times become (i + 1) /
/// frequency, and the velocities those of the cubic spline with continuous acceleration through all points
/// that begins and ends at rest. Points must have positions of the same number of joints.
void upsample_positions(std::vector<TrajectoryPoint>& points, double frequency);

/// Points of velocities or accelerations alone get positions that begin at 0 with a joint at rest at time 0,
/// by the trapezoid rule. Points whose field has not `joints` values, and all after them, stay as they are.
void integrate_points(std::vector<TrajectoryPoint>& points, std::size_t joints);

}  // namespace polyarm::trajectory
