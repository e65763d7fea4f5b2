#include <algorithm>
#include <array>
#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/trajectory/joint_move.hpp"

namespace polyarm::trajectory {

namespace {

constexpr double kSameTime = 1e-9;  // s: nearer phase ends are the same

/// Constant jerk for some time.
struct Phase {
  double duration, jerk;
};

/// One joint during the stop: its present state and the remaining phases.
struct Braking {
  double position, velocity, acceleration;
  std::vector<Phase> phases;

  /// The phase at `time` since the start; null after the stop.
  const Phase* at(double time) const {
    for (const Phase& phase : phases)
      if ((time -= phase.duration) < 0) return &phase;
    return nullptr;
  }
};

/// The fastest phases from (v, a) to rest: the acceleration goes to a peak against the motion, stays there if
/// the peak is the limit, and returns to zero.
std::vector<Phase> stop_phases(double v, double a, const JointMotionLimits& limit) {
  const double j = limit.jerk;
  // The velocity after the acceleration goes directly to zero determines the braking direction.
  const double direction = v + a * std::abs(a) / (2 * j) > 0 ? -1 : 1;
  const double toward = a * direction,
               change = -v * direction;  // along `direction`: present value, what v must gain
  // The ramps gain (p² - a²) / 2j and p² / 2j, so without a plateau p² = j change + a² / 2.
  double peak = std::sqrt(std::max(0.0, j * change + toward * toward / 2));
  double plateau = 0;
  if (peak > limit.acceleration) {
    peak = limit.acceleration;
    const double ramp_in = (peak * peak - toward * toward) / (2 * j) * (toward > peak ? -1 : 1);
    plateau = std::max(0.0, (change - ramp_in - peak * peak / (2 * j)) / peak);
  }
  std::vector<Phase> out;
  if (const double t = std::abs(peak - toward) / j; t > 0)
    out.push_back({t, peak > toward ? direction * j : -direction * j});
  if (plateau > 0) out.push_back({plateau, 0.0});
  if (const double t = peak / j; t > 0) out.push_back({t, -direction * j});
  return out;
}

std::vector<double> phase_ends(const std::vector<Braking>& joints) {
  std::vector<double> out;
  for (const Braking& joint : joints) {
    double end = 0;
    for (const Phase& phase : joint.phases) out.push_back(end += phase.duration);
  }
  std::sort(out.begin(), out.end());
  // Of equal ends the last counts, so every joint has time to finish.
  std::vector<double> distinct;
  for (const double end : out) {
    if (distinct.empty() || end - distinct.back() > kSameTime)
      distinct.push_back(end);
    else
      distinct.back() = end;
  }
  return distinct;
}

/// Writes the joint's polynomial for `duration` seconds from `begin` and advances the joint.
void advance(Braking& joint, double begin, double duration, double* coefficients) {
  const Phase* phase = joint.at(begin + duration / 2);
  if (!phase) joint.velocity = joint.acceleration = 0;
  const double j = phase ? phase->jerk : 0.0, t = duration;
  coefficients[0] = joint.position;
  coefficients[1] = joint.velocity;
  coefficients[2] = joint.acceleration / 2;
  coefficients[3] = j / 6;
  joint.position += t * (joint.velocity + t * (joint.acceleration / 2 + t * j / 6));
  joint.velocity += t * (joint.acceleration + t * j / 2);
  joint.acceleration += t * j;
}

void check(std::span<const double> q, std::span<const double> v, std::span<const double> a,
           std::span<const JointMotionLimits> limits) {
  if (v.size() != q.size() || a.size() != q.size() || limits.size() != q.size())
    throw Error("bad-move", "a stop got positions, velocities, accelerations and limits of different sizes");
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (!std::isfinite(q[i] + v[i] + a[i]))
      throw Error("bad-move", "the state of joint " + std::to_string(i + 1) + " is not finite");
    const double least = std::min(limits[i].acceleration, limits[i].jerk);
    if (!(least > 0) || !std::isfinite(limits[i].acceleration + limits[i].jerk))
      throw Error("bad-limit",
                  "the limits of joint " + std::to_string(i + 1) + " must be above zero and finite");
  }
}

}  // namespace

Trajectory plan_stop(std::span<const double> q, std::span<const double> v, std::span<const double> a,
                     std::span<const JointMotionLimits> limits) {
  check(q, v, a, limits);
  std::vector<Braking> joints;
  for (std::size_t i = 0; i < q.size(); ++i)
    joints.push_back({q[i], v[i], a[i], stop_phases(v[i], a[i], limits[i])});
  std::vector<double> ends = phase_ends(joints);
  if (ends.empty() || ends.back() < kSameTime) ends = {1e-3};
  Trajectory out(q.size());
  std::vector<double> coefficients(q.size() * Trajectory::kCoefficients, 0.0);
  double begin = 0;
  for (const double end : ends) {
    for (std::size_t i = 0; i < q.size(); ++i)
      advance(joints[i], begin, end - begin, &coefficients[i * Trajectory::kCoefficients]);
    out.append(end - begin, coefficients);
    begin = end;
  }
  return out;
}

}  // namespace polyarm::trajectory
