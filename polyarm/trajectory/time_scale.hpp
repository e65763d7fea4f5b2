#pragma once

namespace polyarm::trajectory {

/// The speed at which a trajectory's time runs: 1 as planned, 0 held. It changes smoothly, so that slowing
/// down, holding and resuming stay exactly on the path. Between two values the scale follows a cubic
/// smoothstep with zero slope at both ends, over a time proportional to the change. With a ramp of T seconds
/// the path acceleration that a full stop adds is at most 1.5 v / T (v the velocity at that moment), and its
/// jerk at most 6 v / T². No allocation, no exceptions; control thread.
class TimeScale {
 public:
  /// `ramp_s`: seconds from 1 to 0.
  explicit TimeScale(double ramp_s = 0.25) : ramp_(ramp_s) {}

  /// Advances by `dt` seconds of clock towards `target` in [0, 1]; returns the seconds of trajectory time
  /// that pass.
  double advance(double dt, double target) noexcept;
  double value() const noexcept { return value_; }

 private:
  double ramp_;
  double value_ = 1;
  double from_ = 1, to_ = 1;  // of the ramp under way
  double elapsed_ = 0, length_ = 0;
  bool ramping_ = false;
};

}  // namespace polyarm::trajectory
