#include "polyarm/trajectory/splines.hpp"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <numbers>

#include "polyarm/base/text.hpp"

namespace polyarm::trajectory {

namespace {

constexpr std::size_t kCount = Trajectory::kCoefficients;
constexpr double kShortest = 1e-9;  // s between two points: below it rates are not finite
constexpr double kLongest = 1e9;    // s: beyond it a time does not fit into nanoseconds
constexpr double kHold = 1e-3;  // s, for a trajectory whose only point is at time 0

/// Checks one point and collects its faults under the point's name.
struct PointCheck {
  Problems& problems;
  std::string name;
  std::size_t joints;

  void field(const std::vector<double>& values, const char* what) const {
    if (!values.empty() && values.size() != joints)
      problems.error("wrong-size", {},
                     name + " has " + std::to_string(values.size()) + " " + what + " for " +
                         std::to_string(joints) + " joints");
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        problems.error(
            "bad-number", {},
            "value " + std::to_string(i + 1) + " of the " + what + " of " + name + " is not a finite number");
  }
  void fields(const TrajectoryPoint& point) const {
    if (point.positions.empty() && joints > 0)
      problems.error("no-positions", {}, name + " has no positions",
                     "give positions; points of velocities or accelerations alone are not integrated");
    field(point.positions, "positions");
    field(point.velocities, "velocities");
    field(point.accelerations, "accelerations");
    field(point.effort, "effort values");
  }
};

std::string name_of(std::size_t i) {
  return "point " + std::to_string(i + 1);
}

void check_times(std::span<const TrajectoryPoint> points, Problems& problems) {
  double last = -1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = points[i].time_from_start;
    if (!std::isfinite(t) || t < 0 || t > kLongest || (t > 0 && t < kShortest))
      problems.error("bad-time", {}, name_of(i) + " is at " + format_number(t) + " s",
                     "times count from the start, in seconds");
    else if (i > 0 && !(t - last >= kShortest))
      problems.error("bad-time", {},
                     name_of(i) + " is at " + std::to_string(t) +
                         " s, not later than the point before it at " + std::to_string(last) + " s",
                     "times must increase strictly");
    last = t;
  }
}

void check_end(const TrajectoryPoint& end, const SplineOptions& options, Problems& problems) {
  if (options.allow_nonzero_velocity_at_end) return;
  for (std::size_t i = 0; i < end.velocities.size(); ++i)
    if (std::abs(end.velocities[i]) > FLT_EPSILON)
      problems.error("moves-at-end", {},
                     "the last point has velocity " + format_number(end.velocities[i]) + " for joint " +
                         std::to_string(i + 1),
                     "end at rest, or allow a velocity at the end");
}

Problems findings(const TrajectoryPoint& start, std::span<const TrajectoryPoint> points,
                  const SplineOptions& options) {
  Problems problems;
  const std::size_t joints = start.positions.size();
  PointCheck{problems, "the start state", joints}.fields(start);
  if (points.empty()) problems.error("no-points", {}, "the trajectory has no points", "send at least one");
  for (std::size_t i = 0; i < points.size(); ++i) PointCheck{problems, name_of(i), joints}.fields(points[i]);
  check_times(points, problems);
  if (!points.empty()) check_end(points.back(), options, problems);
  return problems;
}

int degree_between(const TrajectoryPoint& a, const TrajectoryPoint& b) {
  if (a.velocities.empty() || b.velocities.empty()) return 1;
  return a.accelerations.empty() || b.accelerations.empty() ? 3 : 5;
}

SplineEnd end_of(const TrajectoryPoint& point, std::size_t joint) {
  const auto value = [&](const std::vector<double>& list) { return list.empty() ? 0.0 : list[joint]; };
  return {point.positions[joint], value(point.velocities), value(point.accelerations)};
}

void append_spline(Trajectory& out, const TrajectoryPoint& from, const TrajectoryPoint& to, double duration) {
  std::vector<double> coefficients;
  const int degree = degree_between(from, to);
  for (std::size_t j = 0; j < out.joints(); ++j) {
    const auto c = spline_piece(degree, end_of(from, j), end_of(to, j), duration);
    coefficients.insert(coefficients.end(), c.begin(), c.end());
  }
  out.append(duration, coefficients);
}

void append_constant(Trajectory& out, const TrajectoryPoint& at, double duration) {
  std::vector<double> coefficients(out.joints() * kCount, 0.0);
  for (std::size_t j = 0; j < out.joints(); ++j) coefficients[j * kCount] = at.positions[j];
  out.append(duration, coefficients);
}

/// Removes whole turns between the start and the first point, on the side that the options select.
void take_shorter_way(TrajectoryPoint& start, std::vector<TrajectoryPoint>& points,
                      const std::vector<bool>& continuous, Wraparound side) {
  constexpr double kTurn = 2 * std::numbers::pi;
  for (std::size_t j = 0; j < std::min(continuous.size(), start.positions.size()); ++j) {
    if (!continuous[j]) continue;
    const double turns = kTurn * std::round((points.front().positions[j] - start.positions[j]) / kTurn);
    if (side == Wraparound::start)
      start.positions[j] += turns;
    else
      for (TrajectoryPoint& point : points) point.positions[j] -= turns;
  }
}

}  // namespace

std::array<double, kCount> spline_piece(int degree, const SplineEnd& from, const SplineEnd& to,
                                        double T) noexcept {
  const double d = to.position - from.position;
  if (degree == 1) return {from.position, d / T, 0, 0, 0, 0};
  const double v0 = from.velocity, v1 = to.velocity;
  if (degree == 3)
    return {from.position, v0, (3 * d / T - 2 * v0 - v1) / T, (v0 + v1 - 2 * d / T) / (T * T), 0, 0};
  const double a0 = from.acceleration;
  // The part that the three upper powers must contribute.
  const double p = (d - v0 * T - a0 * T * T / 2) / (T * T * T);
  const double v = (v1 - v0 - a0 * T) / (T * T);
  const double a = (to.acceleration - a0) / T;
  return {from.position,
          v0,
          a0 / 2,
          10 * p - 4 * v + a / 2,
          (-15 * p + 7 * v - a) / T,
          (6 * p - 3 * v + a / 2) / (T * T)};
}

std::vector<Problem> check_points(const TrajectoryPoint& start, std::span<const TrajectoryPoint> points,
                                  const SplineOptions& options) {
  return findings(start, points, options).list();
}

Trajectory interpolate(const TrajectoryPoint& start, std::span<const TrajectoryPoint> points,
                       const std::vector<bool>& continuous, const SplineOptions& options) {
  findings(start, points, options).throw_if_errors();
  TrajectoryPoint from = start;
  std::vector<TrajectoryPoint> all(points.begin(), points.end());
  take_shorter_way(from, all, continuous, options.wraparound);
  from.time_from_start = 0;
  Trajectory out(from.positions.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double duration = all[i].time_from_start - from.time_from_start;
    if (duration > 0 && options.method == InterpolationMethod::splines)
      append_spline(out, from, all[i], duration);
    else if (duration > 0)
      append_constant(out, i == 0 ? from : all[i], duration);
    from = all[i];
  }
  // The last point has no interval after it.
  if (out.empty() || (options.method == InterpolationMethod::none && all.size() == 1))
    append_constant(out, from, kHold);
  return out;
}

}  // namespace polyarm::trajectory
