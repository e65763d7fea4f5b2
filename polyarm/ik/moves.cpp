#include "polyarm/ik/moves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "polyarm/ik/ik_arm.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace polyarm::ik {

namespace {

constexpr double kSameSolution = 1e-3;  // rad or m: solutions nearer than this are the same
constexpr int kStepsFromSeed = 60;
constexpr int kLimitSteps = 120;  // steps to find out whether limits are in the way

double distance(const IkSolution& one, std::span<const double> from) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < from.size(); ++i) sum += (one.q[i] - from[i]) * (one.q[i] - from[i]);
  return std::sqrt(sum);
}

double largest_change(const IkSolution& one, std::span<const double> from) noexcept {
  double most = 0;
  for (std::size_t i = 0; i < from.size(); ++i) most = std::max(most, std::abs(one.q[i] - from[i]));
  return most;
}

bool same(const IkSolution& a, const IkSolution& b, std::size_t joints) noexcept {
  return largest_change(a, {b.q.data(), joints}) < kSameSolution;
}

bool inside_limits(const Chain& chain, const IkSolution& one) noexcept {
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (one.q[i] < chain.lower()[i] || one.q[i] > chain.upper()[i]) return !chain.moves_tcp(i);
  return true;
}

Flaw flaw_in(const Chain& chain, const Pose& target, std::span<const double> seed,
             const IkTask& task) noexcept {
  const Quaternion& r = target.rotation;
  const double length = r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w;
  if (!std::isfinite(target.position.x + target.position.y + target.position.z + length))
    return Flaw::not_finite;
  if (length < 1e-12) return Flaw::no_rotation;
  if (chain.joints() == 0) return Flaw::no_joints;
  if (seed.size() != chain.joints()) return Flaw::seed_size;
  for (std::size_t i = 0; i < 6; ++i)
    if (!(task.low[i] <= task.high[i]) || !(task.weight[i] >= 0) || !std::isfinite(task.weight[i]))
      return Flaw::task;
  return Flaw::none;
}

std::string describe_task(const IkTask& task) {
  constexpr const char* kRows[] = {"x", "y", "z", "about x", "about y", "about z"};
  for (std::size_t i = 0; i < 6; ++i) {
    if (!(task.low[i] <= task.high[i]))
      return fmt::format("the tolerance {} goes from {:g} to {:g}, which is not a range", kRows[i],
                         task.low[i], task.high[i]);
    if (!(task.weight[i] >= 0) || !std::isfinite(task.weight[i]))
      return fmt::format("the weight {} is {:g}; write a finite number that is not negative", kRows[i],
                         task.weight[i]);
  }
  return {};
}

/// A solution's errors by forward kinematics.
void measure(const Chain& chain, const Pose& target, double position_tolerance, double orientation_tolerance,
             IkSolution& out) noexcept {
  const Pose there = chain.forward({out.q.data(), chain.joints()});
  out.position_error = norm(target.position - there.position);
  out.orientation_error = norm(to_rotation_vector(inverse(there.rotation) * target.rotation));
  out.exact = out.position_error <= position_tolerance && out.orientation_error <= orientation_tolerance;
}

/// Keeps the first of several equal solutions, and puts `first` (if any) before all others.
void keep_distinct(const IkSolution* first, std::size_t joints, IkSolutions& all) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < all.count; ++k) {
    const IkSolution& one = all.all[k];
    bool known = first && same(*first, one, joints);
    for (std::size_t j = 0; j < kept && !known; ++j) known = same(all.all[j], one, joints);
    if (known) continue;
    if (kept != k) all.all[kept] = one;
    ++kept;
  }
  all.count = kept;
  if (!first) return;
  all.count = std::min(kept + 1, IkSolutions::kCapacity);
  std::copy_backward(all.all.begin(), all.all.begin() + static_cast<std::ptrdiff_t>(all.count) - 1,
                     all.all.begin() + static_cast<std::ptrdiff_t>(all.count));
  all.all[0] = *first;
}

/// Chooses from solutions sorted by distance from `current`: those away from singularities before those near
/// one, then the nearest; on a tie the one nearest home.
const IkSolution& choose(const Chain& chain, const IkSolutions& found, std::span<const double> current,
                         std::span<const double> home) noexcept {
  constexpr double kTie = 1e-6;
  const auto regular = [&](const IkSolution& one) {
    return smallest_singular_value(chain, {one.q.data(), chain.joints()}) >= kSingular;
  };
  const IkSolution* best = std::find_if(found.begin(), found.end(), regular);
  if (best == found.end()) best = found.begin();
  const double nearest = distance(*best, current);
  for (const IkSolution* other = best + 1;
       other != found.end() && distance(*other, current) <= nearest + kTie; ++other)
    if (distance(*other, home) < distance(*best, home)) best = other;
  return *best;
}

IkOutcome refuse(Flaw flaw, std::span<const double> seed, IkSolution& out) noexcept {
  std::copy_n(seed.begin(), std::min(seed.size(), out.q.size()), out.q.begin());
  out.position_error = out.orientation_error = IkTask::kFree;
  out.distance = 0;
  out.exact = out.singular = false;
  return flaw == Flaw::no_joints || flaw == Flaw::nothing_moves ? IkOutcome::immovable : IkOutcome::malformed;
}

}  // namespace

Flaw read(const NumericCore& core, const Pose& target, std::span<const double> seed, const IkTask& task,
          DescentQuestion& out) noexcept {
  const Chain& chain = core.chain;
  if (const Flaw flaw = flaw_in(chain, target, seed, task); flaw != Flaw::none) return flaw;
  out.target = {target.position, normalized(target.rotation)};
  out.joints = seed.size();
  for (std::size_t i = 0; i < seed.size(); ++i)
    out.values[i] = std::clamp(std::isfinite(seed[i]) ? seed[i] : 0.0, chain.lower()[i], chain.upper()[i]);
  const IkTask* const part = task == IkTask{} ? nullptr : &task;
  if (core.read(out.target, part, out.seed(), out.inner)) return Flaw::none;
  return core.arm.joints == 0 ? Flaw::nothing_moves : Flaw::too_far;
}

std::string describe(Flaw flaw, const Chain& chain, std::span<const double> seed, const IkTask& task) {
  switch (flaw) {
    case Flaw::none:
      break;
    case Flaw::not_finite:
      return "the pose has a value that is not a finite number";
    case Flaw::no_rotation:
      return "the orientation is a quaternion of length zero";
    case Flaw::no_joints:
      return "the robot has no joints that move";
    case Flaw::seed_size:
      return fmt::format("the seed has {} values, the robot {} joints", seed.size(), chain.joints());
    case Flaw::task:
      return describe_task(task);
    case Flaw::nothing_moves:
      return "no joint moves the TCP";
    case Flaw::too_far:
      return "the pose is too far away to be computed";
  }
  return {};
}

bool place_is_fixed(const NumericQuestion& question) noexcept {
  bool out = true;
  for (std::size_t i = 0; question.task && i < 3; ++i)
    out &= question.task->low[i] == 0 && question.task->high[i] == 0;
  return out;
}

bool out_of_bounds(const NumericCore& core, const DescentQuestion& question) noexcept {
  if (!place_is_fixed(question.inner)) return false;
  return norm(question.target.position - core.chain.reach_center()) >
         core.chain.reach_bound() + core.settings.position_tolerance;
}

bool descend_directly(const NumericCore& core, const DescentQuestion& question, IkSolution& out) noexcept {
  NumericQuestion inner = question.inner;
  for (const bool walls : {false, true}) {
    NumericPlace at;
    inner.walls = walls;
    if (!core.follow(inner, kStepsFromSeed, at)) continue;
    core.finish(inner, question.seed(), true, at, out);
    if (inside_limits(core.chain, out)) return true;
  }
  return false;
}

bool search(const NumericCore& core, const DescentQuestion& question, int restarts,
            IkSolution& out) noexcept {
  const bool hopeless = out_of_bounds(core, question);
  if (!hopeless && descend_directly(core, question, out)) return true;
  NumericPlace at;
  const bool found = core.race(question.inner, restarts > 0 && !hopeless ? core.settings.steps : 0, at);
  core.finish(question.inner, question.seed(), found, at, out);
  return found;
}

void collect_descents(const NumericIk& numeric, const DescentQuestion& question, int restarts,
                      IkSolutions& out) noexcept {
  const std::span<const double> seed = question.seed();
  out.count = 0;
  if (restarts > 0) numeric.solve_all(question.target, seed, out);
  IkSolution direct;
  const bool there = descend_directly(numeric.core(), question, direct);
  keep_distinct(there ? &direct : nullptr, seed.size(), out);
  // Insertion sort: stable, allocates nothing.
  for (std::size_t k = 1; k < out.count; ++k)
    for (std::size_t j = k; j > 0 && distance(out.all[j], seed) < distance(out.all[j - 1], seed); --j)
      std::swap(out.all[j], out.all[j - 1]);
}

IkOutcome InverseKinematics::solve_move(const Pose& target, std::span<const double> current,
                                        std::span<const double> home, IkSolution& out) const noexcept {
  DescentQuestion question;
  if (!arm_->moves) return refuse(Flaw::nothing_moves, current, out);
  const NumericCore& core = arm_->moves->core();
  if (const Flaw flaw = read(core, target, current, {}, question); flaw != Flaw::none)
    return refuse(flaw, current, out);
  const std::span<const double> seed = question.seed();
  const auto take = [&](const IkSolution& one) {
    out = one;
    out.distance = distance(one, seed);
    measure(core.chain, question.target, settings().position_tolerance, settings().orientation_tolerance,
            out);
    return IkOutcome::solved;
  };
  IkSolution near;
  const bool hopeless = out_of_bounds(core, question);
  if (!hopeless && descend_directly(core, question, near)) {
    const double change = largest_change(near, seed);
    if (change <= kSameBranch ||
        (change <= kNearby &&
         smallest_singular_value(core.chain, {near.q.data(), seed.size()}) >= kVerySingular))
      return take(near);
  }
  IkSolutions found;
  if (!hopeless) arm_->collect(question, *this, found);
  if (found.count > 0) return take(choose(core.chain, found, seed, home.size() == seed.size() ? home : seed));
  if (search(core, question, settings().restarts, out)) return take(out);
  return arm_->why_unreached(question);
}

/// All branches of the closed form, else what descents find.
void InverseKinematics::Arm::collect(const DescentQuestion& question, const InverseKinematics& self,
                                     IkSolutions& out) const noexcept {
  out.count = 0;
  if (self) {
    IkSolution nearest;
    const bool has_nearest =
        !self.complete() && self.solve(question.target, question.seed(), nearest) == IkOutcome::solved;
    self.solve_all(question.target, question.seed(), out);
    keep_distinct(has_nearest ? &nearest : nullptr, question.joints, out);
  }
  // A complete closed form is final, even if it finds nothing.
  if (out.count == 0 && !(self && self.complete()))
    collect_descents(*moves, question, settings.restarts, out);
}

IkOutcome InverseKinematics::Arm::why_unreached(const DescentQuestion& question) const noexcept {
  NumericQuestion free = question.inner;
  NumericPlace at;
  free.walls = false;
  const bool beyond_limits =
      !out_of_bounds(moves->core(), question) && moves->core().race(free, kLimitSteps, at);
  return beyond_limits ? IkOutcome::limits : IkOutcome::unreachable;
}

IkOutcome InverseKinematics::solve(const Pose& target, const IkTask& task, std::span<const double> seed,
                                   IkSolution& out) const noexcept {
  DescentQuestion question;
  if (!arm_->moves) return refuse(Flaw::nothing_moves, seed, out);
  const NumericCore& core = arm_->moves->core();
  if (const Flaw flaw = read(core, target, seed, task, question); flaw != Flaw::none)
    return refuse(flaw, seed, out);
  if (search(core, question, settings().restarts, out)) return IkOutcome::solved;
  return arm_->why_unreached(question);
}

IkOutcome InverseKinematics::solve_all(const Pose& target, const IkTask& task, std::span<const double> seed,
                                       IkSolutions& out) const noexcept {
  out.count = 0;
  if (!arm_->moves) return IkOutcome::immovable;
  return arm_->moves->solve_all(target, task, seed, out);
}

IkOutcome InverseKinematics::track(const Pose& target, std::span<const double> seed,
                                   IkSolution& out) const noexcept {
  if (!arm_->moves) return refuse(Flaw::nothing_moves, seed, out);
  return arm_->moves->track(target, seed, out);
}

IkExplanation InverseKinematics::explain(const Pose& target, std::span<const double> seed,
                                         const IkTask& task) const {
  IkExplanation out;
  DescentQuestion question;
  const Flaw flaw =
      arm_->moves ? read(arm_->moves->core(), target, seed, task, question) : Flaw::nothing_moves;
  if (flaw != Flaw::none) {
    out.outcome = refuse(flaw, seed, out.nearest);
    out.reason = describe(flaw, chain(), seed, task);
    return out;
  }
  const NumericCore& core = arm_->moves->core();
  if (!search(core, question, settings().restarts, out.nearest)) return explain_failure(core, question);
  out.outcome = IkOutcome::solved;
  if (!question.inner.task)
    measure(chain(), question.target, settings().position_tolerance, settings().orientation_tolerance,
            out.nearest);
  return out;
}

}  // namespace polyarm::ik
