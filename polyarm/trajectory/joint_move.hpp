#pragma once
/// Moves from rest to rest along straight lines in joint space, and stops. Radians or metres, seconds. All
/// functions throw Error("bad-move") if sizes differ or a number is not finite, and Error("bad-limit") if a
/// limit or scale is not positive. They allocate: not for the control cycle.
#include <span>
#include <vector>

#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::trajectory {

/// Largest magnitudes, in rad or m per s, s², s³; all positive and finite.
struct JointMotionLimits {
  double velocity = 1, acceleration = 4, jerk = 40;
};

struct JointMoveOptions {
  double speed_scale = 1;         ///< fraction of the velocity limits
  double acceleration_scale = 1;  ///< fraction of the acceleration and jerk limits
  /// Seconds. A longer duration than the fastest stretches the move in time; a shorter one has no effect,
  /// because the limits hold. Compare with fastest_duration() to detect that.
  double duration = 0;
};

/// All joints start, move and arrive together on one jerk-limited seven-phase profile s(t) from 0 to 1. Its
/// limits are the tightest over all joints, so no joint exceeds a limit and at least one reaches a limit
/// (unless the profile is stretched to the requested duration). During the last microsecond the position is
/// exactly `to`. A move of less than 1e-12 is one segment of 1 ms at rest at `to`. Source of the profile: the
/// double-S of Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008),
/// section 3.4, for rest to rest.
Trajectory plan_joint_move(std::span<const double> from, std::span<const double> to,
                           std::span<const JointMotionLimits> limits, const JointMoveOptions& options = {});

/// The same from each waypoint to the next, with a stop at each. options.duration applies to the whole
/// motion, divided in proportion to the fastest durations.
Trajectory plan_joint_moves(std::span<const double> from, std::span<const std::vector<double>> waypoints,
                            std::span<const JointMotionLimits> limits, const JointMoveOptions& options = {});

/// The fastest duration within limits, s; 0 for an empty move. plan_joint_move() adds the last microsecond.
double fastest_duration(std::span<const double> from, std::span<const double> to,
                        std::span<const JointMotionLimits> limits, double speed_scale = 1,
                        double acceleration_scale = 1);

/// The rule of the thesis: seconds = scale × Euclidean distance in joint space.
double thesis_duration(std::span<const double> from, std::span<const double> to, double scale);

/// Brings every joint from velocity `v` and acceleration `a` to rest within its acceleration and jerk limits,
/// each as fast as it can; joints that stop earlier wait. Positions start at `q`; the end positions follow
/// from the stop. An acceleration beyond its limit first returns at the jerk limit.
Trajectory plan_stop(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                     std::span<const JointMotionLimits> limits);

}  // namespace polyarm::trajectory
