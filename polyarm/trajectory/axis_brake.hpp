#pragma once
/// Brings an axis back inside its limits. Part of state_to_state.hpp.
///
/// An axis is inside if it can stay inside: its acceleration and velocity are within their limits, and so is
/// the velocity after the acceleration returns to zero at full jerk. The acceleration returns first, at full
/// jerk, and then stays within its limits; of all such motions the brake takes the shortest. Units as in
/// axis_reach.hpp: the jerk is 1. Control cycle: no allocation, no exceptions, any thread.
#include <array>
#include <cstddef>

#include "polyarm/trajectory/constant_jerk.hpp"

namespace polyarm::trajectory {

struct AxisBrake {
  static constexpr std::size_t kMost = 4;

  JerkState at;  ///< before braking, then after it
  std::array<double, kMost> time, jerk;
  std::size_t count;
  double total;

  /// Brakes from `at`. Limits of velocity and acceleration upwards, and their magnitudes downwards.
  void run(double fast, double back, double up, double down) noexcept;

 private:
  void pass(double t, double j) noexcept;
  void slow_down(double side, double bound, double deceleration, double width) noexcept;
};

}  // namespace polyarm::trajectory
