#include "polyarm/timing/grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace polyarm::timing {
namespace {

/// Length of a row's components of `derivative` at a place, relative to its limit: (high + low)/2 for joints.
enum class Order { first, second, third };

double length_of(const PathRows& rows, std::size_t row, std::size_t place, Order order) {
  const auto value = [&](std::size_t c) {
    return order == Order::first    ? rows.first(c)[place]
           : order == Order::second ? rows.second(c)[place]
                                    : rows.third(c)[place];
  };
  if (row < rows.joints()) return std::abs(value(row));
  double sum = 0;
  const std::size_t n = row - rows.joints();
  for (std::size_t c = rows.first_component(n); c < rows.first_component(n + 1); ++c)
    sum += value(c) * value(c);
  return std::sqrt(sum);
}

struct RowLimits {
  double velocity, acceleration, jerk;
};
/// The limits of a row; the lower limit if the two sides differ.
RowLimits limits_of(const PathRows& rows, std::size_t row) {
  if (row >= rows.joints()) {
    const NormLimit& n = rows.norm(row - rows.joints());
    return {n.max_velocity, n.max_acceleration, n.max_jerk};
  }
  const trajectory::MotionLimits& l = rows.limits(row);
  return {std::min(l.max_velocity, -l.min_velocity), std::min(l.max_acceleration, -l.min_acceleration),
          l.max_jerk};
}

/// The highest s̈ (downwards: its magnitude) at ṡ² = b.
double acceleration_left(const PathRows& rows, std::size_t place, double b) {
  double most = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < rows.rows(); ++r) {
    const double first = length_of(rows, r, place, Order::first);
    if (first <= 0) continue;
    const double limit = limits_of(rows, r).acceleration;
    most =
        std::min(most, std::max(limit - length_of(rows, r, place, Order::second) * b, 0.05 * limit) / first);
  }
  return most;
}

/// The ratio of s̈ to s⃛ if one row alone bounded both: the duration of a ramp of acceleration; and the
/// highest s⃛.
struct Ramp {
  double time, jerk;
};
Ramp ramp_at(const PathRows& rows, std::size_t place) {
  double acceleration = std::numeric_limits<double>::infinity(), jerk = acceleration;
  for (std::size_t r = 0; r < rows.rows(); ++r) {
    const double first = length_of(rows, r, place, Order::first);
    if (first <= 0) continue;
    const RowLimits l = limits_of(rows, r);
    acceleration = std::min(acceleration, l.acceleration / first), jerk = std::min(jerk, l.jerk / first);
  }
  return {acceleration / jerk, jerk};
}

/// The rate of change of the tangent, per s: the interval must resolve it.
double turning(const PathRows& rows, std::size_t place) {
  double one = 0, two = 0, three = 0;
  for (std::size_t r = 0; r < rows.rows(); ++r) {
    const double j = limits_of(rows, r).jerk;
    if (!std::isfinite(j)) continue;
    one = std::max(one, length_of(rows, r, place, Order::first) / j);
    two = std::max(two, length_of(rows, r, place, Order::second) / j);
    three = std::max(three, length_of(rows, r, place, Order::third) / j);
  }
  return one > 0 ? std::max(two / one, std::sqrt(three / one)) : 0;
}

constexpr std::size_t kCells = 8;  // per stretch between breaks, for the first evaluation of the path
constexpr std::size_t kFewestCells = 128;

/// From rest at constant jerk, k equal steps of time have intervals proportional to 1, 4, 9 …: k³/3 + k²/2 +
/// k/6 in total.
double rest_way(double k) {
  return k * (k + 0.5) * (k + 1) / 3;
}
/// The interval after the way `s`, both relative to the first interval.
double rest_spacing(double s) {
  double k = std::cbrt(3 * s);
  for (int i = 0; i < 3; ++i) k -= (rest_way(k) - s) / (k * k + k + 1.0 / 6);
  return k * k + k + 1.0 / 6;
}

std::vector<double> cells(const PathRows& rows, double first_step, bool rests_at_start, bool rests_at_end) {
  const std::span<const double> breaks = rows.path().breaks();
  const double length = rows.path().length();
  std::vector<double> s{0};
  for (std::size_t i = 0; i <= breaks.size(); ++i) {
    const double end = i < breaks.size() ? breaks[i] : length, begin = s.back();
    if (!(end - begin > 1e-12 * length) || end > length) continue;
    const auto share = std::size_t(double(kFewestCells) * (end - begin) / length) + kCells;
    for (std::size_t k = 1; k <= share; ++k)
      s.push_back(k == share ? end : begin + (end - begin) * double(k) / double(share));
  }
  const double step = s[1], last_step = s.back() - s[s.size() - 2];
  for (double k = 0.25; rests_at_start && rest_way(k) * first_step < step; k += 0.25)
    s.push_back(rest_way(k) * first_step);
  for (double k = 0.25; rests_at_end && rest_way(k) * first_step < last_step; k += 0.25)
    s.push_back(length - rest_way(k) * first_step);
  std::sort(s.begin(), s.end());
  s.erase(std::unique(s.begin(), s.end()), s.end());
  return s;
}

/// Halves cells until neighbours differ by at most a factor of two.
std::vector<double> graded(std::vector<double> s) {
  for (bool again = true; again;) {
    again = false;
    std::vector<double> out{s.front()};
    for (std::size_t i = 1; i < s.size(); ++i) {
      const double own = s[i] - s[i - 1];
      const double before = i > 1 ? s[i - 1] - s[i - 2] : own,
                   behind = i + 1 < s.size() ? s[i + 1] - s[i] : own;
      if (own > 2.01 * std::min(before, behind)) out.push_back(s[i - 1] + own / 2), again = true;
      out.push_back(s[i]);
    }
    s = std::move(out);
  }
  return s;
}

}  // namespace

double velocity_ceiling(const PathRows& rows, std::size_t place) {
  const double length = rows.path().length();
  double b = 1e12 * length * length;  // the whole path in a microsecond
  for (std::size_t r = 0; r < rows.rows(); ++r) {
    double limit = limits_of(rows, r).velocity;
    if (r < rows.joints())
      limit = rows.first(r)[place] > 0 ? rows.limits(r).max_velocity : -rows.limits(r).min_velocity;
    const double v = limit / length_of(rows, r, place, Order::first);
    if (v * v < b) b = v * v;
  }
  return b;
}

double speed_ceiling(const PathRows& rows, std::size_t place) {
  double b = velocity_ceiling(rows, place);
  for (std::size_t r = 0; r < rows.rows(); ++r) {
    const RowLimits l = limits_of(rows, r);
    const double a = l.acceleration / length_of(rows, r, place, Order::second);
    const double j = std::cbrt(l.jerk / length_of(rows, r, place, Order::third));
    for (const double most : {a, j * j})
      if (most < b) b = most;
  }
  return b;
}

void limit_accelerations(const PathRows& rows, std::vector<double>& b) {
  const std::size_t n = b.size();
  const double length = rows.s(n - 1);
  // From rest at constant jerk u: ṡ = (u/2)^(1/3) (3 s)^(2/3).
  const auto from_rest = [&](std::size_t end, std::size_t i, double way) {
    const double u = 0.5 * ramp_at(rows, end).jerk, speed = std::cbrt(u / 2 * 9 * way * way);
    if (std::isfinite(u)) b[i] = std::min(b[i], speed * speed);
  };
  for (std::size_t i = 1; i < n; ++i) {
    if (b[0] <= 0) from_rest(0, i, rows.s(i));
    const double most = b[i - 1] + 2 * (rows.s(i) - rows.s(i - 1)) * acceleration_left(rows, i, b[i - 1]);
    b[i] = std::min(b[i], most);
  }
  for (std::size_t i = n - 1; i-- > 0;) {
    if (b[n - 1] <= 0 && i > 0) from_rest(n - 1, i, length - rows.s(i));
    const double most = b[i + 1] + 2 * (rows.s(i + 1) - rows.s(i)) * acceleration_left(rows, i, b[i + 1]);
    if (i > 0) b[i] = std::min(b[i], most);
  }
}

namespace {

constexpr double kSlow = 1.6;  // relative to the time in which jerk adds half of the speed

/// The largest allowed interval of the grid at every place of `rows`.
std::vector<double> spacings(const PathRows& rows, const std::vector<double>& b, double ramp_step,
                             const GridRequest& request) {
  const std::size_t n = rows.places();
  double duration = 0;
  for (std::size_t i = 1; i < n; ++i)
    duration += 2 * (rows.s(i) - rows.s(i - 1)) / (std::sqrt(b[i - 1]) + std::sqrt(b[i]));
  const double stretches = double(std::max<std::size_t>(rows.path().breaks().size(), 2) - 1);
  const double shortest = duration / (30 + 3.75 * stretches);
  std::vector<double> out(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double turn = turning(rows, i);
    const Ramp ramp = ramp_at(rows, i);
    double time = std::max(0.67 * ramp.time, shortest);
    if (request.slow_places) time = std::min(time, kSlow * std::sqrt(std::sqrt(b[i]) / ramp.jerk));
    const double length = rows.s(n - 1), near = 6 * ramp_step;  // near rest only the law below applies
    const bool rests = (b.front() <= 0 && rows.s(i) < near) || (b.back() <= 0 && length - rows.s(i) < near);
    out[i] = rests ? length / 18 : std::min(length / 18, std::sqrt(b[i]) * time);
    if (turn > 0) out[i] = std::min(out[i], 0.47 / turn);
    out[i] = std::max(out[i], 1e-7 * rows.s(n - 1));
  }
  for (std::size_t i = 1; i < n; ++i)
    out[i] = std::min(out[i], out[i - 1] + 0.4 * (rows.s(i) - rows.s(i - 1)));
  for (std::size_t i = n - 1; i-- > 0;)
    out[i] = std::min(out[i], out[i + 1] + 0.4 * (rows.s(i + 1) - rows.s(i)));
  for (double& x : out) x /= request.fineness;
  for (std::size_t i = 0; i < n; ++i) {
    if (b.front() <= 0) out[i] = std::min(out[i], ramp_step * rest_spacing(rows.s(i) / ramp_step));
    if (b.back() <= 0)
      out[i] = std::min(out[i], ramp_step * rest_spacing((rows.s(n - 1) - rows.s(i)) / ramp_step));
  }
  return out;
}

/// For a start from rest: the length of the first interval that resolves its ramp.
double first_step(const PathRows& rows, std::size_t end) {
  const Ramp ramp = ramp_at(rows, end);
  const double length = rows.path().length();
  if (!std::isfinite(ramp.jerk)) return 1e-3 * length;
  double time = std::cbrt(length / ramp.jerk);
  if (ramp.time > 0 && ramp.time < time) time = ramp.time;
  const double step = time / 4;
  return std::clamp(0.5 * ramp.jerk * step * step * step, 1e-7 * length, 1e-2 * length);
}

/// A cell of the grid with interval lengths `from` and `to` at its ends. The length changes linearly in
/// between.
struct Cell {
  double width, from, to;

  double slope() const { return (to - from) / width; }
  bool even() const { return std::abs(to - from) < 1e-6 * from; }
  /// The number of intervals in the cell, and the way after `n` of them.
  double intervals() const { return even() ? width / from : std::log(to / from) / slope(); }
  double way(double n) const {
    return std::min(width, even() ? n * from : from * std::expm1(n * slope()) / slope());
  }
};

std::vector<double> nodes(const PathRows& rows, const std::vector<double>& spacing) {
  const std::span<const double> breaks = rows.path().breaks();
  std::vector<double> out{0};
  std::size_t begin = 0, next_break = 0;
  const std::size_t n = rows.places();
  while (begin + 1 < n) {
    while (next_break < breaks.size() && breaks[next_break] <= rows.s(begin)) ++next_break;
    const double end_s = next_break < breaks.size() ? breaks[next_break] : rows.s(n - 1);
    std::size_t end = begin + 1;
    while (end + 1 < n && rows.s(end) < end_s) ++end;
    std::vector<double> sum{0};
    for (std::size_t i = begin + 1; i <= end; ++i)
      sum.push_back(sum.back() + Cell{rows.s(i) - rows.s(i - 1), spacing[i - 1], spacing[i]}.intervals());
    const auto count = std::size_t(std::clamp(std::ceil(sum.back()), 6.0, 2e4));
    for (std::size_t k = 1, i = 1; k <= count; ++k) {
      const double want = sum.back() * double(k) / double(count);
      while (i + 1 < sum.size() && sum[i] < want) ++i;
      const std::size_t to = begin + i;
      const Cell cell{rows.s(to) - rows.s(to - 1), spacing[to - 1], spacing[to]};
      out.push_back(k == count ? rows.s(end) : rows.s(to - 1) + cell.way(want - sum[i - 1]));
    }
    begin = end;
  }
  return out;
}

}  // namespace

namespace {

constexpr double kRampRounding = 1.5;  // relative to the duration of a ramp of acceleration

/// Smooths b over s where the acceleration would jump: takes the minimum, then the mean speed over the
/// duration of a ramp of acceleration. The ends stay.
void round_corners(const PathRows& rows, std::vector<double>& b) {
  const std::size_t n = b.size();
  std::vector<double> time(n), half(n), least(n), area(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0)
      time[i] = time[i - 1] + 2 * (rows.s(i) - rows.s(i - 1)) / (std::sqrt(b[i - 1]) + std::sqrt(b[i]));
    const double ramp = ramp_at(rows, i).time;
    half[i] = std::isfinite(ramp) ? kRampRounding * ramp / 2 : 0;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double width = std::min({half[i], 0.25 * time[i], 0.25 * (time[n - 1] - time[i])});
    least[i] = b[i], half[i] = width;
    for (std::size_t k = i; k-- > 0 && time[k] > time[i] - width;) least[i] = std::min(least[i], b[k]);
    for (std::size_t k = i + 1; k < n && time[k] < time[i] + width; ++k) least[i] = std::min(least[i], b[k]);
  }
  for (std::size_t i = 0; i < n; ++i) least[i] = std::sqrt(least[i]);
  for (std::size_t i = 1; i < n; ++i)
    area[i] = area[i - 1] + (time[i] - time[i - 1]) * (least[i] + least[i - 1]) / 2;
  const auto area_to = [&](double t, std::size_t k) {  // t within (time[k], time[k + 1])
    const double x = t - time[k], whole = time[k + 1] - time[k];
    return area[k] + x * (least[k] + (least[k + 1] - least[k]) * x / whole / 2);
  };
  std::size_t from = 0, to = 0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (!(half[i] > 0)) continue;
    const double begin = time[i] - half[i], end = time[i] + half[i];
    while (from > 0 && time[from] > begin) --from;
    while (time[from + 1] < begin) ++from;
    while (to > 0 && time[to] > end) --to;
    while (to + 2 < n && time[to + 1] < end) ++to;
    const double mean = (area_to(end, to) - area_to(begin, from)) / (end - begin);
    b[i] = std::min(b[i], mean * mean);
  }
}

}  // namespace

std::vector<double> slow_places(PathRows& rows) {
  constexpr double kMuch = 8;  // ratio of ṡ² that makes a place slow
  constexpr std::array kParts{0.1, 0.37, 0.63, 0.9};
  std::vector<double> ends{0}, places, lowest;
  for (const double s : rows.path().breaks())
    if (s > ends.back() && s < rows.path().length()) ends.push_back(s);
  ends.push_back(rows.path().length());
  for (std::size_t i = 1; i < ends.size(); ++i)
    for (const double part : kParts) places.push_back(ends[i - 1] + part * (ends[i] - ends[i - 1]));
  rows.look(places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double b = speed_ceiling(rows, i);
    if (i % kParts.size() == 0)
      lowest.push_back(b);
    else
      lowest.back() = std::min(lowest.back(), b);
  }
  std::vector<double> out;
  double highest = lowest.front();
  std::size_t valley = 0;  // since the last descent; 0: none yet
  for (std::size_t i = 1; i < lowest.size(); ++i) {
    if (valley == 0) {
      highest = std::max(highest, lowest[i]);
      if (kMuch * lowest[i] < highest) valley = i;
    } else if (lowest[i] < lowest[valley]) {
      valley = i;
    } else if (lowest[i] > kMuch * lowest[valley]) {
      out.push_back((ends[valley] + ends[valley + 1]) / 2);
      highest = lowest[i], valley = 0;
    }
  }
  return out;
}

TimingGrid timing_grid(PathRows& rows, const GridRequest& request) {
  const double length = rows.path().length();
  rows.look({0, length});
  const double step = std::min(first_step(rows, 0), first_step(rows, 1));
  const bool rests[2] = {request.start_speed <= 0, request.end_speed <= 0};
  rows.look(graded(cells(rows, step, rests[0], rests[1])));
  const auto guess = [&](bool rounded) {
    std::vector<double> b(rows.places());
    for (std::size_t i = 0; i < b.size(); ++i) b[i] = speed_ceiling(rows, i);
    b.front() = request.start_speed * request.start_speed, b.back() = request.end_speed * request.end_speed;
    limit_accelerations(rows, b);
    if (rounded) round_corners(rows, b);
    return b;
  };
  const std::vector<double> spacing =
      spacings(rows, guess(request.rounded && !request.slow_places), step, request);
  rows.look(nodes(rows, spacing));
  TimingGrid out{std::vector<double>(rows.places()), guess(request.rounded)};
  for (std::size_t i = 0; i < out.s.size(); ++i) out.s[i] = rows.s(i);
  return out;
}

}  // namespace polyarm::timing
