#include "polyarm/trajectory/axis_reach.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace polyarm::trajectory {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kSettled =
    3e-9;  // relative step of Newton's method after which the next one is below rounding

double square(double x) {
  return x * x;
}

/// An upper bound of the cube root of x >= 0, at most 8 % too large: divides the exponent by three.
double about_cube_root(double x) {
  return 1.04 * std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + 0x2a9f7893'00000000);
}

}  // namespace

AxisTimes AxisTimes::of(const AxisEnds& e, double up, double down) noexcept {
  AxisTimes out;
  const double square0 = square(e.a0), square1 = square(e.a1);
  // The change of velocity while the acceleration goes directly to the target's. The shortest duration jumps
  // there, so values within rounding count as equal.
  const double straight = (e.a1 >= e.a0 ? 0.5 : -0.5) * (square1 - square0);
  const double difference = e.v1 - e.v0;
  const bool is_straight =
      std::abs(difference - straight) <= kRounding * (std::abs(e.v0) + std::abs(e.v1) + std::abs(straight));
  out.change = is_straight ? straight : difference;
  const double c = out.change + (square0 - square1) / 2;
  // If `low` is at the target's acceleration: first up, then down. If `high` is at the start's: first down,
  // then up.
  const double up_down = c + square1, down_up = square0 - c;
  const auto up_first = [&] {
    const double held = up_down - square(up);
    return (held > 0 ? 2 * up + held / up : 2 * root(up_down)) - e.a0 - e.a1;
  };
  const auto down_first = [&] {
    const double held = down_up - square(down);
    return (held > 0 ? 2 * down + held / down : 2 * root(down_up)) + e.a0 + e.a1;
  };
  out.rises = is_straight ? std::max(e.a0, e.a1) >= 0 : out.change > straight;
  out.shortest = out.rises ? up_first() : down_first();
  out.island = out.mainland = out.shortest;
  if (out.rises && e.a0 > 0 && e.a1 > 0 && down_up > 0) {
    out.island = std::max(out.shortest, e.a0 + e.a1 - 2 * root(down_up));
    out.mainland = std::max(out.island, down_first());
  } else if (!out.rises && e.a0 < 0 && e.a1 < 0 && up_down > 0) {
    out.island = std::max(out.shortest, -e.a0 - e.a1 - 2 * root(up_down));
    out.mainland = std::max(out.island, up_first());
  }
  return out;
}

void UpperReach::set(const AxisEnds& ends, const AxisBounds& bounds, const AxisTimes& times,
                     bool mirrored) noexcept {
  e_ = ends, l_ = bounds, shortest_ = times.shortest;
  const double square0 = square(e_.a0), square1 = square(e_.a1);
  one_sign_ = times.rises != mirrored ? e_.a1 > 0 : e_.a0 < 0;
  c_ = (mirrored ? -times.change : times.change) + (square0 - square1) / 2;
  w0_ = e_.v0 - square0 / 2, w1_ = w0_ + c_, sum_ = w0_ + w1_;
  offset_ = e_.a1 * (w1_ + square1 / 6) - e_.a0 * (w0_ + square0 / 6);
  // At least as high as the start's acceleration and as low as the target's, in spite of rounding.
  top_up_ = std::max(e_.a0, half_up(l_.velocity)), top_down_ = std::max(-e_.a1, half_down(l_.velocity));
  plateau_ = time_over(top_up_, top_down_);
  top_ = reach_over(l_.velocity, top_up_, top_down_);
}

void UpperReach::set_between_rests(const AxisBounds& bounds) noexcept {
  e_ = {0, 0, 0, 0}, l_ = bounds, shortest_ = 0, one_sign_ = false;
  w0_ = w1_ = c_ = sum_ = offset_ = 0;
  top_up_ = half_up(bounds.velocity), top_down_ = half_down(bounds.velocity);
  plateau_ = 2 * (top_up_ + top_down_), top_ = bounds.velocity * (top_up_ + top_down_);
}

double UpperReach::half_up(double v) const noexcept {
  const double climb = v - w0_, held = climb - square(l_.acceleration);
  return held > 0 ? l_.acceleration + held / (2 * l_.acceleration) : root(climb);
}

double UpperReach::half_down(double v) const noexcept {
  const double fall = v - w1_, held = fall - square(l_.deceleration);
  return held > 0 ? l_.deceleration + held / (2 * l_.deceleration) : root(fall);
}

UpperReach::Form UpperReach::form(double t) const noexcept {
  if (t >= plateau_) return {Held::velocity, t};
  const double up = l_.acceleration, down = l_.deceleration;
  const double f = std::max(0.0, (t + e_.a0 - e_.a1) / 2);
  const double high = f > 0 ? (f + c_ / f) / 2 : e_.a1;
  if (high <= up && f - high <= down) return {Held::nothing, f};
  if (high > up) {
    const double low = root(2 * up * f - c_) - up;
    if (low <= down) return {Held::high, low};
  }
  if (f - high > down) {
    const double held = root(2 * down * f + c_) - down;
    if (held <= up) return {Held::low, held};
  }
  return {Held::both, (2 * f * up * down - up * down * (up + down) + w0_ * down + w1_ * up) / (up + down)};
}

double UpperReach::reach_of(Form form) const noexcept {
  const double x = form.x, up = l_.acceleration, down = l_.deceleration;
  switch (form.held) {
    case Held::nothing:
      return x > 0 ? x * (square(x) / 4 + sum_) - square(c_) / (4 * x) + offset_ : offset_;
    case Held::high:
      return reach_over(w1_ + square(x), (up + (square(x) + c_) / up) / 2, x);
    case Held::low:
      return reach_over(w0_ + square(x), x, (down + (square(x) - c_) / down) / 2);
    case Held::both:
      return reach_over(x, (up + (x - w0_) / up) / 2, (down + (x - w1_) / down) / 2);
    case Held::velocity:
      break;
  }
  return top_ + l_.velocity * (x - plateau_);
}

/// From the costates of the time-optimal motion: the costate of the acceleration is a parabola that is zero
/// at both ends of the fall; its slope, the costate of the velocity, is zero in the middle.
double UpperReach::slope_of(Form form) const noexcept {
  const double x = form.x, up = l_.acceleration, down = l_.deceleration;
  switch (form.held) {
    case Held::nothing:
      return x > 0 ? (0.75 * square(x) + sum_ + square(c_ / (2 * x))) / 2 : sum_ / 2;
    case Held::high:
      return w1_ + x * (x + up / 2);
    case Held::low:
      return w0_ + x * (x + down / 2);
    case Held::both:
      return x + up * down / 2;
    case Held::velocity:
      break;
  }
  return l_.velocity;
}

double UpperReach::reach(double t) const noexcept {
  return reach_of(form(t));
}

double UpperReach::slope(double t) const noexcept {
  return slope_of(form(t));
}

UpperReach::Shape UpperReach::shape(double t) const noexcept {
  const Form f = form(t);
  const double x = f.x, up = l_.acceleration, down = l_.deceleration;
  switch (f.held) {
    case Held::nothing: {
      const double high = x > 0 ? (x + c_ / x) / 2 : e_.a1;
      const double within = std::max(e_.a0, std::min(high, e_.a1 + x));
      return {within, 0, within - x, 0, 0};
    }
    case Held::high:
      return {up, std::max(0.0, (square(x) + c_) / up - up), std::min(-x, e_.a1), 0, 0};
    case Held::low:
      return {std::max(x, e_.a0), 0, -down, std::max(0.0, (square(x) - c_) / down - down), 0};
    case Held::both:
      return {up, std::max(0.0, (x - w0_) / up - up), -down, std::max(0.0, (x - w1_) / down - down), 0};
    case Held::velocity:
      break;
  }
  const double high = std::min(up, top_up_), low = std::min(down, top_down_);
  return {high, 2 * (top_up_ - high), -low, 2 * (top_down_ - low), x - plateau_};
}

JerkPhases UpperReach::phases(double t) const noexcept {
  const Shape s = shape(t);
  const bool crosses = s.high >= 0 && s.low <= 0;
  JerkPhases out;
  out.time = {
      s.high - e_.a0, s.high_time,  crosses ? s.high : s.high - s.low, s.cruise, crosses ? -s.low : 0.0,
      s.low_time,     e_.a1 - s.low};
  for (double& time : out.time) time = std::max(0.0, time);
  return out;
}

// --- the first duration

/// True if reach() passes a distance only once from the shortest duration on, if the acceleration does not
/// pass zero at first: the slope then falls and rises, and must stay positive or begin negative.
bool UpperReach::comes_up_once() const noexcept {
  const bool rises = e_.a1 > 0;  // over `high` down to the target's acceleration
  const double limit = square(rises ? l_.acceleration : l_.deceleration);
  const double turn = rises ? c_ + square(e_.a1) : square(e_.a0) - c_;  // squared, if nothing is held
  const double least_free = sum_ + std::sqrt(0.75) * std::abs(c_);
  const double least_held = (rises ? w1_ : w0_) - limit / 16;
  return (least_free >= 0 && (turn < limit || least_held >= 0)) || slope(shortest_) <= 0;
}

double UpperReach::first_time(double distance) const noexcept {
  // From here on the acceleration passes zero: the velocity at the top determines the motion.
  double low = std::max(w0_, w1_);
  if (e_.a0 > 0) low = std::max(low, w0_ + square(e_.a0));
  if (e_.a1 < 0) low = std::max(low, w1_ + square(e_.a1));
  if (one_sign_) {
    if (!comes_up_once()) return kNone;
    const double at_low = reach_over(low);
    if (at_low >= distance)
      return time_between(distance, shortest_, time_over(half_up(low), half_down(low)), reach(shortest_),
                          at_low);
  }
  if (distance >= top_) return plateau_ + (distance - top_) / l_.velocity;
  if (low >= l_.velocity) return kNone;

  const double up = l_.acceleration, down = l_.deceleration;
  const double up_at = w0_ + square(up), down_at = w1_ + square(down);  // from here on they are held
  const double one = std::min(up_at, down_at), both = std::max(up_at, down_at);
  if (both < l_.velocity && distance >= reach_over(both)) return solve_both(distance);
  const double one_ends = std::min(both, l_.velocity);
  if (one < l_.velocity && (one <= low || distance >= reach_over(one)))
    return solve_held(distance, up_at < down_at ? Held::high : Held::low, std::max(one, low), one_ends);
  const double ends = std::min(one, l_.velocity);
  return solve_free(distance, root(low - w0_) + root(low - w1_), root(ends - w0_) + root(ends - w1_));
}

double UpperReach::solve_both(double distance) const noexcept {
  // Per 1/2up + 1/2down: v² + (up + down) m v, where m is up·down/(up + down); the rest is constant.
  const double up = l_.acceleration, down = l_.deceleration, m = up * down / (up + down);
  const double half = m * (up + down) / 2;
  const double rest = m * ((up - w0_ / up) * w0_ + (down - w1_ / down) * w1_ + 2 * (offset_ - distance));
  const double v = -rest / (half + root(square(half) - rest));
  return time_over((up + (v - w0_) / up) / 2, (down + (v - w1_) / down) / 2);
}

/// f³/4 + (w0 + w1) f - c²/4f = distance - offset by Newton's method, from above: there it rises and is
/// convex, so no step passes the root.
double UpperReach::solve_free(double distance, double least, double most) const noexcept {
  const double q = square(c_) / 4, k = distance - offset_;
  double f;
  if (q == 0 && sum_ == 0) {
    f = std::cbrt(4 * k);
  } else {
    const double k_most = q > 0 ? k + q / least : k;
    f = most;
    if (sum_ >= 0 && k_most > 0) {
      f = std::min(f, about_cube_root(4 * k_most));
      if (sum_ * f > k_most) f = k_most / sum_;
    }
    for (int i = 0; i < 60; ++i) {
      const double per = 1 / f, qf = q * per, ff = square(f);
      const double step = (f * (ff / 4 + sum_) - qf - k) / (0.75 * ff + sum_ + qf * per);
      f -= step;
      if (!(step > kSettled * f)) break;
    }
  }
  return 2 * f - e_.a0 + e_.a1;
}

/// The same if one acceleration is held: a polynomial of fourth degree in the other one, between the
/// velocities `from` and `to` at the top.
double UpperReach::solve_held(double distance, Held held, double from, double to) const noexcept {
  const bool high = held == Held::high;
  const double limit = high ? l_.acceleration : l_.deceleration;
  const double own = high ? w1_ : w0_, other = high ? w0_ : w1_;
  const double least = root(from - own), most = root(to - own);
  // x⁴/2A + x³ + (w/A + A/2) x² + 2 w x + const, whose derivative is (x + A)(2x²/A + x + 2w/A).
  const double per = 0.5 / limit;
  const double k2 = 2 * own * per + limit / 2, k1 = 2 * own;
  const double k0 = (square(own) - square(other)) * per + limit * (own + other) / 2 + offset_ - distance;
  const auto value = [&](double x) { return k0 + x * (k1 + x * (k2 + x * (1 + x * per))); };
  const double at_least = value(least), at_most = value(most);
  double x = least - at_least * (most - least) / (at_most - at_least);
  if (!(x > least && x < most)) x = most;
  for (int i = 0; i < 40; ++i) {
    const double rate = k1 + x * (2 * k2 + x * (3 + x * 4 * per));
    double next = x - value(x) / rate;
    if (!(rate > 0 && next < most)) next = i == 0 ? most : x;
    const double step = std::abs(x - next);
    x = next;
    if (!(step > kSettled * x)) break;
  }
  const double held_half = (limit + (square(x) + (high ? c_ : -c_)) / limit) / 2;
  return time_over(held_half, x);
}

// --- all durations

/// The time of the smallest slope. The slope falls and then rises: it falls only while the acceleration keeps
/// its sign, until the ratio of its ends is 2 - sqrt(3) (or a quarter, if one of them is a limit).
double UpperReach::steepest_descent(double from, double to) const noexcept {
  const Shape first = shape(from);
  if (first.high >= 0 && first.low <= 0) return from;
  double best = from, least = slope(from);
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

/// The time between `from` and `to` at which the slope falls through zero.
double UpperReach::top_of_hill(double from, double to) const noexcept {
  double high = slope(from), low = slope(to), t = from;
  for (int i = 0; i < 100 && to - from > 1e-14 * to; ++i) {
    t = from + high * (to - from) / (high - low);
    if (i % 3 == 2 || !(t > from && t < to)) t = from + (to - from) / 2;
    const double s = slope(t);
    if (s == 0) return t;
    s > 0 ? (from = t, high = s) : (to = t, low = s);
  }
  return from;
}

/// A time between `from` and `to` at which reach() is below `distance`, or its minimum if there is none; the
/// slope rises through zero there.
double UpperReach::below(double distance, double from, double to) const noexcept {
  double low = slope(from), high = slope(to), t = from;
  for (int i = 0; i < 100 && to - from > 1e-10 * to; ++i) {
    t = from - low * (to - from) / (high - low);
    if (i % 3 == 2 || !(t > from && t < to)) t = from + (to - from) / 2;
    const Form here = form(t);
    if (reach_of(here) < distance) return t;
    const double s = slope_of(here);
    if (std::signbit(s) == std::signbit(low))
      from = t, low = s;
    else
      to = t, high = s;
  }
  return t;
}

/// Newton's method in a bracket in which reach() passes the distance once.
double UpperReach::time_between(double distance, double from, double to, double at_from,
                                double at_to) const noexcept {
  const bool rising = at_to > at_from;
  double t = from + (to - from) * std::cbrt(std::clamp((distance - at_from) / (at_to - at_from), 0.0, 1.0));
  for (int i = 0; i < 100; ++i) {
    const Form f = form(t);
    const double error = reach_of(f) - distance;
    if (error == 0) return t;
    ((error > 0) == rising ? to : from) = t;
    const double next = t - error / slope_of(f);
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
  if (least >= 0 && distance <= before) return 0;         // it rises from here
  if (steepest > from && least < 0 && slope(from) > 0) {  // first a hill
    mark[marks++] = top_of_hill(from, steepest);
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
