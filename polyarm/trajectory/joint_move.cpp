#include "polyarm/trajectory/joint_move.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "polyarm/base/error.hpp"

namespace polyarm::trajectory {

namespace {

constexpr double kLastInstant = 1e-6;     // s, exactly at the goal
constexpr double kNoMove = 1e-12;         // rad or m
constexpr double kShortestPhase = 1e-12;  // s

void check_size(std::size_t size, std::size_t joints, const char* what) {
  if (size != joints)
    throw Error("bad-move", std::string("a move of ") + std::to_string(joints) + " joints got " +
                                std::to_string(size) + " " + what);
}

void check_values(std::span<const double> values, std::size_t joints, const char* what) {
  check_size(values.size(), joints, what);
  for (std::size_t i = 0; i < joints; ++i)
    if (!std::isfinite(values[i]))
      throw Error("bad-move",
                  "value " + std::to_string(i + 1) + " of the " + what + " is not a finite number");
}

void check_positive(double value, const std::string& what) {
  if (!(value > 0) || !std::isfinite(value))
    throw Error("bad-limit", what + " is " + std::to_string(value) + "; it must be above zero and finite");
}

void check_limits(std::span<const JointMotionLimits> limits, std::size_t joints) {
  check_size(limits.size(), joints, "limits");
  for (std::size_t i = 0; i < joints; ++i) {
    const std::string joint = " limit of joint " + std::to_string(i + 1);
    check_positive(limits[i].velocity, "the velocity" + joint);
    check_positive(limits[i].acceleration, "the acceleration" + joint);
    check_positive(limits[i].jerk, "the jerk" + joint);
  }
}

/// A profile of s from 0 to 1, rest to rest: jerk up, constant acceleration, jerk down, cruise, and the
/// mirror.
struct Profile {
  double jerk = 0;               // 1/s³
  double jerk_time = 0;          // s, of each jerk phase
  double acceleration_time = 0;  // s, of each phase of constant acceleration
  double cruise_time = 0;        // s
  double total() const { return 4 * jerk_time + 2 * acceleration_time + cruise_time; }
  void stretch(double factor) {
    jerk /= factor * factor * factor;
    for (double* time : {&jerk_time, &acceleration_time, &cruise_time}) *time *= factor;
  }
};

/// Limits of s', s'', s'''.
struct PathLimits {
  double velocity = std::numeric_limits<double>::infinity();
  double acceleration = velocity, jerk = velocity;
};

/// The fastest profile within the limits.
Profile fastest_profile(const PathLimits& limit) {
  const double v = limit.velocity, a = limit.acceleration, j = limit.jerk;
  Profile p;
  p.jerk = j;
  if (v * j < a * a) {  // the acceleration limit is never reached before full speed
    p.jerk_time = std::sqrt(v / j);
  } else {
    p.jerk_time = a / j;
    p.acceleration_time = v / a - p.jerk_time;
  }
  const double ramp = 2 * p.jerk_time + p.acceleration_time;
  if (v * ramp <= 1) {
    p.cruise_time = 1 / v - ramp;
    return p;
  }
  // Full speed is never reached: half of the distance is acceleration.
  if (2 * a * a * a >= j * j) {  // nor is full acceleration: 2 j T³ = 1
    p.jerk_time = std::cbrt(1 / (2 * j));
    p.acceleration_time = 0;
  } else {  // a (2 Tj + Ta)(Tj + Ta) = 1 with Tj = a / j
    p.jerk_time = a / j;
    p.acceleration_time = std::max(0.0, (std::sqrt(p.jerk_time * p.jerk_time + 4 / a) - 3 * p.jerk_time) / 2);
  }
  return p;
}

/// One straight line in joint space.
struct MoveLine {
  std::span<const double> from, to;

  double distance(std::size_t i) const { return to[i] - from[i]; }
  bool no_move() const {
    for (std::size_t i = 0; i < from.size(); ++i)
      if (std::abs(distance(i)) >= kNoMove) return false;
    return true;
  }
  Profile fastest(std::span<const JointMotionLimits> limits, double speed, double effort) const {
    PathLimits path;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const double length = std::abs(distance(i));
      if (length == 0) continue;
      path.velocity = std::min(path.velocity, speed * limits[i].velocity / length);
      path.acceleration = std::min(path.acceleration, effort * limits[i].acceleration / length);
      path.jerk = std::min(path.jerk, effort * limits[i].jerk / length);
    }
    return fastest_profile(path);
  }
};

void append_rest(Trajectory& out, std::span<const double> at, double duration) {
  std::vector<double> c(at.size() * Trajectory::kCoefficients, 0.0);
  for (std::size_t i = 0; i < at.size(); ++i) c[i * Trajectory::kCoefficients] = at[i];
  out.append(duration, c);
}

void append_phase(Trajectory& out, const MoveLine& line, double duration, const std::array<double, 4>& s) {
  std::vector<double> c(line.from.size() * Trajectory::kCoefficients, 0.0);
  for (std::size_t i = 0; i < line.from.size(); ++i) {
    for (std::size_t k = 0; k < s.size(); ++k) c[i * Trajectory::kCoefficients + k] = line.distance(i) * s[k];
    c[i * Trajectory::kCoefficients] += line.from[i];
  }
  out.append(duration, c);
}

void append_move(Trajectory& out, const MoveLine& line, const Profile& p) {
  const double tj = p.jerk_time, ta = p.acceleration_time, tv = p.cruise_time;
  const std::array<std::array<double, 2>, 7> phases = {
      {{tj, p.jerk}, {ta, 0}, {tj, -p.jerk}, {tv, 0}, {tj, -p.jerk}, {ta, 0}, {tj, p.jerk}}};
  double s = 0, v = 0, a = 0;
  for (const auto& [t, j] : phases) {
    if (t < kShortestPhase) continue;
    append_phase(out, line, t, {s, v, a / 2, j / 6});
    s += t * (v + t * (a / 2 + t * j / 6));
    v += t * (a + t * j / 2);
    a += t * j;
  }
  // Rounding of the sums must not miss the goal.
  append_rest(out, line.to, kLastInstant);
}

void check_options(const JointMoveOptions& options) {
  check_positive(options.speed_scale, "the speed scale");
  check_positive(options.acceleration_scale, "the acceleration scale");
}

}  // namespace

Trajectory plan_joint_move(std::span<const double> from, std::span<const double> to,
                           std::span<const JointMotionLimits> limits, const JointMoveOptions& options) {
  const std::vector<std::vector<double>> waypoints{std::vector<double>(to.begin(), to.end())};
  return plan_joint_moves(from, waypoints, limits, options);
}

Trajectory plan_joint_moves(std::span<const double> from, std::span<const std::vector<double>> waypoints,
                            std::span<const JointMotionLimits> limits, const JointMoveOptions& options) {
  check_values(from, from.size(), "start values");
  check_limits(limits, from.size());
  check_options(options);
  double fastest = 0;
  std::vector<MoveLine> lines;
  for (const std::vector<double>& to : waypoints) {
    check_values(to, from.size(), "target values");
    const MoveLine line{from, to};
    from = to;
    if (line.no_move()) continue;
    lines.push_back(line);
    fastest += line.fastest(limits, options.speed_scale, options.acceleration_scale).total();
  }
  Trajectory out(from.size());
  for (const MoveLine& line : lines) {
    Profile profile = line.fastest(limits, options.speed_scale, options.acceleration_scale);
    if (std::isfinite(options.duration)) profile.stretch(std::max(1.0, options.duration / fastest));
    append_move(out, line, profile);
  }
  if (out.empty()) append_rest(out, from, 1e-3);
  return out;
}

double fastest_duration(std::span<const double> from, std::span<const double> to,
                        std::span<const JointMotionLimits> limits, double speed_scale,
                        double acceleration_scale) {
  check_values(from, from.size(), "start values");
  check_values(to, from.size(), "target values");
  check_limits(limits, from.size());
  check_options({speed_scale, acceleration_scale, 0});
  const MoveLine line{from, to};
  return line.no_move() ? 0.0 : line.fastest(limits, speed_scale, acceleration_scale).total();
}

double thesis_duration(std::span<const double> from, std::span<const double> to, double scale) {
  check_values(from, from.size(), "start values");
  check_values(to, from.size(), "target values");
  const double squares = std::transform_reduce(from.begin(), from.end(), to.begin(), 0.0, std::plus<>(),
                                               [](double a, double b) { return (b - a) * (b - a); });
  return scale * std::sqrt(squares);
}

}  // namespace polyarm::trajectory
