#pragma once
/// Finds the shortest duration from state to state by trying profiles, to judge the generator. The two share
/// nothing: the generator uses reachable displacements in closed form; this search tries many cruise
/// velocities and accelerations, bisects roots between two of them, and runs and checks each profile. Every
/// duration that it finds is possible; it cannot prove that there is no shorter one.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::test {

class SlowAxis {
 public:
  SlowAxis(const trajectory::MotionState& from, const trajectory::MotionState& to,
           const trajectory::MotionLimits& limits)
      : from_(from), to_(to), l_(limits) {}

  /// The shortest duration found, s; infinite if none.
  double shortest() const {
    double best = std::numeric_limits<double>::infinity();
    const auto take = [&](const Profile& p) {
      if (p.duration() < best && keeps(p)) best = p.duration();
    };
    // Profiles with a peak velocity; if that is the limit, the axis cruises there.
    each_pair([&](int first, int second) {
      scan(
          l_.min_velocity, l_.max_velocity, [&](double v) { return peak(v, 0, first, second); }, take);
    });
    for (const double v : {l_.min_velocity, l_.max_velocity})
      each_pair([&](int first, int second) {
        Profile p = peak(v, 0, first, second);
        const double left = (to_.position - from_.position - p.end.position) / v;
        if (p.valid && left >= 0) take(peak(v, left, first, second));
      });
    // Profiles whose acceleration does not pass through zero.
    scan(
        l_.min_acceleration, l_.max_acceleration, [&](double a) { return direct(a); }, take);
    return best;
  }
  /// True if a profile was found that takes exactly `duration`.
  bool can(double duration) const {
    bool found = false;
    each_pair([&](int first, int second) {
      if (found) return;
      scan(
          l_.min_velocity, l_.max_velocity,
          [&](double v) {
            const Profile p = peak(v, 0, first, second);
            return p.valid && p.duration() <= duration ? peak(v, duration - p.duration(), first, second)
                                                       : Profile{};
          },
          [&](const Profile& p) {
            found = found || (keeps(p) && std::abs(p.duration() - duration) < 1e-9 * duration);
          });
    });
    return found;
  }

 private:
  static constexpr int kSteps = 240, kWays = 6;

  struct Profile {
    bool valid = false;
    std::vector<std::pair<double, double>> parts;  // time, jerk
    trajectory::MotionState end;                   // from position 0
    double duration() const {
      double sum = 0;
      for (const auto& [time, jerk] : parts) sum += time;
      return sum;
    }
    void add(double t, double j) {
      parts.emplace_back(t, j);
      end = {end.position + t * (end.velocity + t * (end.acceleration / 2 + t * j / 6)),
             end.velocity + t * (end.acceleration + t * j / 2), end.acceleration + t * j};
    }
  };

  template <typename Each>
  static void each_pair(Each each) {
    for (int first = 0; first < kWays; ++first)
      for (int second = 0; second < kWays; ++second) each(first, second);
  }

  /// Adds a change to velocity `v` and acceleration `a` in one of six ways: over a peak acceleration above
  /// both (two roots), with the upper limit held, and the three mirrored. Invalid if that way does not exist.
  void change(Profile& p, double v, double a, int way) const {
    const double sign = way < 3 ? 1 : -1, j = l_.max_jerk;
    const double a0 = sign * p.end.acceleration, a1 = sign * a, dv = sign * (v - p.end.velocity);
    const double limit = way < 3 ? l_.max_acceleration : -l_.min_acceleration;
    const double square = (2 * j * dv + a0 * a0 + a1 * a1) / 2;
    double top = limit, hold = 0;
    if (way % 3 == 2) {
      hold = (dv - (2 * limit * limit - a0 * a0 - a1 * a1) / (2 * j)) / limit;
    } else {
      if (square < 0) return invalid(p);
      top = (way % 3 == 0 ? 1 : -1) * std::sqrt(square);
    }
    const double slack = 1e-12 * limit;
    if (hold < 0 || top > limit + slack || top < std::max(a0, a1) - slack) return invalid(p);
    p.add(std::max(0.0, (top - a0) / j), sign * j);
    if (hold > 0) p.add(hold, 0);
    p.add(std::max(0.0, (top - a1) / j), -sign * j);
  }
  static void invalid(Profile& p) { p.valid = false; }

  /// To velocity `v` at zero acceleration, cruise there for `cruise`, then to the target.
  Profile peak(double v, double cruise, int first, int second) const {
    Profile p = begin();
    change(p, v, 0, first);
    if (!p.valid) return p;
    p.add(cruise, 0);
    change(p, to_.velocity, to_.acceleration, second);
    return p;
  }
  /// To acceleration `a`, which is held so that the target's velocity results.
  Profile direct(double a) const {
    Profile p = begin();
    const auto turn = [&](double to) {
      const double d = to - p.end.acceleration;
      p.add(std::abs(d) / l_.max_jerk, d < 0 ? -l_.max_jerk : l_.max_jerk);
    };
    turn(a);
    Profile rest = p;
    rest.add(std::abs(to_.acceleration - a) / l_.max_jerk, to_.acceleration < a ? -l_.max_jerk : l_.max_jerk);
    const double hold = (to_.velocity - rest.end.velocity) / a;
    if (!(hold >= 0) || !std::isfinite(hold)) return {};
    p.add(hold, 0);
    turn(to_.acceleration);
    return p;
  }
  Profile begin() const {
    Profile p;
    p.valid = true;
    p.end = {0, from_.velocity, from_.acceleration};
    return p;
  }

  /// Calls `take` with every profile between `low` and `high` that ends at the target's position.
  template <typename Make, typename Take>
  void scan(double low, double high, Make make, Take take) const {
    const double distance = to_.position - from_.position;
    Profile before;
    double at = low;
    for (int k = 0; k <= kSteps; ++k) {
      const double x = low + (high - low) * (k + 0.5 * (k > 0 && k < kSteps) * 0.37) / kSteps;
      const Profile here = make(x);
      if (before.valid && here.valid && (before.end.position < distance) != (here.end.position < distance))
        bisect(at, x, before.end.position < distance, make, take);
      before = here, at = x;
    }
  }
  template <typename Make, typename Take>
  void bisect(double low, double high, bool below, Make make, Take take) const {
    const double distance = to_.position - from_.position;
    for (int k = 0; k < 100; ++k) {
      const double middle = (low + high) / 2;
      const Profile p = make(middle);
      if (!p.valid) return;
      ((p.end.position < distance) == below ? low : high) = middle;
    }
    take(make((low + high) / 2));
  }

  /// Runs the profile. True if it arrives at the target and stays within the limits.
  bool keeps(const Profile& p) const {
    if (!p.valid) return false;
    const double room = 1e-9;
    const auto inside = [&](double v, double a) {
      return v <= l_.max_velocity * (1 + room) && v >= l_.min_velocity * (1 + room) &&
             a <= l_.max_acceleration * (1 + room) && a >= l_.min_acceleration * (1 + room);
    };
    Profile run = begin();
    for (const auto& [time, jerk] : p.parts) {
      const double zero = jerk != 0 ? -run.end.acceleration / jerk : -1;
      if (zero > 0 && zero < time && !inside(run.end.velocity + zero * run.end.acceleration / 2, 0))
        return false;
      run.add(time, jerk);
      if (!inside(run.end.velocity, run.end.acceleration)) return false;
    }
    const double way = std::abs(to_.position - from_.position) + l_.max_velocity * run.duration();
    return std::abs(run.end.position - (to_.position - from_.position)) <= 1e-9 * way &&
           std::abs(run.end.velocity - to_.velocity) <= 1e-9 * l_.max_velocity &&
           std::abs(run.end.acceleration - to_.acceleration) <= 1e-9 * l_.max_acceleration;
  }

  trajectory::MotionState from_, to_;
  trajectory::MotionLimits l_;
};

/// All axes together: the longest of the shortest durations, or the next duration that all axes can take, in
/// steps of half a percent; infinite if there is none up to five times the longest.
inline double slow_synchronised(std::span<const trajectory::MotionState> from,
                                std::span<const trajectory::MotionState> to,
                                std::span<const trajectory::MotionLimits> limits) {
  std::vector<SlowAxis> axes;
  std::vector<double> shortest;
  for (std::size_t i = 0; i < from.size(); ++i) {
    axes.emplace_back(from[i], to[i], limits[i]);
    shortest.push_back(axes.back().shortest());
  }
  const auto last = std::max_element(shortest.begin(), shortest.end());
  const auto lead = std::size_t(last - shortest.begin());
  for (double t = *last, factor = 1; factor < 5 && std::isfinite(t); factor *= 1.005, t = *last * factor) {
    bool all = true;
    for (std::size_t i = 0; all && i < axes.size(); ++i)
      all = (i == lead && factor == 1) || (shortest[i] == t) || axes[i].can(t);
    if (all) return t;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace polyarm::test
