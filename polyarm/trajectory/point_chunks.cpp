#include "polyarm/trajectory/point_chunks.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::trajectory {

namespace {
/// Solves v[i-1] + 4 v[i] + v[i+1] = right[i] for the inner points, with v = 0 at both ends (Thomas'
/// algorithm).
std::vector<double> inner_velocities(const std::vector<double>& right) {
  const std::size_t n = right.size();
  std::vector<double> upper(n, 0.0), out(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = 4 - (i > 1 ? upper[i - 1] : 0);
    upper[i] = 1 / pivot;
    out[i] = (right[i] - (i > 1 ? out[i - 1] : 0)) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) out[i] -= upper[i] * (i + 1 < n - 1 ? out[i + 1] : 0);
  return out;
}

/// Integrates `field` over time; it is 0 at time 0.
std::vector<double> sum_up(const std::vector<double>& last_sum, const std::vector<double>& last,
                           const std::vector<double>& now, double dt) {
  std::vector<double> out(now.size());
  for (std::size_t k = 0; k < now.size(); ++k) out[k] = last_sum[k] + 0.5 * (last[k] + now[k]) * dt;
  return out;
}
}  // namespace

void upsample_positions(std::vector<TrajectoryPoint>& points, double frequency) {
  if (points.empty() || !(frequency > 0) || !std::isfinite(frequency)) return;
  const std::size_t n = points.size(), joints = points.front().positions.size();
  for (std::size_t i = 0; i < n; ++i) {
    const TrajectoryPoint& p = points[i];
    if (p.positions.size() != joints) return;
    if (i > 0 && !(p.time_from_start > points[i - 1].time_from_start)) return;  // the check refuses it later
  }
  for (std::size_t i = 0; i < n; ++i) {
    points[i].time_from_start = static_cast<double>(i + 1) / frequency;
    points[i].velocities.assign(joints, 0.0);
  }
  std::vector<double> right(n, 0.0);
  for (std::size_t k = 0; k < joints && n > 2; ++k) {
    for (std::size_t i = 1; i + 1 < n; ++i)
      right[i] = 3 * frequency * (points[i + 1].positions[k] - points[i - 1].positions[k]);
    const std::vector<double> v = inner_velocities(right);
    for (std::size_t i = 0; i < n; ++i) points[i].velocities[k] = v[i];
  }
}

void integrate_points(std::vector<TrajectoryPoint>& points, std::size_t joints) {
  std::vector<double> position(joints, 0.0), velocity(joints, 0.0), acceleration(joints, 0.0);
  double time = 0;
  for (TrajectoryPoint& point : points) {
    const double dt = point.time_from_start - time;
    if (point.velocities.empty()) {
      if (point.accelerations.size() != joints) return;
      point.velocities = sum_up(velocity, acceleration, point.accelerations, dt);
      acceleration = point.accelerations;
    }
    if (point.velocities.size() != joints) return;
    point.positions = sum_up(position, velocity, point.velocities, dt);
    position = point.positions;
    velocity = point.velocities;
    time = point.time_from_start;
  }
}

}  // namespace polyarm::trajectory
