#pragma once
/// Arrival times of one axis, and its motion. Part of state_to_state.hpp.
///
/// All quantities are divided by the axis's jerk, so the jerk is 1 and times are seconds. No allocation, no
/// exceptions, any thread.
#include <array>
#include <cstddef>

#include "polyarm/trajectory/axis_brake.hpp"
#include "polyarm/trajectory/axis_reach.hpp"
#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::trajectory {

class AxisPlan {
 public:
  /// Prepares the plan of one axis. After any status but ok no other function may be called. The caller keeps
  /// both states alive.
  MotionStatus prepare(const MotionState& start, const MotionState& target, const MotionLimits& limits,
                       TargetKind kind) noexcept;

  /// The earliest time not before `t` at which the axis can arrive, s from the start; infinite if rounding
  /// leaves none.
  double arrival(double t) noexcept;
  /// The motion with this duration, which must come from arrival().
  void build(double duration, AxisMotion& out) noexcept;
  bool brakes() const noexcept { return brake_.count > 0; }

 private:
  struct Interval {
    double first, last;
  };
  /// The smallest and the largest displacement after a duration.
  struct Reach {
    double time, low, high;
  };

  const UpperReach& upper() noexcept;
  const UpperReach& lower() noexcept;
  void find_first() noexcept;
  void find_first_at_rest(const AxisBounds& upwards, const AxisBounds& downwards) noexcept;
  void list_times_of_velocity() noexcept;
  void list_times() noexcept;
  void list_times(double first, double last) noexcept;
  void add(double first, double last) noexcept;
  bool close(double reach, double t) const noexcept;
  const Reach& reach(double t) noexcept;
  bool reaches(double t, double slack) noexcept;
  double nearest(double t) const noexcept;
  void build_between_rests(double t, AxisMotion& out) noexcept;
  void build_to_velocity(double t, AxisMotion& out) noexcept;
  void mix(double t, double share, AxisMotion& out) noexcept;
  void append(const JerkPhases& phases, double jerk, AxisMotion& out) const noexcept;

  const MotionState *from_, *to_;
  double jerk_;
  TargetKind kind_;
  AxisBrake brake_;
  AxisEnds ends_;  // after braking
  AxisBounds upper_bounds_, lower_bounds_;
  double distance_;  // after braking
  double slack_;     // rounding error of a distance
  double speeds_;    // sum of the velocity magnitudes at both ends
  AxisTimes times_of_ends_;
  UpperReach upper_, lower_;
  bool rests_;    // at rest at both ends: upper_ then belongs to the target's side
  bool at_once_;  // the shortest motion already arrives
  bool has_upper_, has_lower_, listed_;
  double first_;  // the earliest arrival after braking, unless times are listed
  double share_;  // share of the upper end in the motion that arrives first
  Reach reach_;   // result of the last query
  std::size_t count_;
  std::array<Interval, 12> times_;  // times at which the axis can arrive, after braking; the last interval is
                                    // open
};

}  // namespace polyarm::trajectory
