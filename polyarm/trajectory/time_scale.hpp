#pragma once
/// The speed at which a trajectory's time runs, changed smoothly.

namespace polyarm::trajectory {

/// What one joint may do while the speed of its trajectory's time changes; rad/s², rad/s³ (or m). Infinite:
/// nobody states it, and it bounds nothing.
struct JointDynamics {
  double acceleration, deceleration, jerk;
};

/// How a time scale may change now: at most `up` or `down` per s, and these by at most `change` per s².
struct ScaleRates {
  double up, down, change;

  /// What a ramp of `ramp_s` seconds between 0 and 1 takes, whatever the joints do.
  static ScaleRates of_ramp(double ramp_s) noexcept;
  /// Leaves no more than a joint allows that the plan moves at `velocity` with `acceleration` (rad/s, rad/s²
  /// or m; as planned, at a scale of 1), at the scale `s`. With the scale s and its rate s' the joint's
  /// acceleration is acceleration s² + velocity s' (Bobrow, Dubowsky and Gibson 1985), and what is left to
  /// change s' with is jerk / velocity. A plan within the limits is always left a rate of 0, and none is made
  /// negative.
  void narrow(double velocity, double acceleration, double s, const JointDynamics& joint) noexcept;
};

/// 1: as planned, 0: held. Running a trajectory's time faster or slower never leaves its path, so override,
/// hold and resume are this scale alone. Towards a target that may change at any call it moves with bounded
/// rate and bounded rate of rate, as fast as these allow. It never leaves [0, 1] and passes no target that
/// stands still. Control thread; no allocation, no exceptions.
class TimeScale {
 public:
  /// `ramp_s`: seconds from 1 to 0 where no rates are given; 0 changes at once. `initial` in [0, 1].
  explicit TimeScale(double ramp_s = 0.25, double initial = 1) noexcept;

  /// Lets `dt` > 0 seconds of clock pass, on the way to `target` (clamped to [0, 1]; not a number counts as
  /// 0). Returns the seconds of trajectory time that pass, in [0, dt].
  double advance(double dt, double target) noexcept { return advance(dt, target, own_); }
  /// The same with the rates that hold now. A rate that has become too high falls to them at once.
  double advance(double dt, double target, const ScaleRates& rates) noexcept;
  /// To `target` at once, at rest; for when nothing moves.
  void jump(double target) noexcept;
  double value() const noexcept { return value_; }
  /// Change of value() per second now; 0 when the target is reached.
  double rate() const noexcept { return rate_; }

 private:
  ScaleRates own_;
  double value_;
  double rate_ = 0;
};

}  // namespace polyarm::trajectory
