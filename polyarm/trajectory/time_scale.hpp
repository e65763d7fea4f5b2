#pragma once
/// The speed at which a trajectory's time runs, changed smoothly.

namespace polyarm::trajectory {

/// 1: as planned, 0: held. Running a trajectory's time faster or slower never leaves its path, so override,
/// hold and resume are this scale alone. Towards a target that may change at any call, it moves with bounded
/// rate (at most 1.5 / T per s) and bounded rate of rate (at most 4.5 / T² per s²), T being the ramp: from 1
/// to 0 at rest takes T, a change by half less. It never leaves [0, 1] and passes no target that stands
/// still.
///
/// What this does to a joint that the plan moves at velocity v and acceleration a: its acceleration becomes
/// a s² + v s', so stopping alone costs up to 1.5 v / T, and its jerk gains up to 4.5 v / T² + 4.5 a / T.
/// ramp_for() gives the T that keeps the sum within 1.07 times an acceleration limit even when the plan
/// brakes at that limit. Control thread; no allocation, no exceptions.
class TimeScale {
 public:
  /// `ramp_s`: seconds from 1 to 0; 0 changes at once. `initial` in [0, 1].
  explicit TimeScale(double ramp_s = 0.25, double initial = 1) noexcept;

  /// Lets `dt` > 0 seconds of clock pass, on the way to `target` (clamped to [0, 1]; not a number counts as
  /// 0). Returns the seconds of trajectory time that pass, in [0, dt].
  double advance(double dt, double target) noexcept;
  double value() const noexcept { return value_; }
  /// Seconds from 1 to 0.
  double ramp() const noexcept { return 1.5 / most_rate_; }
  /// Change of value() per second now; 0 when the target is reached.
  double rate() const noexcept { return rate_; }

  /// The ramp, s, for a joint of these limits (rad/s, rad/s² or m).
  static double ramp_for(double velocity, double acceleration) noexcept {
    return 4 * velocity / acceleration;
  }

 private:
  double most_rate_, most_change_;  // 1/s, 1/s²
  double value_;
  double rate_ = 0;
};

}  // namespace polyarm::trajectory
