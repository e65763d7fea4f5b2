#include "polyarm/trajectory/joint_move.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace polyarm::trajectory {

namespace {

/// A profile of s from 0 to 1, rest to rest: jerk up, constant acceleration, jerk down, cruise, and the
/// mirror.
struct Profile {
  double jerk = 0;               // 1/s³
  double jerk_time = 0;          // of each jerk phase
  double acceleration_time = 0;  // of the constant-acceleration phase
  double cruise_time = 0;
  double total() const { return 4 * jerk_time + 2 * acceleration_time + cruise_time; }
};

/// The fastest profile over the unit distance within |s'| <= v, |s''| <= a, |s'''| <= j.
Profile fastest_profile(double v, double a, double j) {
  Profile p;
  p.jerk = j;
  if (v * j < a * a) {  // the acceleration limit is never reached on the way to full speed
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
  // Full speed is never reached: half of the distance is spent speeding up.
  p.cruise_time = 0;
  if (2 * a * a * a >= j * j) {  // nor is full acceleration: 2 j T³ = 1
    p.jerk_time = std::cbrt(1 / (2 * j));
    p.acceleration_time = 0;
  } else {  // a (2 Tj + Ta)(Tj + Ta) = 1 with Tj = a / j
    p.jerk_time = a / j;
    const double tj = p.jerk_time;
    p.acceleration_time = std::max(0.0, (-3 * tj + std::sqrt(tj * tj + 4 / a)) / 2);
  }
  return p;
}

struct PathLimits {
  double velocity, acceleration, jerk;
};

PathLimits path_limits(std::span<const double> from, std::span<const double> to,
                       std::span<const JointMotionLimits> limits, double speed_scale) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  PathLimits out{kInfinity, kInfinity, kInfinity};
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double distance = std::abs(to[i] - from[i]);
    if (distance == 0) continue;
    out.velocity = std::min(out.velocity, speed_scale * limits[i].velocity / distance);
    out.acceleration = std::min(out.acceleration, limits[i].acceleration / distance);
    out.jerk = std::min(out.jerk, limits[i].jerk / distance);
  }
  return out;
}

/// Distances so small that their profile underflows are no moves.
bool same_place(const PathLimits& limits) {
  return !(limits.velocity < 1e12 && limits.jerk < 1e30);
}

Trajectory at_rest(std::span<const double> at) {
  Trajectory out(at.size());
  std::vector<double> c(at.size() * Trajectory::kCoefficients, 0.0);
  for (std::size_t i = 0; i < at.size(); ++i) c[i * Trajectory::kCoefficients] = at[i];
  out.append(1e-3, c);
  return out;
}

}  // namespace

Trajectory plan_joint_move(std::span<const double> from, std::span<const double> to,
                           std::span<const JointMotionLimits> limits, const JointMoveOptions& options) {
  assert(from.size() == to.size() && from.size() == limits.size());
  const PathLimits path = path_limits(from, to, limits, options.speed_scale);
  if (same_place(path)) return at_rest(to);
  Profile profile = fastest_profile(path.velocity, path.acceleration, path.jerk);
  const double stretch = std::max(1.0, options.duration / profile.total());
  const double jerk = profile.jerk / (stretch * stretch * stretch);
  const double tj = profile.jerk_time * stretch, ta = profile.acceleration_time * stretch,
               tv = profile.cruise_time * stretch;
  const std::array<std::array<double, 2>, 7> phases = {
      {{tj, jerk}, {ta, 0}, {tj, -jerk}, {tv, 0}, {tj, -jerk}, {ta, 0}, {tj, jerk}}};

  Trajectory out(from.size());
  std::vector<double> c(from.size() * Trajectory::kCoefficients);
  double s = 0, v = 0, a = 0;
  for (std::size_t k = 0; k < phases.size(); ++k) {
    const auto [t, j] = phases[k];
    if (t < 1e-12) continue;
    std::fill(c.begin(), c.end(), 0.0);
    for (std::size_t i = 0; i < from.size(); ++i) {
      const double d = to[i] - from[i];
      double* q = c.data() + i * Trajectory::kCoefficients;
      q[0] = from[i] + d * s;
      q[1] = d * v;
      q[2] = d * a / 2;
      q[3] = d * j / 6;
    }
    out.append(t, c);
    s += t * (v + t * (a / 2 + t * j / 6));
    v += t * (a + t * j / 2);
    a += t * j;
  }
  // Rounding of the sums must not leave the goal: a last instant that stands exactly on it.
  std::fill(c.begin(), c.end(), 0.0);
  for (std::size_t i = 0; i < from.size(); ++i) c[i * Trajectory::kCoefficients] = to[i];
  out.append(1e-6, c);
  return out;
}

double fastest_duration(std::span<const double> from, std::span<const double> to,
                        std::span<const JointMotionLimits> limits, double speed_scale) {
  const PathLimits path = path_limits(from, to, limits, speed_scale);
  return same_place(path) ? 0.0 : fastest_profile(path.velocity, path.acceleration, path.jerk).total();
}

double thesis_duration(std::span<const double> from, std::span<const double> to, double scale) {
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) sum += (to[i] - from[i]) * (to[i] - from[i]);
  return scale * std::sqrt(sum);
}

namespace {
/// Jerk phases (duration, jerk) that bring one joint from (v, a) to rest: to an acceleration peak and back to
/// zero.
std::vector<std::array<double, 2>> stop_phases(double v, double a, const JointMotionLimits& limit) {
  std::vector<std::array<double, 2>> out;
  const double j = limit.jerk;
  // Where the velocity ends if the acceleration is taken straight to zero decides which way to brake.
  const double free_end = v + a * std::abs(a) / (2 * j);
  const double direction = free_end > 0 ? -1 : 1;
  // Peak p (in `direction`): v + (areas of both ramps) = 0, so p² = j |v| + a²/2 when no plateau is needed.
  const double a_in = a * direction, v_in = -v * direction;  // v_in: velocity change still to be made
  double peak = std::sqrt(std::max(0.0, j * v_in + a_in * a_in / 2));
  double plateau = 0;
  if (peak > limit.acceleration) {
    peak = std::max(limit.acceleration, std::min(a_in, peak));
    const double made = (peak * peak - a_in * a_in) / (2 * j) + peak * peak / (2 * j);
    plateau = std::max(0.0, (v_in - made) / peak);
  }
  if (const double t = (peak - a_in) / j; t > 0) out.push_back({t, direction * j});
  if (plateau > 0) out.push_back({plateau, 0.0});
  if (const double t = peak / j; t > 0) out.push_back({t, -direction * j});
  return out;
}
}  // namespace

Trajectory plan_stop(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                     std::span<const JointMotionLimits> limits) {
  const std::size_t n = q.size();
  std::vector<std::vector<std::array<double, 2>>> phases(n);
  std::vector<double> cuts;
  for (std::size_t i = 0; i < n; ++i) {
    phases[i] = stop_phases(v[i], a[i], limits[i]);
    double t = 0;
    for (const auto& phase : phases[i]) cuts.push_back(t += phase[0]);
  }
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end(), [](double x, double y) { return y - x < 1e-9; }),
             cuts.end());
  if (cuts.empty() || cuts.front() < 1e-9) return at_rest(q);

  Trajectory out(n);
  std::vector<double> c(n * Trajectory::kCoefficients), p(q.begin(), q.end()), vel(v.begin(), v.end()),
      acc(a.begin(), a.end());
  double begin = 0;
  for (const double end : cuts) {
    const double t = end - begin, middle = (begin + end) / 2;
    std::fill(c.begin(), c.end(), 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      double jerk = 0, until = 0;
      bool stopped = true;
      for (const auto& phase : phases[i])
        if (middle < (until += phase[0])) {
          jerk = phase[1];
          stopped = false;
          break;
        }
      if (stopped) vel[i] = acc[i] = 0;
      double* k = c.data() + i * Trajectory::kCoefficients;
      k[0] = p[i];
      k[1] = vel[i];
      k[2] = acc[i] / 2;
      k[3] = jerk / 6;
      p[i] += t * (vel[i] + t * (acc[i] / 2 + t * jerk / 6));
      vel[i] += t * (acc[i] + t * jerk / 2);
      acc[i] += t * jerk;
    }
    out.append(t, c);
    begin = end;
  }
  return out;
}

}  // namespace polyarm::trajectory
