#pragma once
/// How far one axis can move in a given time, and how soon it can cover a distance. Part of
/// state_to_state.hpp.
///
/// All motions of duration T from one velocity and acceleration to another, within limits of velocity,
/// acceleration and jerk, have displacements that form an interval, because limits and dynamics are convex.
/// The motion to its upper end raises the acceleration at full jerk to `high`, holds it if that is its limit,
/// lowers it to -`low` (with a cruise at the velocity limit where it passes zero), holds it if that is its
/// limit, and raises it to the target's. The lower end is that of the mirrored axis.
///
/// With w = v - a²/2 at either end, c = w1 - w0 = high² - low² and f = high + low, the upper end is
///   f³/4 + (w0 + w1) f - c²/4f + const, T = 2f - a0 + a1, if nothing is held at a limit;
///   a polynomial of fourth degree in low (or high), if the other one is held;
///   a parabola in the velocity at the top, if both are held;
///   a straight line in T, with a cruise.
/// So reach() and its roots need no integration.
///
/// Units: the jerk is 1; times are seconds, all other quantities are divided by the jerk. No allocation, no
/// exceptions, any thread.
#include <array>
#include <cmath>
#include <cstddef>

namespace polyarm::trajectory {

/// Relative rounding error of a plan from a sampled state.
constexpr double kRounding = 1e-12;

/// The square root; 0 for negative rounding errors.
inline double root(double x) noexcept {
  return std::sqrt(x > 0 ? x : 0);
}

/// Piecewise constant jerk: `jerk[i]` for `time[i]` >= 0.
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

/// Magnitudes, all > 0; upwards is the positive direction.
struct AxisBounds {
  double velocity, acceleration, deceleration;
};

/// The durations for which a motion exists: [shortest, island] and [mainland, infinity). The island exists if
/// both accelerations have the same sign and is empty otherwise: island == shortest == mainland. The mirrored
/// axis has the same durations.
struct AxisTimes {
  double shortest, island, mainland;
  double change;  ///< of velocity
  bool rises;     ///< the shortest motion raises the acceleration first
  bool has_island() const noexcept { return mainland > island; }

  static AxisTimes of(const AxisEnds& ends, double acceleration, double deceleration) noexcept;
};

/// The largest displacement for each duration.
class UpperReach {
 public:
  /// Call it first. `times`: of these ends, or of the mirrored ones if `mirrored` is set.
  void set(const AxisEnds& ends, const AxisBounds& bounds, const AxisTimes& times, bool mirrored) noexcept;
  /// The same for a motion from rest to rest.
  void set_between_rests(const AxisBounds& bounds) noexcept;

  /// The displacement after the duration `t`, and its derivative with respect to t.
  double reach(double t) const noexcept;
  double slope(double t) const noexcept;
  JerkPhases phases(double t) const noexcept;

  /// The first duration from `shortest` on at which reach() equals `distance`, which must be more than
  /// reach(shortest); only for ends without an island. Returns NaN in the rare case that needs times_of().
  double first_time(double distance) const noexcept;

  /// All durations in [from, to] at which reach() passes `distance`, ascending; returns their number. `to`
  /// may be infinite. Both ends must lie in the island, or both in the mainland.
  static constexpr std::size_t kMostRoots = 4;
  std::size_t times_of(double distance, double from, double to,
                       std::array<double, kMostRoots>& out) const noexcept;

 private:
  /// The peaks of the acceleration, and the time at each. Here `low` is signed.
  struct Shape {
    double high, high_time, low, low_time, cruise;
  };
  /// The quantity held at its limit, and the remaining free number: f, `low`, `high`, the velocity at the
  /// top, or the duration.
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
  /// of the time from there.
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

  // Deliberately uninitialised: plans reserve space for many axes.
  AxisEnds e_;
  AxisBounds l_;
  double shortest_;
  bool one_sign_;   // the acceleration of the shortest motion does not pass zero
  double w0_, w1_;  // see above
  double c_, sum_;  // w1 - w0, w0 + w1
  double offset_;
  double plateau_;            // duration of the motion that just reaches the velocity limit
  double top_up_, top_down_;  // its half_up and half_down
  double top_;                // its displacement
};

}  // namespace polyarm::trajectory
