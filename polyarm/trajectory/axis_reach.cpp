#include "polyarm/trajectory/axis_reach.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/trajectory/constant_jerk.hpp"

namespace polyarm::trajectory {

namespace {
double square(double x) {
  return x * x;
}
}  // namespace

UpperReach::UpperReach(const Ends& ends, const Limits& limits) noexcept : e_(ends), l_(limits) {
  // The change of velocity while the acceleration goes straight to the target's. Right there the shortest
  // duration jumps, so what rounding has made of that change is taken for it.
  const double straight = (e_.a1 >= e_.a0 ? 1 : -1) * (square(e_.a1) - square(e_.a0)) / 2;
  const bool is_straight = std::abs(e_.v1 - e_.v0 - straight) <=
                           kRounding * (std::abs(e_.v0) + std::abs(e_.v1) + std::abs(straight));
  const double change = is_straight ? straight : e_.v1 - e_.v0;
  c_ = change + (square(e_.a0) - square(e_.a1)) / 2;
  const double up = l_.acceleration, down = l_.deceleration;
  // With the low end of the acceleration at the target's: first up, then down.
  const double up_down = c_ + square(e_.a1);
  const auto up_first = [&] {
    const double high = std::min(up, root(up_down));
    return 2 * high - e_.a0 - e_.a1 + std::max(0.0, up_down - square(up)) / up;
  };
  // With the high end at the start's: first down, then up.
  const double down_up = square(e_.a0) - c_;
  const auto down_first = [&] {
    const double low = std::min(down, root(down_up));
    return 2 * low + e_.a0 + e_.a1 + std::max(0.0, down_up - square(down)) / down;
  };
  const bool rises = is_straight ? std::max(e_.a0, e_.a1) >= 0 : change > straight;
  shortest_ = rises ? up_first() : down_first();
  island_ = mainland_ = shortest_;
  if (rises && e_.a0 > 0 && e_.a1 > 0 && down_up > 0) {
    island_ = std::max(shortest_, e_.a0 + e_.a1 - 2 * root(down_up));
    mainland_ = std::max(island_, down_first());
  } else if (!rises && e_.a0 < 0 && e_.a1 < 0 && up_down > 0) {
    island_ = std::max(shortest_, -e_.a0 - e_.a1 - 2 * root(up_down));
    mainland_ = std::max(island_, up_first());
  }
  const double climb = std::max(0.0, l_.velocity - e_.v0 + square(e_.a0) / 2);
  const double fall = std::max(0.0, l_.velocity - e_.v1 + square(e_.a1) / 2);
  top_.high = std::max(e_.a0, std::min(up, root(climb)));
  top_.high_time = std::max(0.0, climb - square(up)) / up;
  top_.low = std::min(e_.a1, -std::min(down, root(fall)));
  top_.low_time = std::max(0.0, fall - square(down)) / down;
  plateau_ = 2 * top_.high - e_.a0 + top_.high_time - 2 * top_.low + e_.a1 + top_.low_time;
}

UpperReach::Shape UpperReach::shape(double t) const noexcept {
  if (t >= plateau_) {
    Shape out = top_;
    out.cruise = t - plateau_;
    return out;
  }
  const double up = l_.acceleration, down = l_.deceleration;
  const double fall = std::max(0.0, (t + e_.a0 - e_.a1) / 2);  // high - low, where nothing stays at a limit
  const double high = fall > 0 ? (fall + c_ / fall) / 2 : e_.a1;
  if (high <= up && high - fall >= -down) {
    const double within = std::max(e_.a0, std::min(high, e_.a1 + fall));
    return {within, 0, within - fall, 0, 0};
  }
  if (high > up) {
    const double drop = root(2 * up * fall - c_);
    if (up - drop >= -down) return {up, std::max(0.0, 2 * (fall - drop)), std::min(up - drop, e_.a1), 0, 0};
  }
  if (high - fall < -down) {
    const double drop = root(2 * down * fall + c_);
    if (drop - down <= up)
      return {std::max(drop - down, e_.a0), 0, -down, std::max(0.0, 2 * (fall - drop)), 0};
  }
  const double both = std::max(0.0, 2 * (fall - up - down));
  const double above = std::clamp((c_ - square(up) + square(down) + down * both) / (up + down), 0.0, both);
  return {up, above, -down, both - above, 0};
}

double UpperReach::slope_of(const Shape& s) const noexcept {
  if (s.cruise > 0) return l_.velocity;
  // From the costates of the time-optimal motion: that of the acceleration is a parabola which is zero at
  // both ends of the fall, where its slope, that of the velocity, is zero in the middle.
  const double before_fall = e_.v0 + (square(s.high) - square(e_.a0)) / 2 + s.high * s.high_time;
  return before_fall + s.high * (s.high - s.low) / 2;
}

double UpperReach::reach_of(const Shape& s) const noexcept {
  JerkState m{0, e_.v0, e_.a0};
  const auto pass = [&](double t, double jerk) { m = after(m, t, jerk); };
  pass(s.high - e_.a0, 1);
  pass(s.high_time, 0);
  if (s.cruise > 0) {
    pass(s.high, -1);
    m = {m.p + l_.velocity * s.cruise, l_.velocity, 0};
    pass(-s.low, -1);
  } else {
    pass(s.high - s.low, -1);
  }
  pass(s.low_time, 0);
  pass(e_.a1 - s.low, 1);
  return m.p;
}

double UpperReach::reach(double t) const noexcept {
  return reach_of(shape(t));
}

double UpperReach::slope(double t) const noexcept {
  return slope_of(shape(t));
}

JerkPhases UpperReach::phases(double t) const noexcept {
  const Shape s = shape(t);
  JerkPhases out;
  const bool crosses = s.high >= 0 && s.low <= 0;
  out.time = {
      s.high - e_.a0, s.high_time,  crosses ? s.high : s.high - s.low, s.cruise, crosses ? -s.low : 0.0,
      s.low_time,     e_.a1 - s.low};
  for (double& time : out.time) time = std::max(0.0, time);
  return out;
}

/// Where the slope is least. It falls and then rises: it falls only where the acceleration keeps its sign,
/// until the ratio of its ends is 2 - sqrt(3) (or a quarter, where one of them is a limit).
double UpperReach::steepest_descent(double from, double to) const noexcept {
  const Shape first = shape(from);
  if (first.high >= 0 && first.low <= 0) return from;
  double best = from, least = slope_of(first);
  const auto look_at = [&](double fall) {
    const double t = 2 * fall - e_.a0 + e_.a1;
    if (!(t > from && t < to)) return;
    const double here = slope(t);
    if (here < least) least = here, best = t;
  };
  const double limit = first.low > 0 ? l_.acceleration : l_.deceleration, c = std::abs(c_);
  look_at(std::sqrt(c / std::sqrt(3.0)));
  look_at((square(0.75 * limit) + c) / (2 * limit));
  if (square(limit) > c) look_at(limit - std::sqrt(square(limit) - c));
  return slope(to) < least ? to : best;
}

/// Between `from` and `to`, where the slope rises through zero: where reach() is below `distance`, or its
/// least value if it is nowhere.
double UpperReach::below(double distance, double from, double to) const noexcept {
  double low = slope(from), high = slope(to), t = from;
  for (int i = 0; i < 100 && to - from > 1e-10 * to; ++i) {
    t = from - low * (to - from) / (high - low);
    if (i % 3 == 2 || !(t > from && t < to)) t = from + (to - from) / 2;
    const Shape here = shape(t);
    if (reach_of(here) < distance) return t;
    const double s = slope_of(here);
    if (std::signbit(s) == std::signbit(low))
      from = t, low = s;
    else
      to = t, high = s;
  }
  return t;
}

/// Newton's method inside a bracket in which reach() passes the distance once.
double UpperReach::time_between(double distance, double from, double to, double at_from,
                                double at_to) const noexcept {
  const bool rising = at_to > at_from;
  double t = from + (to - from) * std::cbrt(std::clamp((distance - at_from) / (at_to - at_from), 0.0, 1.0));
  for (int i = 0; i < 100; ++i) {
    const Shape s = shape(t);
    const double error = reach_of(s) - distance;
    if (error == 0) return t;
    ((error > 0) == rising ? to : from) = t;
    const double next = t - error / slope_of(s);
    if (next > from && next < to) {
      if (std::abs(next - t) <= 1e-9 * t) return next;  // the steps shrink quadratically
      t = next;
    } else {
      t = from + (to - from) / 2;
      if (to - from <= 2e-16 * to) return t;
    }
  }
  return t;
}

std::size_t UpperReach::times_of(double distance, double from, double to,
                                 std::array<double, kMostRoots>& out) const noexcept {
  std::array<double, 5> mark{};  // between these reach() is monotone
  std::size_t marks = 0, roots = 0;
  const double end = std::min(to, std::max(from, plateau_));
  mark[marks++] = from;
  const double steepest = steepest_descent(from, end);
  const double least = slope(steepest);
  double before = reach(from);
  if (least >= 0 && distance <= before) return 0;         // it rises from there
  if (steepest > from && least < 0 && slope(from) > 0) {  // first a hill
    double lo = from, hi = steepest;
    for (int i = 0; i < 60; ++i) (slope(lo + (hi - lo) / 2) > 0 ? lo : hi) = lo + (hi - lo) / 2;
    mark[marks++] = lo;
  }
  const double above = marks > 1 ? reach(mark[1]) : before;
  if (least < 0 && end > steepest && above >= distance && slope(end) > 0)  // then a valley
    mark[marks++] = below(distance, steepest, end);
  if (end > from) mark[marks++] = end;

  for (std::size_t i = 1; i < marks; ++i) {
    const double after = reach(mark[i]);
    if ((before < distance) != (after < distance) && roots < out.size())
      out[roots++] = time_between(distance, mark[i - 1], mark[i], before, after);
    before = after;
  }
  if (to > end && before < distance && roots < out.size()) {
    const double t = end + (distance - before) / l_.velocity;
    if (t <= to) out[roots++] = t;
  }
  return roots;
}

}  // namespace polyarm::trajectory
