#pragma once
/// How far one axis can come in a given time. Used by state_to_state.cpp only.
///
/// Of all motions of duration T from one velocity and acceleration to another, within limits of velocity,
/// acceleration and jerk, the displacements form an interval, since limits and dynamics are convex. Its upper
/// end is reached by raising the acceleration at full jerk, holding it at its limit, lowering it through zero
/// (with a cruise at the limit of velocity), holding it at its lower limit and raising it to the target's.
/// For a given T that motion follows from quadratic equations; the lower end is that of the mirrored axis.
/// Everything is in units in which the jerk is 1. No allocation, no exceptions, any thread.
#include <array>
#include <cmath>
#include <cstddef>

namespace polyarm::trajectory {

/// Relative: what the arithmetic of a plan from a sampled state may lose.
constexpr double kRounding = 1e-12;

/// 0 where rounding has gone below zero.
inline double root(double x) noexcept {
  return x > 0 ? std::sqrt(x) : 0.0;
}

/// Piecewise constant jerk; `jerk[i]` for `time[i]` >= 0.
struct JerkPhases {
  static constexpr std::size_t kMost = 7;
  std::array<double, kMost> time{};
  std::array<double, kMost> jerk{1, 0, -1, 0, -1, 0, 1};
};

/// The upper end of the interval of displacements.
class UpperReach {
 public:
  struct Ends {
    double v0, a0, v1, a1;  ///< velocity and acceleration at the start and at the end
  };
  struct Limits {
    double velocity;      ///< upper, > 0
    double acceleration;  ///< upper, > 0
    double deceleration;  ///< magnitude of the lower one, > 0
  };
  UpperReach(const Ends& ends, const Limits& limits) noexcept;

  /// The durations for which there is a motion at all are [shortest(), island()] and [mainland(), infinity).
  /// The island exists where both accelerations have the same sign and is empty otherwise: island() ==
  /// shortest() == mainland().
  double shortest() const noexcept { return shortest_; }
  double island() const noexcept { return island_; }
  double mainland() const noexcept { return mainland_; }
  bool has_island() const noexcept { return mainland_ > island_; }

  /// The displacement after the duration `t`, and its derivative by t.
  double reach(double t) const noexcept;
  double slope(double t) const noexcept;
  JerkPhases phases(double t) const noexcept;

  /// All durations in [from, to] at which reach() passes `distance`, ascending; returns how many. `to` may be
  /// infinite. Both lie in the island, or both in the mainland.
  static constexpr std::size_t kMostRoots = 4;
  std::size_t times_of(double distance, double from, double to,
                       std::array<double, kMostRoots>& out) const noexcept;

 private:
  /// Where the acceleration turns, and how long it stays there.
  struct Shape {
    double high, high_time, low, low_time, cruise;
  };
  Shape shape(double t) const noexcept;
  double slope_of(const Shape& shape) const noexcept;
  double reach_of(const Shape& shape) const noexcept;
  double steepest_descent(double from, double to) const noexcept;
  double below(double distance, double from, double to) const noexcept;
  double time_between(double distance, double from, double to, double at_from, double at_to) const noexcept;

  Ends e_;
  Limits l_;
  double c_;  // high² - low² of every motion that does not stay at a limit
  double shortest_ = 0, island_ = 0, mainland_ = 0;
  Shape top_{};         // the motion that just touches the velocity limit
  double plateau_ = 0;  // its duration
};

}  // namespace polyarm::trajectory
