#pragma once
/// How much of its limits a trajectory uses, exactly: at the extrema of its polynomials, not at samples.
/// Radians or metres, seconds. Allocates: not for the control cycle. Any thread.
#include <span>
#include <vector>

#include "polyarm/trajectory/state_to_state.hpp"
#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::trajectory {

/// A value and its time, s.
struct Peak {
  double value = 0, time = 0;
};

/// One joint of a trajectory. `velocity`, `acceleration`, `jerk`: the value nearest to its limit or furthest
/// beyond it; `*_use` is that value divided by its limit. Steps have no finite jerk or acceleration: the
/// largest jump between two polynomials, including a start and an end that are not at rest.
struct JointUse {
  Peak lowest, highest;  ///< position
  Peak velocity, acceleration, jerk;
  double velocity_use = 0, acceleration_use = 0, jerk_use = 0;
  Peak velocity_step, acceleration_step;
  int velocity_steps = 0, acceleration_steps = 0;  ///< number of steps that exceed rounding
};

/// `limits` has one entry for each joint. Throws Error("wrong-size").
std::vector<JointUse> limit_use(const Trajectory& trajectory, std::span<const MotionLimits> limits);

/// The factor by which the duration must grow to keep every limit of velocity, acceleration and jerk, steps
/// excluded; 1 or less if none is exceeded.
double stretch_needed(std::span<const JointUse> uses);

}  // namespace polyarm::trajectory
