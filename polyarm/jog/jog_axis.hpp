#pragma once
/// One joint that is moved by hand: what it does in a cycle so that it can always still stop in time. Units
/// of the joint (rad or m), seconds. For the control cycle: no allocation, no exceptions, no clock, some ten
/// operations each.
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

/// The fastest way to rest: jerk against the motion, the strongest braking, and jerk back. It follows from
/// the velocity and acceleration at the start in closed form (an acceleration trapezoid).
class AxisBrake {
 public:
  AxisBrake(const AxisState& from, double acceleration, double jerk) noexcept;
  double duration() const noexcept { return time_[0] + time_[1] + time_[2]; }
  AxisState at(double t) const noexcept;
  /// Where the joint comes furthest up and down on the way, its start and its rest among them.
  double highest() const noexcept { return highest_; }
  double lowest() const noexcept { return lowest_; }
  /// Its greatest and its least velocity.
  double fastest() const noexcept { return fastest_; }
  double slowest() const noexcept { return slowest_; }

 private:
  std::array<AxisState, 4> state_;  // at the beginning of each phase, and at the end
  std::array<double, 3> time_{}, jerk_{};
  double highest_, lowest_, fastest_, slowest_;
};

/// The state one cycle later on the fastest way to a velocity that is `velocity` then and changes by `slope`,
AxisState towards_velocity(const AxisState& now, double velocity, double slope, const AxisLimits& limits,
                           double dt) noexcept;

/// `share` of the way from `a` to `b`. Of two motions within limits that begin in the same state, the mixture
/// is a motion within limits.
AxisState mixed(const AxisState& a, const AxisState& b, double share) noexcept;

/// What keeps a joint able to stop: its limits, widened to what it cannot help from where it is now.
class AxisGuard {
 public:
  AxisGuard(const AxisState& now, const AxisLimits& limits, double dt) noexcept;
  /// Can a joint that is in this state still stop within the limits?
  bool safe(const AxisState& next) const noexcept;
  /// The state after a cycle of braking; safe.
  const AxisState& braked() const noexcept { return braked_; }
  /// The safe state nearest to `wanted`, a state that the joint can reach in one cycle. `cut`: it is another.
  AxisState nearest(const AxisState& wanted, bool& cut) const noexcept;

 private:
  AxisLimits limits_;
  double slowest_, fastest_;
  AxisState braked_;
};

/// How fast one may go who has to stop within `distance`, braking with `acceleration` and `jerk` from a
/// steady motion; infinite where the distance is.
double stopping_speed(double distance, double acceleration, double jerk) noexcept;

}  // namespace polyarm::jog
