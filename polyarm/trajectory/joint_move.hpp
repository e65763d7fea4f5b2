#pragma once
/// Moves from rest to rest along straight lines in joint space, and stops. All functions throw
/// Error("bad-move") when sizes differ or a number is not finite, Error("bad-limit") for a limit or scale
/// that is not above zero. Not for the control cycle.
#include <span>
#include <vector>

#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::trajectory {

/// Largest magnitudes, rad or m per s, s², s³. All above zero and finite.
struct JointMotionLimits {
  double velocity = 1, acceleration = 4, jerk = 40;
};

struct JointMoveOptions {
  double speed_scale = 1;         ///< share of the velocity limits
  double acceleration_scale = 1;  ///< share of the acceleration and jerk limits
  /// Seconds; longer than the fastest stretches the move in time. Shorter has no effect, since limits win:
  /// whoever wants to say so compares with fastest_duration().
  double duration = 0;
};

/// All joints leave, travel and arrive together on one jerk-limited seven-phase profile s(t) from 0 to 1,
/// whose own limits are the tightest over the joints; so no joint exceeds a limit and at least one reaches
/// one (or the profile is stretched to the duration asked for). The last microsecond stands exactly on `to`.
/// A move of less than 1e-12 is one segment of 1 ms at rest on `to`. Source of the profile: the double-S of
/// Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots (2008), section 3.4, for
/// rest to rest.
Trajectory plan_joint_move(std::span<const double> from, std::span<const double> to,
                           std::span<const JointMotionLimits> limits, const JointMoveOptions& options = {});

/// The same from each waypoint to the next, at rest on each. options.duration is that of the whole, shared
/// out in proportion to the fastest durations.
Trajectory plan_joint_moves(std::span<const double> from, std::span<const std::vector<double>> waypoints,
                            std::span<const JointMotionLimits> limits, const JointMoveOptions& options = {});

/// The fastest duration within limits, s; 0 for no move. plan_joint_move() adds its last microsecond to it.
double fastest_duration(std::span<const double> from, std::span<const double> to,
                        std::span<const JointMotionLimits> limits, double speed_scale = 1,
                        double acceleration_scale = 1);

/// The thesis's rule: seconds = scale × Euclidean distance in joint space.
double thesis_duration(std::span<const double> from, std::span<const double> to, double scale);

/// Brings every joint from velocity `v` and acceleration `a` to rest within its acceleration and jerk limits,
/// each for itself and as fast as it can; joints that stop earlier wait. Positions start at `q`; where they
/// end follows. An acceleration beyond its limit is brought back at the jerk limit first.
Trajectory plan_stop(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                     std::span<const JointMotionLimits> limits);

}  // namespace polyarm::trajectory
