#include "polyarm/ik/arm_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/ik/failure.hpp"
#include "polyarm/descent/numeric_core.hpp"

namespace polyarm::kinematics {

namespace {

constexpr int kStepsPerRestart = 8;  // of eight descents side by side
constexpr std::size_t kMostSolutions = 64;
constexpr double kSameSolution = 1e-3;  // rad or m: nearer than this is one solution

double distance(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

double largest_change(std::span<const double> a, std::span<const double> b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

NumericSettings settings_of(const IkOptions& options) {
  NumericSettings out;
  out.position_tolerance = options.position_tolerance;
  out.orientation_tolerance = options.orientation_tolerance;
  out.steps = kStepsPerRestart * std::max(1, options.restarts);
  out.searches = std::max(1, options.restarts);
  return out;
}

bool inside_limits(const Chain& chain, const IkSolution& one) {
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (one.q[i] < chain.lower()[i] || one.q[i] > chain.upper()[i]) return !chain.moves_tcp(i);
  return true;
}

/// Of solutions sorted by distance from `current`: away from singularities before near them, then the
/// nearest; of those as near as the nearest, the one nearest home.
const std::vector<double>& choose(const Chain& chain, const std::vector<std::vector<double>>& found,
                                  std::span<const double> current, std::span<const double> home) {
  constexpr double kTie = 1e-6;
  const auto regular = [&](const auto& q) { return smallest_singular_value(chain, q) >= kSingular; };
  auto best = std::find_if(found.begin(), found.end(), regular);
  if (best == found.end()) best = found.begin();
  const double nearest = distance(*best, current);
  for (auto other = best + 1; other != found.end() && distance(*other, current) <= nearest + kTie; ++other)
    if (distance(*other, home) < distance(*best, home)) best = other;
  return *best;
}

}  // namespace

struct ArmSolver::Arm {
  NumericIk numeric;
  InverseKinematics closed_form;
  IkOptions options;

  const NumericCore& core() const { return numeric.core(); }
  const Chain& chain() const { return core().chain; }

  /// A question that can be asked; `flaw` says why not.
  struct Question {
    Pose target;
    std::vector<double> seed;  ///< within limits
    NumericQuestion inner;
    std::string flaw;
  };
  Question ask(const Pose& target, std::span<const double> seed, const IkTask* task = nullptr) const;
  bool out_of_bounds(const Question& question) const;
  IkResult flawed(const Question& question) const;
  IkResult solved(const Question& question, std::span<const double> q) const;
  bool direct(const Question& question, IkSolution& out) const;
  IkResult solved(const Question& question, const IkSolution& one) const;
  IkResult search(const Question& question) const;
  void collect_branches(const Question& question, std::vector<std::vector<double>>& out) const;
  void collect_descents(const Question& question, std::vector<std::vector<double>>& out) const;
  std::vector<std::vector<double>> collect(const Question& question) const;
};

std::string flaw_of(const IkTask& task) {
  constexpr const char* kRows[] = {"x", "y", "z", "about x", "about y", "about z"};
  for (std::size_t i = 0; i < 6; ++i) {
    if (!(task.low[i] <= task.high[i]))
      return fmt::format("the tolerance {} goes from {:g} to {:g}, which is no range", kRows[i], task.low[i],
                         task.high[i]);
    if (!(task.weight[i] >= 0) || !std::isfinite(task.weight[i]))
      return fmt::format("the weight {} is {:g}, which counts nothing", kRows[i], task.weight[i]);
  }
  return {};
}

ArmSolver::Arm::Question ArmSolver::Arm::ask(const Pose& target, std::span<const double> seed,
                                             const IkTask* task) const {
  Question out{target, {seed.begin(), seed.end()}, {}, {}};
  const Quaternion& r = target.rotation;
  const double length = r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w;
  if (!std::isfinite(target.position.x + target.position.y + target.position.z + length))
    out.flaw = "the pose has a value that is not a finite number";
  else if (length < 1e-12)
    out.flaw = "the orientation is a quaternion of length zero";
  else if (chain().joints() == 0)
    out.flaw = "the robot has no joints that move";
  else if (seed.size() != chain().joints())
    out.flaw = "the seed has " + std::to_string(seed.size()) + " values, the robot " +
               std::to_string(chain().joints()) + " joints";
  else if (task)
    out.flaw = flaw_of(*task);
  if (!out.flaw.empty()) return out;
  out.target.rotation = normalized(r);
  for (std::size_t i = 0; i < seed.size(); ++i) {
    const double lower = chain().lower()[i], upper = chain().upper()[i];
    out.seed[i] = std::clamp(std::isfinite(seed[i]) ? seed[i] : 0.0, lower, upper);
  }
  const IkTask place = IkTask::position_only();
  if (!task && options.orientation_free) task = &place;
  if (!core().read(out.target, task, out.seed, out.inner))
    out.flaw = core().arm.joints == 0 ? "no joint moves the TCP" : "the pose is too far away to be computed";
  return out;
}

/// Beyond all lengths of the arm; never where a task gives the place some room.
bool ArmSolver::Arm::out_of_bounds(const Question& question) const {
  if (!place_is_fixed(question.inner)) return false;
  return norm(question.target.position - chain().reach_center()) >
         chain().reach_bound() + options.position_tolerance;
}

IkResult ArmSolver::Arm::flawed(const Question& question) const {
  IkResult out;
  out.q = question.seed;
  out.position_error = out.orientation_error = std::numeric_limits<double>::infinity();
  out.reason = question.flaw;
  return out;
}

IkResult ArmSolver::Arm::solved(const Question& question, std::span<const double> q) const {
  IkResult out;
  out.status = IkStatus::solved;
  out.q.assign(q.begin(), q.end());
  const Pose there = chain().forward(q);
  out.position_error = norm(question.target.position - there.position);
  if (!options.orientation_free)
    out.orientation_error = angle_between(there.rotation, question.target.rotation);
  return out;
}

IkResult ArmSolver::Arm::solved(const Question& question, const IkSolution& one) const {
  if (!question.inner.task) return solved(question, std::span(one.q.data(), chain().joints()));
  IkResult out;
  out.status = IkStatus::solved;
  out.q.assign(one.q.begin(), one.q.begin() + static_cast<std::ptrdiff_t>(chain().joints()));
  out.position_error = one.position_error;
  out.orientation_error = one.orientation_error;
  return out;
}

/// From the seed: first free and wound back into the limits; if they are still broken, with the limits as
/// walls.
bool ArmSolver::Arm::direct(const Question& question, IkSolution& out) const {
  NumericQuestion inner = question.inner;
  for (const bool walls : {false, true}) {
    NumericPlace at;
    inner.walls = walls;
    if (!core().follow(inner, std::max(options.iterations, 1), at)) continue;
    core().polish(inner, at);
    core().write(at, question.seed, out);
    if (inside_limits(chain(), out)) return true;
  }
  return false;
}

IkResult ArmSolver::Arm::search(const Question& question) const {
  const bool hopeless = out_of_bounds(question);
  IkSolution found;
  if (!hopeless && direct(question, found)) return solved(question, found);
  NumericPlace at;
  if (!hopeless && options.restarts > 0 && core().race(question.inner, core().settings.steps, at)) {
    core().finish(question.inner, question.seed, true, at, found);
    return solved(question, found);
  }
  IkResult out;
  explain_failure(core(), question.inner, question.target, question.seed, options, out);
  return out;
}

/// All branches of the arm's closed form, where it has one, nearest to the seed first.
void ArmSolver::Arm::collect_branches(const Question& question, std::vector<std::vector<double>>& out) const {
  if (!closed_form || options.orientation_free) return;
  const std::size_t n = chain().joints();
  const auto add = [&](const IkSolution& one) {
    const std::span<const double> q(one.q.data(), n);
    const auto same = [&](const auto& other) { return largest_change(other, q) < kSameSolution; };
    if (out.size() < kMostSolutions && std::none_of(out.begin(), out.end(), same))
      out.emplace_back(q.begin(), q.end());
  };
  IkSolution nearest;
  if (!closed_form.complete() &&
      closed_form.solve(question.target, question.seed, nearest) == IkOutcome::solved)
    add(nearest);
  const auto found = std::make_unique<IkSolutions>();
  closed_form.solve_all(question.target, question.seed, *found);
  for (const IkSolution& one : *found) add(one);
}

void ArmSolver::Arm::collect_descents(const Question& question, std::vector<std::vector<double>>& out) const {
  const std::size_t n = chain().joints();
  const auto add = [&](const IkSolution& one) {
    const std::span<const double> q(one.q.data(), n);
    const auto same = [&](const auto& other) { return largest_change(other, q) < kSameSolution; };
    if (std::none_of(out.begin(), out.end(), same)) out.emplace_back(q.begin(), q.end());
  };
  IkSolution one;
  if (direct(question, one)) add(one);
  const auto found = std::make_unique<IkSolutions>();
  if (options.restarts > 0) {
    const IkTask place = IkTask::position_only();
    if (options.orientation_free)
      numeric.solve_all(question.target, place, question.seed, *found);
    else
      numeric.solve_all(question.target, question.seed, *found);
  }
  for (const IkSolution& other : *found) add(other);
  std::stable_sort(out.begin(), out.end(), [&](const auto& a, const auto& b) {
    return distance(a, question.seed) < distance(b, question.seed);
  });
  if (out.size() > kMostSolutions) out.resize(kMostSolutions);
}

std::vector<std::vector<double>> ArmSolver::Arm::collect(const Question& question) const {
  std::vector<std::vector<double>> out;
  if (out_of_bounds(question)) return out;
  collect_branches(question, out);
  // A closed form that finds all branches and finds none has the last word.
  if (out.empty() && !(closed_form && closed_form.complete() && !options.orientation_free))
    collect_descents(question, out);
  return out;
}

ArmSolver::ArmSolver(const Chain& chain, const IkOptions& options)
    : arm_(new Arm{NumericIk(chain, settings_of(options)), InverseKinematics(chain), options}) {}
ArmSolver::~ArmSolver() = default;
ArmSolver::ArmSolver(ArmSolver&&) noexcept = default;
ArmSolver& ArmSolver::operator=(ArmSolver&&) noexcept = default;

const Chain& ArmSolver::chain() const noexcept {
  return arm_->chain();
}
const IkOptions& ArmSolver::options() const noexcept {
  return arm_->options;
}
const NumericIk& ArmSolver::numeric() const noexcept {
  return arm_->numeric;
}
const InverseKinematics& ArmSolver::closed_form() const noexcept {
  return arm_->closed_form;
}

IkResult ArmSolver::solve(const Pose& target, std::span<const double> seed) const {
  const Arm::Question question = arm_->ask(target, seed);
  return question.flaw.empty() ? arm_->search(question) : arm_->flawed(question);
}

IkResult ArmSolver::solve(const Pose& target, const IkTask& task, std::span<const double> seed) const {
  const Arm::Question question = arm_->ask(target, seed, &task);
  return question.flaw.empty() ? arm_->search(question) : arm_->flawed(question);
}

std::vector<std::vector<double>> ArmSolver::find_solutions(const Pose& target,
                                                           std::span<const double> rank_from) const {
  const Arm::Question question = arm_->ask(target, rank_from);
  return question.flaw.empty() ? arm_->collect(question) : std::vector<std::vector<double>>{};
}

IkResult ArmSolver::solve_nearest(const Pose& target, std::span<const double> current,
                                  std::span<const double> home) const {
  const Arm::Question question = arm_->ask(target, current);
  if (!question.flaw.empty()) return arm_->flawed(question);
  const std::size_t n = chain().joints();
  IkSolution near;
  if (!arm_->out_of_bounds(question) && arm_->direct(question, near)) {
    const std::span<const double> q(near.q.data(), n);
    const double change = largest_change(q, question.seed);
    if (change <= kSameBranch || (change <= kNearby && smallest_singular_value(chain(), q) >= kVerySingular))
      return arm_->solved(question, q);
  }
  const std::vector<std::vector<double>> found = arm_->collect(question);
  if (found.empty()) return arm_->search(question);
  const std::span<const double> rest = home.size() == n ? home : std::span<const double>(question.seed);
  return arm_->solved(question, choose(chain(), found, question.seed, rest));
}

}  // namespace polyarm::kinematics
