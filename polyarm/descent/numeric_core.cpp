#include "polyarm/descent/numeric_core.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/descent/unwind.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kRounding = 1e-11;  // of errors, in lengths and rad: a smaller error counts as zero
constexpr int kPolish = 4;
constexpr int kStepsAlone = 6;  // usually two

double squared(double v) {
  return v * v;
}

bool finite(const Pose& p) noexcept {
  const auto& [x, y, z, w] = p.rotation;
  const double size2 = x * x + y * y + z * z + w * w;
  return std::isfinite(p.position.x + p.position.y + p.position.z + size2) && size2 > 1e-12 && size2 < 1e12;
}

/// The task in the units of the kernel; false if it contains NaN or infinity where that is not allowed.
bool convert(const IkTask& task, double length, DescentTask& out) noexcept {
  out.of_tool = task.frame == IkTask::Frame::tool;
  int free_turns = 0, free_turn = -1;
  for (std::size_t i = 0; i < 6; ++i) {
    if (!(task.low[i] <= task.high[i]) || !(task.weight[i] >= 0) || !std::isfinite(task.weight[i]))
      return false;
    const double unit = i < 3 ? length : 1.0;
    out.low[i] = std::max(-1e9, task.low[i] / unit);
    out.high[i] = std::min(1e9, task.high[i] / unit);
    out.weight[i] = task.weight[i];
    if (i >= 3 && out.low[i] <= -1e8 && out.high[i] >= 1e8) {
      ++free_turns;
      free_turn = static_cast<int>(i) - 3;
    }
  }
  out.spin = free_turns == 1 && out.of_tool ? free_turn : -1;
  return true;
}

}  // namespace

NumericArm::NumericArm(const Chain& c, std::size_t seeds)
    : chain(c), arm(chain), table(arm, std::max<std::size_t>(16, seeds)) {}

NumericCore::NumericCore(const Chain& c, NumericSettings s)
    : NumericCore(std::make_shared<const NumericArm>(c, s.seeds), std::move(s)) {}

NumericCore::NumericCore(std::shared_ptr<const NumericArm> a, NumericSettings s)
    : shared(std::move(a)),
      settings(std::move(s)),
      chain(shared->chain),
      arm(shared->arm),
      table(shared->table) {
  // Slightly smaller, so that rounding in the last conversion does not matter.
  rules.position2 = squared(0.99 * settings.position_tolerance / arm.length);
  rules.orientation2 = squared(0.99 * settings.orientation_tolerance);
}

bool NumericCore::read(const Pose& target, const IkTask* task, std::span<const double> seed,
                       NumericQuestion& out) const noexcept {
  if (seed.size() != chain.joints() || !finite(target) || arm.joints == 0) return false;
  const Rotation end = rotation_of(normalized(target.rotation)) * transposed(arm.last_turn);
  const Vec3 p = (1 / arm.length) * target.position;
  if (!(norm(p) < 1e9)) return false;
  out.target = {end.x.x, end.x.y, end.x.z, end.y.x, end.y.y, end.y.z,
                end.z.x, end.z.y, end.z.z, p.x,     p.y,     p.z};
  out.walls = true;
  out.task.reset();
  if (task && !convert(*task, arm.length, out.task.emplace())) return false;
  for (std::size_t k = 0; k < arm.joints; ++k) {
    const double value = seed[arm.chain_joint[k]];
    // Removes whole turns, because sines of large angles lose digits; they are restored at the end.
    const double period = chain.period(arm.chain_joint[k]);
    const double far = std::abs(value);
    const double near =
        2 * far > period && period > 0 && far < 1e9 && arm.upper[k] > 1e8 && arm.lower[k] < -1e8
            ? value - period * std::nearbyint(value / period)
            : value;
    if (!std::isfinite(near)) return false;
    out.seed[k] = std::clamp(near / arm.unit[k], std::max(arm.lower[k], -1e5), std::min(arm.upper[k], 1e5));
  }
  return true;
}

void NumericCore::set_target(const NumericQuestion& question, std::size_t lane,
                             Descents& all) const noexcept {
  for (std::size_t i = 0; i < question.target.size(); ++i) all.target[i][lane] = question.target[i];
}

void NumericCore::set_targets(const NumericQuestion& question, Descents& all) const noexcept {
  for (std::size_t i = 0; i < question.target.size(); ++i)
    std::fill_n(all.target[i], kDescents, question.target[i]);
}

void NumericCore::set_states(const double* x, Descents& all) const noexcept {
  for (std::size_t k = 0; k < arm.joints; ++k) std::fill_n(all.x[k], kDescents, x[k]);
  std::fill_n(all.least, kDescents, 1e300);
  std::fill_n(all.stuck, kDescents, 0.0);
}

void NumericCore::set_state(const double* x, std::size_t lane, Descents& all) const noexcept {
  for (std::size_t k = 0; k < arm.joints; ++k) all.x[k][lane] = x[k];
  all.restart(lane);
}

NumericPlace NumericCore::place_of(const Descents& all, std::size_t lane) const noexcept {
  NumericPlace out;
  for (std::size_t k = 0; k < arm.joints; ++k) out.x[k] = all.x[k][lane];
  out.position2 = all.position2[lane];
  out.orientation2 = all.orientation2[lane];
  return out;
}

void NumericCore::begin_search(const NumericQuestion& q, SeedTable::Search& search) const noexcept {
  const auto vec = [&](std::size_t i) { return Vec3{q.target[i], q.target[i + 1], q.target[i + 2]}; };
  table.begin({vec(0), vec(3), vec(6)}, vec(9), search);
}

void NumericCore::restart(SeedTable::Search& search, std::size_t lane, Descents& all) const noexcept {
  std::array<double, Chain::kMostMoving> x;
  table.next(search, x.data());
  set_state(x.data(), lane, all);
}

double NumericCore::distance2(const double* x, const double* seed) const noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < arm.joints; ++k) sum += squared(arm.unit[k] * (x[k] - seed[k]));
  return sum;
}

bool NumericCore::race(const NumericQuestion& question, int steps, NumericPlace& out) const noexcept {
  Descents all;
  SeedTable::Search search;
  begin_search(question, search);
  set_targets(question, all);
  set_state(question.seed.data(), 0, all);
  for (std::size_t lane = 1; lane < kDescents; ++lane) restart(search, lane, all);
  DescentRules here = rules;
  here.walls = question.walls;
  out = {};
  while (steps > 0) {
    here.steps = steps;
    steps -= std::max(1, descend(arm, here, task_of(question), all));
    for (std::size_t lane = 0; lane < kDescents; ++lane) {
      const bool converged = all.converged >> lane & 1;
      if (!converged && (all.converged || !(all.stale >> lane & 1))) continue;
      const NumericPlace at = place_of(all, lane);
      // A state within both tolerances is better than one that is nearer in sum but outside one of them.
      const bool better = converged != good(out) ? converged
                          : converged            ? distance2(at.x.data(), question.seed.data()) <
                                            distance2(out.x.data(), question.seed.data())
                                      : at.size2() < out.size2();
      if (better) out = at;
      if (!all.converged) restart(search, lane, all);
    }
    if (all.converged) break;
  }
  if (out.size2() > 1e299) {
    set_state(question.seed.data(), 0, all);
    measure(arm, task_of(question), all);
    out = place_of(all, 0);
  }
  return good(out);
}

bool NumericCore::follow_alone(const NumericQuestion& question, const double* from, double position2,
                               double orientation2, int steps, NumericPlace& out) const noexcept {
  if (question.task || !arm.single.possible) return false;
  DescentRules here = rules;
  here.walls = question.walls;
  here.position2 = position2;
  here.orientation2 = orientation2;
  here.steps = std::min(steps, kStepsAlone);
  SingleDescent one;
  std::copy_n(from, arm.joints, one.x);
  if (!descend_alone(arm, here, question.target.data(), one)) return false;
  std::copy_n(one.x, arm.joints, out.x.begin());
  out.position2 = one.position2;
  out.orientation2 = one.orientation2;
  return true;
}

bool NumericCore::follow(const NumericQuestion& question, int steps, NumericPlace& out) const noexcept {
  if (follow_alone(question, question.seed.data(), rules.position2, rules.orientation2, steps, out))
    return true;
  Descents all;
  set_targets(question, all);
  set_states(question.seed.data(), all);
  DescentRules here = rules;
  here.walls = question.walls;
  here.steps = steps;
  here.patience = 8;
  descend(arm, here, task_of(question), all);
  out = place_of(all, 0);
  return good(out);
}

void NumericCore::polish(const NumericQuestion& question, NumericPlace& at) const noexcept {
  if (at.size2() < squared(kRounding)) return;
  if (follow_alone(question, at.x.data(), squared(kRounding), squared(kRounding), kPolish, at)) return;
  Descents all;
  set_targets(question, all);
  set_states(at.x.data(), all);
  DescentRules here = rules;
  here.walls = question.walls;
  here.position2 = here.orientation2 = squared(kRounding);
  here.steps = kPolish;
  here.patience = 2;
  descend(arm, here, task_of(question), all);
  const NumericPlace then = place_of(all, 0);
  // A smaller sum may have a larger error in one of the two.
  if (then.size2() < at.size2() && (good(then) || !good(at))) at = then;
}

void NumericCore::settle(const NumericQuestion& question, int steps, Places& places) const noexcept {
  Descents all;
  set_targets(question, all);
  for (std::size_t lane = 0; lane < kDescents; ++lane) set_state(places[lane].x.data(), lane, all);
  DescentRules here = rules;
  here.walls = question.walls;
  here.steps = steps;
  here.patience = 1e9;
  here.position2 = here.orientation2 = -1;
  descend(arm, here, task_of(question), all);
  for (std::size_t lane = 0; lane < kDescents; ++lane) places[lane] = place_of(all, lane);
}

void NumericCore::write(const NumericPlace& at, std::span<const double> seed,
                        IkSolution& out) const noexcept {
  std::copy(seed.begin(), seed.end(), out.q.begin());
  out.distance = 0;
  for (std::size_t k = 0; k < arm.joints; ++k) {
    const std::size_t i = arm.chain_joint[k];
    const double value = arm.unit[k] * at.x[k];
    out.q[i] = unwound(chain, i, value, seed[i]);
    if (excess(chain, i, out.q[i]) < 1e-9)
      out.q[i] = std::clamp(out.q[i], chain.lower()[i], chain.upper()[i]);
    const double weight = i < settings.weights.size() ? settings.weights[i] : 1.0;
    out.distance += squared(weight * (out.q[i] - seed[i]));
  }
  out.distance = std::sqrt(out.distance);
  out.position_error = arm.length * std::sqrt(at.position2);
  out.orientation_error = 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(at.orientation2)));
  out.exact = good(at);
  out.singular = false;
}

IkOutcome NumericCore::finish(const NumericQuestion& question, std::span<const double> seed, bool found,
                              NumericPlace& at, IkSolution& out) const noexcept {
  if (found && settings.goal != IkGoal::none) improve(question, seed, at);
  if (found && settings.polish) polish(question, at);
  write(at, seed, out);
  return found ? IkOutcome::solved : IkOutcome::unreachable;
}

}  // namespace polyarm::kinematics
