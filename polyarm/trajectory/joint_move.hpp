#pragma once
/// Moves from rest to rest along the straight line in joint space.
#include <span>
#include <vector>

#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::trajectory {

/// Largest magnitudes, rad or m per s, s², s³. All above zero.
struct JointMotionLimits {
  double velocity = 1, acceleration = 4, jerk = 40;
};

struct JointMoveOptions {
  double speed_scale = 1;  ///< share of the velocity limits; accelerations and jerks stay
  double duration = 0;     ///< seconds; longer than the fastest stretches the move, shorter has no effect
};

/// All joints leave, travel and arrive together on one jerk-limited seven-phase profile s(t) from 0 to 1,
/// whose own limits are the tightest over the joints; so no joint exceeds a limit and at least one reaches
/// one (or the profile is stretched to the duration asked for). A move of no length gives a trajectory of one
/// segment of 1 ms at rest. Source of the profile: the double-S of Biagiotti and Melchiorri, Trajectory
/// Planning for Automatic Machines and Robots (2008), section 3.4, for rest to rest.
Trajectory plan_joint_move(std::span<const double> from, std::span<const double> to,
                           std::span<const JointMotionLimits> limits, const JointMoveOptions& options = {});

/// The fastest duration within limits, s.
double fastest_duration(std::span<const double> from, std::span<const double> to,
                        std::span<const JointMotionLimits> limits, double speed_scale = 1);

/// The thesis's rule: seconds = scale × Euclidean distance in joint space.
double thesis_duration(std::span<const double> from, std::span<const double> to, double scale);

/// Brings every joint from velocity `v` and acceleration `a` to rest within its limits, each for itself and
/// as fast as it can; joints that stop earlier wait. Positions start at `q`.
Trajectory plan_stop(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                     std::span<const JointMotionLimits> limits);

}  // namespace polyarm::trajectory
