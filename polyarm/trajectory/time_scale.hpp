#pragma once
/// The speed at which a trajectory's time runs, with smooth changes.

namespace polyarm::trajectory {

/// The limits of one joint while the speed of its trajectory's time changes; rad/s², rad/s³ (or m). Infinite:
/// no limit is known.
struct JointDynamics {
  double acceleration, deceleration, jerk;
};

/// The allowed changes of a time scale: at most `up` or `down` per s, and these rates change by at most
/// `change` per s².
struct ScaleRates {
  double up, down, change;

  /// The rates of a ramp between 0 and 1 in `ramp_s` seconds, independent of the joints.
  static ScaleRates of_ramp(double ramp_s) noexcept;
  /// Reduces the rates to what a joint allows that the plan moves at `velocity` with `acceleration` (rad/s,
  /// rad/s² or m, as planned at a scale of 1), at the scale `s`. With the scale s and its rate s' the joint's
  /// acceleration is acceleration s² + velocity s' (Bobrow, Dubowsky and Gibson 1985); s' may change at jerk
  /// / velocity. A plan within the limits always keeps a rate of 0; no rate becomes negative.
  void narrow(double velocity, double acceleration, double s, const JointDynamics& joint) noexcept;
};

/// 1: as planned, 0: held. A different speed of a trajectory's time never leaves its path, so override, hold
/// and resume only change this scale. It follows a target that may change at any call, with bounded rate and
/// bounded rate of rate, as fast as these allow. It never leaves [0, 1] and does not overshoot a constant
/// target. Control thread; no allocation, no exceptions.
class TimeScale {
 public:
  /// `ramp_s`: seconds from 1 to 0 if no rates are given; 0 changes immediately. `initial` in [0, 1].
  explicit TimeScale(double ramp_s = 0.25, double initial = 1) noexcept;

  /// Advances the clock by `dt` > 0 seconds, towards `target` (clamped to [0, 1]; NaN counts as 0). Returns
  /// the seconds of trajectory time that pass, in [0, dt].
  double advance(double dt, double target) noexcept { return advance(dt, target, own_); }
  /// The same with the given rates. A rate that is now too high drops to them immediately.
  double advance(double dt, double target, const ScaleRates& rates) noexcept;
  /// Sets the scale to `target`, at rest. Only while nothing moves.
  void jump(double target) noexcept;
  double value() const noexcept { return value_; }
  /// Change of value() per second; 0 when the target is reached.
  double rate() const noexcept { return rate_; }

 private:
  ScaleRates own_;
  double value_;
  double rate_ = 0;
};

}  // namespace polyarm::trajectory
