#pragma once
/// How much of its limits a trajectory uses, exactly: not at samples but at the extrema of its polynomials.
/// Outside the control cycle.
#include <span>
#include <vector>

#include "polyarm/trajectory/state_to_state.hpp"
#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::trajectory {

/// A value and when it is reached, s.
struct Peak {
  double value = 0, time = 0;
};

/// One joint of a trajectory. `velocity`, `acceleration`, `jerk`: where the value is nearest to its limit or
/// furthest beyond it, and `*_use` that value over its limit. Steps are what has no finite jerk or
/// acceleration: the largest jump between two polynomials, counting a start and an end that are not at rest.
struct JointUse {
  Peak lowest, highest;  ///< position
  Peak velocity, acceleration, jerk;
  double velocity_use = 0, acceleration_use = 0, jerk_use = 0;
  Peak velocity_step, acceleration_step;
  int velocity_steps = 0, acceleration_steps = 0;  ///< how many are more than rounding
};

/// `limits`: one for each joint. Throws Error("wrong-size").
std::vector<JointUse> limit_use(const Trajectory& trajectory, std::span<const MotionLimits> limits);

/// By how much longer a trajectory has to take to keep every limit of velocity, acceleration and jerk, steps
/// left aside: 1 or less, nothing.
double stretch_needed(std::span<const JointUse> uses);

}  // namespace polyarm::trajectory
