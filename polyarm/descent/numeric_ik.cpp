#include "polyarm/descent/numeric_ik.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/descent/numeric_core.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kSameSolution = 1e-4;  // rad or m: solutions nearer than this are the same
constexpr int kLimitSteps = 120;        // to find out whether limits are in the way

IkOutcome refuse(std::span<const double> seed, IkSolution& out) noexcept {
  std::copy_n(seed.begin(), std::min(seed.size(), out.q.size()), out.q.begin());
  out.position_error = out.orientation_error = IkTask::kFree;
  out.distance = 0;
  out.exact = out.singular = false;
  return IkOutcome::malformed;
}

IkOutcome solve_one(const NumericCore& core, const Pose& target, const IkTask* task,
                    std::span<const double> seed, IkSolution& out) noexcept {
  NumericQuestion question;
  NumericPlace at;
  if (!core.read(target, task, seed, question)) return refuse(seed, out);
  const bool found = core.race(question, core.settings.steps, at);
  const IkOutcome outcome = core.finish(question, seed, found, at, out);
  if (found) return outcome;
  question.walls = false;
  return core.race(question, kLimitSteps, at) ? IkOutcome::limits : IkOutcome::unreachable;
}

IkOutcome follow_one(const NumericCore& core, const Pose& target, const IkTask* task,
                     std::span<const double> seed, IkSolution& out) noexcept {
  NumericQuestion question;
  NumericPlace at;
  if (!core.read(target, task, seed, question)) return refuse(seed, out);
  const bool found = core.follow(question, core.settings.track_steps, at);
  core.write(at, seed, out);
  return found ? IkOutcome::solved : IkOutcome::unreachable;
}

bool same(const Chain& chain, const IkSolution& a, const IkSolution& b) noexcept {
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (!(std::abs(a.q[i] - b.q[i]) < kSameSolution)) return false;
  return true;
}

/// Keeps distinct solutions, and the nearest ones if there are too many.
void keep(const Chain& chain, const IkSolution& one, IkSolutions& out) noexcept {
  IkSolution* const end = out.all.data() + out.count;
  IkSolution* const twin =
      std::find_if(out.all.data(), end, [&](const IkSolution& other) { return same(chain, one, other); });
  if (twin != end) {
    if (one.position_error + one.orientation_error < twin->position_error + twin->orientation_error)
      *twin = one;
    return;
  }
  if (out.count < IkSolutions::kCapacity) {
    out.all[out.count++] = one;
    return;
  }
  const auto nearer = [](const IkSolution& a, const IkSolution& b) { return a.distance < b.distance; };
  IkSolution* const furthest = std::max_element(out.all.data(), end, nearer);
  if (one.distance < furthest->distance) *furthest = one;
}

IkOutcome solve_many(const NumericCore& core, const Pose& target, const IkTask* task,
                     std::span<const double> seed, IkSolutions& out) noexcept {
  out.count = 0;
  NumericQuestion question;
  if (!core.read(target, task, seed, question)) return IkOutcome::malformed;
  IkSolution one;
  core.find_obstacles(question, core.settings.searches, [&](NumericPlace at) {
    if (!core.good(at)) return;
    if (core.settings.polish) core.polish(question, at);
    core.write(at, seed, one);
    keep(core.chain, one, out);
  });
  if (out.count == 0) {
    // The last attempt has more patience and gives the reason.
    const IkOutcome outcome = solve_one(core, target, task, seed, one);
    if (outcome == IkOutcome::solved) out.all[out.count++] = one;
    return outcome;
  }
  std::sort(out.all.data(), out.all.data() + out.count,
            [](const IkSolution& a, const IkSolution& b) { return a.distance < b.distance; });
  return IkOutcome::solved;
}

/// Eight targets in parallel; a lane that is done takes the next target.
class Batch {
 public:
  Batch(const NumericCore& core, std::span<const Pose> targets, std::span<const double> seeds,
        std::span<IkSolution> out) noexcept
      : core_(core), targets_(targets), seeds_(seeds), out_(out) {}

  std::size_t run() noexcept {
    for (std::size_t lane = 0; lane < kDescents; ++lane) take(lane);
    DescentRules rules = core_.rules;
    if (core_.settings.polish) {
      rules.position2 = std::min(rules.position2, kFine2);
      rules.orientation2 = std::min(rules.orientation2, kFine2);
    }
    while (working_ > 0) {
      rules.steps = kRound;
      const int done = std::max(1, descend(core_.arm, rules, nullptr, all_));
      for (std::size_t lane = 0; lane < kDescents; ++lane) end_step(lane, done);
    }
    return solved_;
  }

 private:
  static constexpr double kFine2 = 1e-9 * 1e-9;
  static constexpr int kRound = 32;
  static constexpr std::size_t kIdle = ~std::size_t{0};
  struct Lane {
    std::size_t job = kIdle;
    NumericQuestion question;
    SeedTable::Search search;
    NumericPlace nearest;
    int steps = 0;
  };

  std::span<const double> seed_of(std::size_t job) const noexcept {
    const std::size_t n = core_.chain.joints();
    if (seeds_.empty()) return {kZeros.data(), n};
    return seeds_.subspan(job * n, n);
  }

  void take(std::size_t at) noexcept {
    Lane& lane = lanes_[at];
    lane.job = kIdle;
    while (next_ < targets_.size() && lane.job == kIdle) {
      const std::size_t job = next_++;
      if (core_.read(targets_[job], nullptr, seed_of(job), lane.question))
        lane.job = job;
      else
        refuse(seed_of(job), out_[job]);
    }
    if (lane.job == kIdle) {
      rest(at);
      return;
    }
    ++working_;
    lane.steps = 0;
    lane.nearest = {};
    core_.set_target(lane.question, at, all_);
    core_.begin_search(lane.question, lane.search);
    core_.restart(lane.search, at, all_);
  }

  /// Parks a lane without work so that it does not disturb the others.
  void rest(std::size_t at) noexcept {
    for (std::size_t i = 0; i < 12; ++i) all_.target[i][at] = i % 4 == 0 && i < 9 ? 1.0 : 1e6;
    for (std::size_t k = 0; k < core_.arm.joints; ++k) all_.x[k][at] = 0;
    all_.restart(at);
  }

  void end_step(std::size_t at, int done) noexcept {
    Lane& lane = lanes_[at];
    if (lane.job == kIdle) {
      rest(at);
      return;
    }
    lane.steps += done;
    const bool over = (all_.converged | all_.stale) >> at & 1;
    const bool late = lane.steps > static_cast<int>(kDescents) * core_.settings.steps;
    if (!over && !late) return;
    const NumericPlace here = core_.place_of(all_, at);
    if (here.size2() < lane.nearest.size2()) lane.nearest = here;
    const bool good = core_.good(lane.nearest);
    if (!good && !late) {
      core_.restart(lane.search, at, all_);
      return;
    }
    core_.write(lane.nearest, seed_of(lane.job), out_[lane.job]);
    solved_ += good;
    --working_;
    take(at);
  }

  static constexpr std::array<double, Chain::kMaxJoints> kZeros{};
  const NumericCore& core_;
  std::span<const Pose> targets_;
  std::span<const double> seeds_;
  std::span<IkSolution> out_;
  std::array<Lane, kDescents> lanes_;
  Descents all_;
  std::size_t next_ = 0, working_ = 0, solved_ = 0;
};

}  // namespace

NumericIk::NumericIk(const Chain& chain, NumericSettings settings)
    : core_(std::make_unique<const NumericCore>(chain, std::move(settings))) {}
NumericIk::NumericIk(const NumericIk& same_arm, NumericSettings settings)
    : core_(std::make_unique<const NumericCore>(same_arm.core_->shared, std::move(settings))) {}
NumericIk::~NumericIk() = default;
NumericIk::NumericIk(NumericIk&&) noexcept = default;
NumericIk& NumericIk::operator=(NumericIk&&) noexcept = default;

IkOutcome NumericIk::solve(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept {
  return solve_one(*core_, target, nullptr, seed, out);
}
IkOutcome NumericIk::solve(const Pose& target, const IkTask& task, std::span<const double> seed,
                           IkSolution& out) const noexcept {
  return solve_one(*core_, target, &task, seed, out);
}
IkOutcome NumericIk::track(const Pose& target, std::span<const double> seed, IkSolution& out) const noexcept {
  return follow_one(*core_, target, nullptr, seed, out);
}
IkOutcome NumericIk::track(const Pose& target, const IkTask& task, std::span<const double> seed,
                           IkSolution& out) const noexcept {
  return follow_one(*core_, target, &task, seed, out);
}
IkOutcome NumericIk::solve_all(const Pose& target, std::span<const double> seed,
                               IkSolutions& out) const noexcept {
  return solve_many(*core_, target, nullptr, seed, out);
}
IkOutcome NumericIk::solve_all(const Pose& target, const IkTask& task, std::span<const double> seed,
                               IkSolutions& out) const noexcept {
  return solve_many(*core_, target, &task, seed, out);
}

std::size_t NumericIk::solve_batch(std::span<const Pose> targets, std::span<const double> seeds,
                                   std::span<IkSolution> out) const noexcept {
  if (out.size() != targets.size()) return 0;
  if (!seeds.empty() && seeds.size() != targets.size() * core_->chain.joints()) return 0;
  return Batch(*core_, targets, seeds, out).run();
}

const NumericSettings& NumericIk::settings() const noexcept {
  return core_->settings;
}

}  // namespace polyarm::kinematics
