#pragma once
/// Jogging of one joint: computes its state in each cycle so it can always stop in time. Units of the joint
/// (rad or m), seconds. For the control cycle: no allocation, no exceptions, no clock, about ten operations
/// each.
#include <array>
#include <cstddef>

namespace polyarm::jog {

struct AxisState {
  double position = 0, velocity = 0, acceleration = 0;
};

/// Limits of one joint; positions may be infinite.
struct AxisLimits {
  double lower = 0, upper = 0;
  double velocity = 1, acceleration = 1, jerk = 1;
};

/// The fastest motion to rest: jerk against the motion, the strongest braking, and jerk back. Velocity and
/// acceleration at the start determine it in closed form (an acceleration trapezoid).
class AxisBrake {
 public:
  AxisBrake(const AxisState& from, double acceleration, double jerk) noexcept;
  double duration() const noexcept { return time_[0] + time_[1] + time_[2]; }
  AxisState at(double t) const noexcept;
  /// The highest and lowest position during the braking, including start and end.
  double highest() const noexcept { return highest_; }
  double lowest() const noexcept { return lowest_; }
  /// The highest and lowest velocity during the braking.
  double fastest() const noexcept { return fastest_; }
  double slowest() const noexcept { return slowest_; }

 private:
  std::array<AxisState, 4> state_;  // at the start of each phase, and at the end
  std::array<double, 3> time_{}, jerk_{};
  double highest_, lowest_, fastest_, slowest_;
};

/// The state one cycle later on the fastest motion to a velocity that is `velocity` then and changes by
/// `slope` per second.
AxisState towards_velocity(const AxisState& now, double velocity, double slope, const AxisLimits& limits,
                           double dt) noexcept;

/// The state at the fraction `share` between `a` and `b`. The mixture of two motions within limits that begin
/// in the same state is a motion within limits.
AxisState mixed(const AxisState& a, const AxisState& b, double share) noexcept;

/// Keeps a joint able to stop: holds its limits, extended by what the present state makes unavoidable.
class AxisGuard {
 public:
  AxisGuard(const AxisState& now, const AxisLimits& limits, double dt) noexcept;
  /// True if a joint in this state can still stop within the limits.
  bool safe(const AxisState& next) const noexcept;
  /// The state after one cycle of braking; always safe.
  const AxisState& braked() const noexcept { return braked_; }
  /// The safe state nearest to `wanted`, which the joint must be able to reach in one cycle. `cut` is set if
  /// it differs from `wanted`.
  AxisState nearest(const AxisState& wanted, bool& cut) const noexcept;

 private:
  AxisLimits limits_;
  double slowest_, fastest_;
  AxisState braked_;
};

/// The highest speed from which a stop within `distance` is possible, braking with `acceleration` and `jerk`
/// from a steady motion; infinite if `distance` is.
double stopping_speed(double distance, double acceleration, double jerk) noexcept;

}  // namespace polyarm::jog
