#include <algorithm>
#include <cmath>

#include "polyarm/planning/planner.hpp"

namespace polyarm::planning {

namespace {

constexpr std::size_t kParts = 16;  // of a corner that are proven side by side
constexpr int kHalvings = 5;

double distance(const JointState& a, const JointState& b) {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j) sum += (b[j] - a[j]) * (b[j] - a[j]);
  return std::sqrt(sum);
}

JointState direction(const JointState& a, const JointState& b) {
  const double length = distance(a, b);
  JointState out(a.size());
  for (std::size_t j = 0; j < a.size(); ++j) out[j] = length > 0 ? (b[j] - a[j]) / length : 0;
  return out;
}

/// The curve of paths::joint_lines: its derivative turns from u to v as u + (v - u) (3 t² - 2 t³), so each
/// joint's speed is monotonous, and between two places the larger of both speeds bounds it.
bool corner_is_free(collision::Probe& probe, const JointState& corner, const JointState& u,
                    const JointState& v, double radius, bool exact) {
  const std::size_t n = corner.size();
  std::vector<double> states(kParts * n), sizes(kParts * n);
  const auto turn = [](double t) { return t * t * (3 - 2 * t); };
  for (std::size_t i = 0; i < kParts; ++i) {
    const double half = 0.5 / kParts, t = (double(i) + 0.5) / kParts;
    for (std::size_t j = 0; j < n; ++j) {
      const double bend = v[j] - u[j];
      states[i * n + j] =
          corner[j] - radius * u[j] + 2 * radius * (u[j] * t + bend * t * t * t * (1 - t / 2));
      sizes[i * n + j] =
          2 * radius * half *
          std::max(std::abs(u[j] + bend * turn(t - half)), std::abs(u[j] + bend * turn(t + half)));
    }
  }
  return probe.proven_around(states, sizes, exact);
}

}  // namespace

std::vector<double> corner_radii(collision::Probe& probe, std::span<const JointState> waypoints, bool exact,
                                 double most) {
  std::vector<double> out(waypoints.size(), 0);
  for (std::size_t i = 1; i + 1 < waypoints.size(); ++i) {
    const JointState u = direction(waypoints[i - 1], waypoints[i]),
                     v = direction(waypoints[i], waypoints[i + 1]);
    double radius = std::min(
        {most, distance(waypoints[i - 1], waypoints[i]) / 2, distance(waypoints[i], waypoints[i + 1]) / 2});
    for (int k = 0; k < kHalvings && radius > 0; ++k, radius /= 2)
      if (corner_is_free(probe, waypoints[i], u, v, radius, exact)) {
        out[i] = radius;
        break;
      }
  }
  return out;
}

}  // namespace polyarm::planning
