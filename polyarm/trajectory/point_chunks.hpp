#pragma once
/// Completes trajectory points that lack fields, in the way of ros2_control. Allocates. Radians or metres,
/// seconds.
#include <vector>

#include "polyarm/trajectory/splines.hpp"

namespace polyarm::trajectory {

/// For positions at a fixed rate of `frequency` (Hz), as a policy sends them: point i gets the time (i + 1) /
/// frequency. The velocities are those of the cubic spline through all points that has a continuous
/// acceleration and rests at both ends. All points must have positions of the same number of joints.
void upsample_positions(std::vector<TrajectoryPoint>& points, double frequency);

/// Gives positions to points that have only velocities or accelerations, by the trapezoid rule. They start at
/// 0, with the joint at rest at time 0. A point whose field does not have `joints` values, and all after it,
/// stay unchanged.
void integrate_points(std::vector<TrajectoryPoint>& points, std::size_t joints);

}  // namespace polyarm::trajectory
