#pragma once
/// Motion under constant jerk, in any consistent units. Private to this room: any thread, no allocation.

namespace polyarm::trajectory {

/// Position, velocity and acceleration, of an axis or along a path.
struct JerkState {
  double p = 0, v = 0, a = 0;
};

/// The state `t` after `s` (before it, if negative): p + v t + a t²/2 + jerk t³/6 and its derivatives.
inline JerkState after(const JerkState& s, double t, double jerk) noexcept {
  return {s.p + t * (s.v + t * (s.a / 2 + t * jerk / 6)), s.v + t * (s.a + t * jerk / 2), s.a + t * jerk};
}

}  // namespace polyarm::trajectory
