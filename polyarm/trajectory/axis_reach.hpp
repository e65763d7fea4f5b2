#pragma once
/// How far one axis can come in a given time, and how soon it can come that far. Part of state_to_state.hpp.
///
/// Of all motions of duration T from one velocity and acceleration to another, within limits of velocity,
/// acceleration and jerk, the displacements form an interval, since limits and dynamics are convex. Its upper
/// end is reached by raising the acceleration at full jerk to `high`, holding it there if that is its limit,
/// lowering it to -`low` (with a cruise at the limit of velocity where it passes zero), holding it there if
/// that is its limit, and raising it to the target's. The lower end is that of the mirrored axis.
///
/// With w = v - a²/2 at either end, c = w1 - w0 = high² - low² and f = high + low, the upper end is
///   f³/4 + (w0 + w1) f - c²/4f + const,  T = 2f - a0 + a1             where nothing stays at a limit,
///   a polynomial of fourth degree in low (or high)                    where the other one is held,
///   a parabola in the velocity at the top                             where both are held,
/// and a straight line in T with a cruise. So reach() and its roots need no integration.
///
/// Units: the jerk is 1; times are seconds, all else is per jerk. No allocation, no exceptions, any thread.
#include <array>
#include <cmath>
#include <cstddef>

namespace polyarm::trajectory {

/// Relative: what the arithmetic of a plan from a sampled state may lose.
constexpr double kRounding = 1e-12;

/// 0 where rounding has gone below zero.
inline double root(double x) noexcept {
  return std::sqrt(x > 0 ? x : 0);
}

/// Piecewise constant jerk; `jerk[i]` for `time[i]` >= 0.
struct JerkPhases {
  static constexpr std::size_t kMost = 7;
  static constexpr std::array<double, kMost> jerk{1, 0, -1, 0, -1, 0, 1};
  std::array<double, kMost> time;
};

/// Velocity and acceleration at the start and at the end.
struct AxisEnds {
  double v0, a0, v1, a1;

  AxisEnds mirrored() const noexcept { return {-v0, -a0, -v1, -a1}; }
};

/// Magnitudes, all > 0, in the direction that counts as upwards.
struct AxisBounds {
  double velocity, acceleration, deceleration;
};

/// The durations for which there is a motion at all: [shortest, island] and [mainland, infinity). The island
/// exists where both accelerations have the same sign and is empty otherwise: island == shortest == mainland.
/// The mirrored axis has the same.
struct AxisTimes {
  double shortest, island, mainland;
  double change;  ///< of velocity
  bool rises;     ///< the shortest motion raises the acceleration first
  bool has_island() const noexcept { return mainland > island; }

  static AxisTimes of(const AxisEnds& ends, double acceleration, double deceleration) noexcept;
};

/// The upper end of the interval of displacements.
class UpperReach {
 public:
  /// Comes first. `times`: of these ends, or of the mirrored ones with `mirrored` set.
  void set(const AxisEnds& ends, const AxisBounds& bounds, const AxisTimes& times, bool mirrored) noexcept;
  /// The same for a motion from rest to rest.
  void set_between_rests(const AxisBounds& bounds) noexcept;

  /// The displacement after the duration `t`, and its derivative by t.
  double reach(double t) const noexcept;
  double slope(double t) const noexcept;
  JerkPhases phases(double t) const noexcept;

  /// The first duration from `shortest` on at which reach() comes up to `distance`, which is more than
  /// reach(shortest); for ends without an island. NaN in the rare case in which that takes times_of().
  double first_time(double distance) const noexcept;

  /// All durations in [from, to] at which reach() passes `distance`, ascending; returns how many. `to` may be
  /// infinite. Both lie in the island, or both in the mainland.
  static constexpr std::size_t kMostRoots = 4;
  std::size_t times_of(double distance, double from, double to,
                       std::array<double, kMostRoots>& out) const noexcept;

 private:
  /// Where the acceleration turns, and how long it stays there. Here `low` has its sign.
  struct Shape {
    double high, high_time, low, low_time, cruise;
  };
  /// What is held at its limit; the number that tells the rest: f, `low`, `high`, the velocity at the top, or
  /// the duration.
  enum class Held { nothing, high, low, both, velocity };
  struct Form {
    Held held;
    double x;
  };
  Form form(double t) const noexcept;
  Shape shape(double t) const noexcept;
  double reach_of(Form form) const noexcept;
  double slope_of(Form form) const noexcept;
  /// Half of the time that the acceleration takes up and back down to the velocity `v` at the top, and half
  /// of that from there.
  double half_up(double v) const noexcept;
  double half_down(double v) const noexcept;
  double reach_over(double v) const noexcept { return reach_over(v, half_up(v), half_down(v)); }
  double reach_over(double v, double up, double down) const noexcept {
    return (v + w0_) * up + (v + w1_) * down + offset_;
  }
  double time_over(double up, double down) const noexcept { return 2 * (up + down) - e_.a0 + e_.a1; }
  double solve_free(double distance, double least, double most) const noexcept;
  double solve_held(double distance, Held held, double from, double to) const noexcept;
  double solve_both(double distance) const noexcept;
  bool comes_up_once() const noexcept;
  double steepest_descent(double from, double to) const noexcept;
  double top_of_hill(double from, double to) const noexcept;
  double below(double distance, double from, double to) const noexcept;
  double time_between(double distance, double from, double to, double at_from, double at_to) const noexcept;

  // Without initial values: plans make room for many axes.
  AxisEnds e_;
  AxisBounds l_;
  double shortest_;
  bool one_sign_;   // the shortest motion's acceleration does not pass zero
  double w0_, w1_;  // see above
  double c_, sum_;  // w1 - w0, w0 + w1
  double offset_;
  double plateau_;            // the duration of the motion that just touches the velocity limit
  double top_up_, top_down_;  // its half_up and half_down
  double top_;                // its displacement
};

}  // namespace polyarm::trajectory
