#include <algorithm>
#include <cmath>

#include "polyarm/kinematics/singularity.hpp"
#include "polyarm/descent/numeric_core.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kProbe = 1e-5;  // rad or lengths, for differences
constexpr int kReturnSteps = 6;  // back to the pose after a move in its null space

/// For joints with both limits: the middle and half the range; false for others.
bool middle_of(const DescentArm& arm, std::size_t k, double& middle, double& half) {
  if (arm.lower[k] < -1e8 || arm.upper[k] > 1e8) return false;
  middle = 0.5 * (arm.lower[k] + arm.upper[k]);
  half = std::max(1e-6, 0.5 * (arm.upper[k] - arm.lower[k]));
  return true;
}

}  // namespace

void NumericCore::value_goal(const NumericQuestion& question, Descents& all, double* value) const noexcept {
  if (settings.goal == IkGoal::manipulability || settings.goal == IkGoal::away_from_singularities) {
    measure(arm, nullptr, all);
    for (std::size_t lane = 0; lane < kDescents; ++lane)
      value[lane] = 0.5 * std::log(std::max(1e-300, all.spread[lane]));
    return;
  }
  for (std::size_t lane = 0; lane < kDescents; ++lane) {
    value[lane] = 0;
    for (std::size_t k = 0; k < arm.joints; ++k) {
      double at = question.seed[k], unit = 1;
      if (settings.goal == IkGoal::mid_range && !middle_of(arm, k, at, unit)) continue;
      const double off = (all.x[k][lane] - at) / unit;
      value[lane] -= 0.5 * off * off;
    }
  }
}

/// The gradient of the goal's value.
void NumericCore::climb(const NumericQuestion& question, const NumericPlace& at,
                        double* direction) const noexcept {
  Descents all;
  double value[kDescents];
  for (std::size_t lane = 0; lane < kDescents; ++lane) set_target(question, lane, all);
  constexpr std::size_t kAtOnce = kDescents - 1;
  for (std::size_t k = 0; k < arm.joints; k += kAtOnce) {
    for (std::size_t lane = 0; lane < kDescents; ++lane) {
      set_state(at.x.data(), lane, all);
      if (lane < kAtOnce && k + lane < arm.joints) all.x[k + lane][lane] += kProbe;
    }
    value_goal(question, all, value);
    for (std::size_t lane = 0; lane < kAtOnce && k + lane < arm.joints; ++lane)
      direction[k + lane] = (value[lane] - value[kAtOnce]) / kProbe;
  }
}

void NumericCore::improve(const NumericQuestion& question, std::span<const double> seed,
                          NumericPlace& at) const noexcept {
  Descents all;
  double direction[Chain::kMostMoving], value[kDescents];
  IkSolution probe;
  for (std::size_t lane = 0; lane < kDescents; ++lane) set_target(question, lane, all);
  for (int step = 0; step < settings.goal_steps; ++step) {
    if (settings.goal == IkGoal::away_from_singularities) {
      write(at, seed, probe);
      if (smallest_singular_value(chain, {probe.q.data(), chain.joints()}) >= kAwayFromSingular) return;
    }
    climb(question, at, direction);
    double steepest = 1e-12;
    for (std::size_t k = 0; k < arm.joints; ++k) steepest = std::max(steepest, std::abs(direction[k]));
    // Lane 0 stays, the others move farther and farther.
    double reach = 0;
    for (std::size_t lane = 0; lane < kDescents; ++lane) {
      set_state(at.x.data(), lane, all);
      const bool capped = reach * steepest > 0.6;
      for (std::size_t k = 0; k < arm.joints; ++k)
        all.pull[k][lane] = direction[k] * (capped ? 0.6 / steepest : reach);
      reach = reach == 0 ? 1.0 / 64 : 2 * reach;
    }
    DescentRules here = rules;
    here.patience = 1e9;
    here.position2 = here.orientation2 = -1;
    here.pulled = true;
    here.steps = 1;
    descend(arm, here, task_of(question), all);
    here.pulled = false;
    here.steps = kReturnSteps;
    descend(arm, here, task_of(question), all);
    NumericPlace ends[kDescents];
    for (std::size_t lane = 0; lane < kDescents; ++lane) ends[lane] = place_of(all, lane);
    value_goal(question, all, value);
    std::size_t best = 0;
    for (std::size_t lane = 1; lane < kDescents; ++lane)
      if (good(ends[lane]) && value[lane] > value[best] + 1e-9) best = lane;
    if (best == 0) return;
    at = ends[best];
  }
}

}  // namespace polyarm::kinematics
