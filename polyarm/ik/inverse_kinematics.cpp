#include "polyarm/ik/inverse_kinematics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "polyarm/ik/ik_arm.hpp"

namespace polyarm::ik {

namespace {

constexpr double kSameSolution = 1e-6;  // rad: solutions nearer than this are the same
constexpr double kSharper = 1e-4;       // rad: nearer than this may be the same solution with more digits
constexpr double kSameFamily = 0.3;     // rad: nearer than this may be members of one family
constexpr std::size_t kCrowd = 16;      // solutions; above this, most are members of families
constexpr double kNearly = 1e-3;        // m and rad

double largest_change(const AxisValues& a, const AxisValues& b, std::size_t n) noexcept {
  double most = 0;
  for (std::size_t i = 0; i < n; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

bool finite(const Pose& p) noexcept {
  const auto& [x, y, z, w] = p.rotation;
  return std::isfinite(p.position.x + p.position.y + p.position.z + x + y + z + w) &&
         x * x + y * y + z * z + w * w > 1e-12;
}

}  // namespace

bool InverseKinematics::Arm::accepts(const Pose& target, std::span<const double> seed) const noexcept {
  if (seed.size() != joints || !finite(target)) return false;
  for (std::size_t i = 0; i < geometry.count; ++i)
    if (!(std::abs(seed[geometry.axes[i].joint]) < 1e9)) return false;
  return true;
}

/// True if there is a fast path that accepts the seed.
bool InverseKinematics::Arm::takes_quick(std::span<const double> seed) const noexcept {
  if (quick.form.family == ArmFamily::none || seed.size() != joints) return false;
  for (std::size_t i = 0; i < 6; ++i)
    if (!(std::abs(seed[geometry.axes[i].joint]) < 1e9)) return false;
  return true;
}

void InverseKinematics::Arm::write_quick(const QuickAnswers& from, std::size_t lane,
                                         std::span<const double> seed, IkSolution& to) const noexcept {
  if (joints > 6) std::copy(seed.begin(), seed.end(), to.q.begin());
  for (std::size_t i = 0; i < 6; ++i) to.q[geometry.axes[i].joint] = from.value[i][lane];
  to.position_error = from.position_error[lane];
  to.orientation_error = from.orientation_error[lane];
  to.distance = from.distance[lane];
  to.exact = true;
  to.singular = false;
}

/// Finds all branches. Near singularities it takes both the solution with the seed's value of the nearly free
/// joint and those that the pose determines; for a non-ideal arm also what descents find around the seed and
/// beyond folds.
void InverseKinematics::Arm::solve_at(BranchJob& job, const SixAxisForm& strict_form,
                                      const SixAxisForm& tolerant_form, Gathered& out) const noexcept {
  const std::size_t before = out.count;
  if (sliding) {
    std::array<SlidingArm::State, SlidingArm::kMost> states;
    sliding->solve(job.target, job.seed, states);
    return offer(job, states, before, out);
  }
  if (algebraic()) return offer_roots(job, before, out);
  if (searched(known.family)) return search_at(job, strict_form, before, out);
  if (!known.exact()) return solve_nearly_ideal(job, strict_form, tolerant_form, out);
  Branches branches;
  job.form = &tolerant_form;
  solve_branches(job, branches);
  // Two branches that differ by a hundredth of a radian may be one solution within tolerances.
  out.nearest_stays = true;
  if (branches.free == 0) return sift(job, branches, before, out);
  // The family member nearest to the seed represents others that hardly differ, so it comes first.
  offer_alone(job, out.seed, out);
  sift(job, branches, before, out);
  job.form = &strict_form;
  solve_branches(job, branches);
  sift(job, branches, before, out);
  // An angle that is free for six axes is not free for fewer: the fixed axes leave few members of the family.
  if (branches.free != 0 && geometry.count < 6) along_families(job, 0, before, out);
}

/// All results of the search along one axis, and of descents around the seed.
void InverseKinematics::Arm::search_at(BranchJob& job, const SixAxisForm& strict_form, std::size_t before,
                                       Gathered& out) const noexcept {
  // Twice as many, because the search may refine some cells.
  std::array<Branches, 2 * kSearchBlocks> found;
  job.form = &strict_form;
  job.worth_polishing = 1;
  job.patience = 5;
  around_seed(job, before, out);
  const std::size_t blocks = search_branches(job, found);
  for (std::size_t i = 0; i < blocks; ++i) sift(job, found[i], before, out);
  if (spare >= 0) return;
  if (start) offer_start(job, before, out);
  if (general) return offer_roots(job, before, out);
  find_twins(job, before, out);
}

/// Improves near solutions on the true arm and sifts them.
void InverseKinematics::Arm::offer(BranchJob& job, std::span<const AxisValues> states, std::size_t before,
                                   Gathered& out) const noexcept {
  job.all_move = true;
  job.worth_polishing = sliding ? 10 : 1;
  job.patience = 8;
  Branches branches;
  for (std::size_t from = 0; from < states.size(); from += kBranches) {
    for (std::size_t k = 0; k < kBranches; ++k) {
      const AxisValues& state = states[std::min(from + k, states.size() - 1)];
      for (std::size_t i = 0; i < geometry.count; ++i) branches.value[i][k] = state[i];
    }
    branches.free = 0;
    polish_branches(job, branches);
    sift(job, branches, before, out);
  }
}

void InverseKinematics::Arm::offer_alone(const BranchJob& job, const AxisValues& state,
                                         Gathered& out) const noexcept {
  BranchJob nearly = job;
  offer(nearly, {&state, 1}, out.count, out);
}

/// The nearest solution along curves that pass through closed forms of the arm with one axis fixed.
void InverseKinematics::Arm::offer_dips(const BranchJob& job, const Pose& target,
                                        std::span<const double> seed, Gathered& out) const noexcept {
  const Pose pose{target.position, normalized(target.rotation)};
  AxisValues best;
  if (curves && curves->nearest_here(pose, seed, best)) offer_alone(job, best, out);
  if (out.count > 0) return;
  std::array<AxisValues, SpareEnd::kMostDips> states;
  static_assert(SpareEnd::kMostDips == SrsArm::kMostDips);
  const std::size_t count =
      srs ? srs->dips(job.target, job.near, states) : end->dips(pose, seed.data(), states);
  if (curves && curves->nearest_from(pose, seed, {states.data(), count}, best)) offer_alone(job, best, out);
  for (std::size_t k = 0; k < count && out.count == 0; ++k) offer_alone(job, states[k], out);
}

/// The points nearest to the seed on the curves of joint states that reach the pose; if more than the nearest
/// is wanted, states all along them. False if others may well be nearer.
bool InverseKinematics::Arm::offer_slides(const BranchJob& job, const Pose& target,
                                          std::span<const double> seed, bool nearest_only,
                                          Gathered& out) const noexcept {
  const Pose pose{target.position, normalized(target.rotation)};
  std::array<AxisValues, SelfMotion::kMost> states;
  bool doubtful = false;
  const std::size_t count = curves->nearest(pose, seed, states, doubtful);
  for (std::size_t k = 0; k < count && (out.count == 0 || !nearest_only); ++k)
    offer_alone(job, states[k], out);
  if (nearest_only) return !doubtful && out.count > 0;
  // Some of them repeat others.
  std::array<AxisValues, IkSolutions::kCapacity + 16> all;
  BranchJob nearly = job;
  offer(nearly, {all.data(), curves->spread(pose, seed, all)}, 0, out);
  return out.count > 0;
}

/// All roots of the polynomial of degree 16.
void InverseKinematics::Arm::offer_roots(BranchJob& job, std::size_t before, Gathered& out) const noexcept {
  std::array<GeneralSix::State, GeneralSix::kMost> roots;
  std::array<AxisValues, 2 * GeneralSix::kMost> states;
  job.worth_polishing = 1;
  job.patience = 8;
  if (algebraic()) around_seed(job, before, out);
  if (algebraic() && start) offer_start(job, before, out);
  std::size_t count = 0;
  for (const GeneralSix* six : {general.get(), general_too.get()}) {
    if (!six) continue;
    const std::size_t more = six->solve(job.target, roots);
    for (std::size_t k = 0; k < more; ++k, ++count)
      std::copy(roots[k].begin(), roots[k].end(), states[count].begin());
  }
  offer(job, {states.data(), count}, before, out);
  find_twins(job, before, out);
}

/// Descends from the seed and from states close to it.
void InverseKinematics::Arm::around_seed(const BranchJob& job, std::size_t before,
                                         Gathered& out) const noexcept {
  Branches branches;
  for (std::size_t i = 0; i < geometry.count; ++i)
    for (std::size_t k = 0; k < kBranches; ++k)
      branches.value[i][k] = job.seed[i] + 0.02 * std::sin(static_cast<double>(k * (i + 1)));
  branches.free = 0;
  polish_branches(job, branches);
  sift(job, branches, before, out);
}

/// True if two solutions are the same, or members of one family within tolerances.
bool InverseKinematics::Arm::same(const BranchJob& job, const AxisValues& a, const AxisValues& b,
                                  bool crowded) const noexcept {
  const double change = largest_change(a, b, geometry.count);
  if (change < kSameSolution) return true;
  if (change > kSameFamily) return false;
  BranchJob between = job;
  between.limits = nullptr;
  between.worth_polishing = kNearly;
  between.most_steps = crowded ? 3 : 0;
  Branches middle;
  for (std::size_t i = 0; i < geometry.count; ++i)
    std::fill(middle.value[i], middle.value[i] + kBranches, 0.5 * (a[i] + b[i]));
  polish_branches(between, middle);
  if (middle.position_error2[0] > settings.position_tolerance * settings.position_tolerance ||
      middle.orientation_error2[0] > settings.orientation_tolerance * settings.orientation_tolerance)
    return false;
  double moved = 0;
  for (std::size_t i = 0; i < geometry.count; ++i)
    moved = std::max(moved, std::abs(std::remainder(middle.value[i][0] - 0.5 * (a[i] + b[i]), kTurn)));
  return moved < 0.1 * change;
}

/// Judges the result of each branch. Candidates from index `since` on belong to the same question.
void InverseKinematics::Arm::sift(const BranchJob& job, const Branches& branches, std::size_t since,
                                  Gathered& out) const noexcept {
  const std::size_t n = geometry.count;
  const double position2 = settings.position_tolerance * settings.position_tolerance;
  const double orientation2 = settings.orientation_tolerance * settings.orientation_tolerance;
  for (std::size_t k = 0; k < kBranches; ++k) {
    Candidate one;
    one.position2 = branches.position_error2[k];
    one.orientation2 = branches.orientation_error2[k];
    one.exact = one.position2 <= position2 && one.orientation2 <= orientation2;
    const double size = one.position2 / (lanes.size * lanes.size) + one.orientation2;
    if (!one.exact && !(size < 1.02 * out.nearest_size) && !(size < kNearly * kNearly)) continue;
    const bool inside = (branches.inside >> k & 1u) != 0;
    out.beyond_limits |= one.exact && !inside;
    for (std::size_t i = 0; i < n; ++i) one.value[i] = branches.value[i][k];
    if (!inside) {
      if (one.exact && !out.at_limit) put_on_limits(job, one.value, since, out);
      continue;
    }
    if (!one.exact && size < kNearly * kNearly && out.nearly_count < out.nearly.size())
      out.nearly[out.nearly_count++] = one.value;
    one.distance2 = branches.distance2[k];
    one.singular = (branches.free >> k & 1u) != 0;
    if (!one.exact) {
      if (!(size < 1.02 * out.nearest_size)) continue;
      // Equally near to the pose: keep the one nearer to the seed.
      if (size > 0.98 * out.nearest_size && one.distance2 > out.nearest.distance2) continue;
      out.nearest = one;
      out.nearest_size = size;
      continue;
    }
    bool known_already = false;
    for (std::size_t j = since; j < out.count && !known_already; ++j) {
      Candidate& other = out.all[j];
      known_already = same(job, other.value, one.value, out.count > kCrowd);
      if (!known_already) continue;
      // A descent to where solutions meet can end early: keep the one with more digits.
      const bool alike = largest_change(other.value, one.value, n) < kSharper;
      const bool sharper = one.position2 + one.orientation2 < 0.01 * (other.position2 + other.orientation2);
      if (alike ? sharper : out.nearest_stays && one.distance2 < other.distance2) other = one;
    }
    if (!known_already) out.take(one);
  }
}

void InverseKinematics::Arm::gather(const Pose& target, std::span<const double> seed, bool nearest_only,
                                    Gathered& out) const noexcept {
  for (std::size_t i = 0; i < geometry.count; ++i) out.seed[i] = seed[geometry.axes[i].joint];
  AxisValues at = out.seed;
  BranchJob job;
  job.arm = &lanes;
  job.target = {rotation_of(normalized(target.rotation)), target.position};
  job.to_arm = to_arm;
  job.seed = at.data();
  job.limits = &limits;
  job.near = out.seed.data();
  job.worth_polishing = worth_polishing;
  out.spread = spare < 0;
  if (formed() && spare < 0) solve_at(job, form, wary, out);
  if (formed() && spare >= 0) {
    if (nearest_only && (srs || end)) offer_dips(job, target, seed, out);
    bool sure = false;
    if (slides_along() && curves && (nearest_only || searched(known.family)))
      sure = offer_slides(job, target, seed, nearest_only, out) || searched(known.family);
    if (out.count == 0 || (slides_along() && curves && !sure)) sample(job, at, nearest_only, out);
  }
  if (numeric && out.count == 0) iterate(target, seed, nearest_only && !formed(), out);
}

/// The numeric solver: for arms without another method all that it finds, for others what they lack.
void InverseKinematics::Arm::iterate(const Pose& target, std::span<const double> seed, bool nearest_only,
                                     Gathered& out) const noexcept {
  IkSolution one;
  const bool beyond = norm(target.position - described->reach_center()) >
                      described->reach_bound() + settings.position_tolerance;
  if (beyond) {
    numeric->track(target, seed, one);
    return take(one, out);
  }
  if (nearest_only || (formed() && geometry.count >= 6)) {
    out.beyond_limits |= numeric->solve(target, seed, one) == IkOutcome::limits;
    return take(one, out);
  }
  IkSolutions all;
  out.beyond_limits |= numeric->solve_all(target, seed, all) == IkOutcome::limits;
  for (const IkSolution& other : all) take(other, out);
}

void InverseKinematics::Arm::take(const IkSolution& from, Gathered& out) const noexcept {
  Candidate one;
  one.position2 = from.position_error * from.position_error;
  one.orientation2 = from.orientation_error * from.orientation_error;
  one.distance2 = from.distance * from.distance;
  one.exact = from.exact;
  one.singular = from.singular;
  for (std::size_t i = 0; i < geometry.count; ++i) one.value[i] = from.q[geometry.axes[i].joint];
  if (from.exact) return out.take(one);
  const double size = one.position2 / (lanes.size * lanes.size) + one.orientation2;
  if (!(size < out.nearest_size)) return;
  out.nearest = one;
  out.nearest_size = size;
}

/// Tries the spare axis at the seed's value and at values over its whole range. If only the nearest solution
/// is wanted, then at ever closer values around the best one.
void InverseKinematics::Arm::sample(BranchJob& job, AxisValues& at, bool nearest_only,
                                    Gathered& out) const noexcept {
  const auto k = static_cast<std::size_t>(spare);
  const double span = geometry.axes[k].slides ? 4 * lanes.size : kTurn;
  const double least = std::max(limits.lower[k], out.seed[k] - span / 2),
               most = std::min(limits.upper[k], least + span);
  const double cell = (most - least) / std::max(1, settings.samples);
  double missed_least = 1e300, center = least;
  const auto look_at = [&](double value) {
    const Candidate nearest = out.nearest;
    const double size = out.nearest_size;
    out.nearest_size = 1e300;
    at[k] = std::clamp(value, least, most);
    const SixAxisClass six = seen_as(locked(geometry, k, at[k]), known.family, known.from_tool);
    solve_at(job, form_of(six), form_of(six, true), out);
    if (out.nearest_size < missed_least) missed_least = out.nearest_size, center = at[k];
    if (out.nearest_size < size) return;
    out.nearest = nearest;
    out.nearest_size = size;
  };
  look_at(out.seed[k]);
  for (int i = 0; i < settings.samples; ++i) look_at(least + (i + 0.5) * cell);
  // If limits leave only a small part of the range: looks more closely before it gives up.
  constexpr int kCloser = 4;
  for (int i = 0; out.count == 0 && i < kCloser * settings.samples; ++i) look_at(least + i * cell / kCloser);
  // A nearly stretched arm may reach the pose in a small part of the range only: narrows around the smallest
  // error, which is not smooth beside singularities.
  constexpr int kNarrowings = 6, kEachSide = 6;
  constexpr double kNarrower = 0.4;
  double aside = cell / 8;
  for (int i = 0; i < kNarrowings && out.count == 0 && missed_least < kNearly * kNearly; ++i) {
    const double middle = center;
    for (int j = -kEachSide; j <= kEachSide && out.count == 0; ++j) look_at(middle + j * aside);
    aside *= kNarrower;
  }
  if (!nearest_only || out.count == 0) return;
  constexpr int kHalvings = 14;
  double step = cell / 2;
  for (int i = 0; i < kHalvings; ++i, step /= 2) {
    const double best = out.best().value[k];
    look_at(best - step);
    look_at(best + step);
  }
}

void InverseKinematics::Arm::write(const Candidate& from, std::span<const double> seed,
                                   IkSolution& to) const noexcept {
  std::copy(seed.begin(), seed.end(), to.q.begin());
  for (std::size_t i = 0; i < geometry.count; ++i) to.q[geometry.axes[i].joint] = from.value[i];
  to.position_error = std::sqrt(from.position2);
  to.orientation_error = std::sqrt(from.orientation2);
  to.distance = std::sqrt(from.distance2);
  to.exact = from.exact;
  to.singular = from.singular;
}

InverseKinematics::InverseKinematics(const Chain& chain, IkSettings settings) {
  auto arm = std::make_unique<Arm>();
  arm->settings = std::move(settings);
  arm->described = chain;
  arm->geometry.count = 0;
  std::string why_not;
  if (const auto geometry = geometry_of(chain, why_not)) {
    arm->geometry = *geometry;
    arm->read(chain);
    arm->find_form();
    arm->find_start();
  } else {
    arm->report = "no closed form: " + why_not;
  }
  const bool closed =
      arm->formed() && arm->spare < 0 && !searched(arm->known.family) && !arm->algebraic() && !arm->weak;
  if (!chain.axes().empty()) arm->moves.emplace(chain, arm->move_settings());
  // Calibrated arms of few axes: the nearest solutions of their six axes may lead nowhere.
  const bool few = arm->geometry.count < 6 && !arm->sliding && !arm->known.exact();
  if (!closed || few) arm->add_numeric();
  const bool slides = arm->slides_along();
  if (slides || arm->srs || arm->end)
    arm->curves = SelfMotion::of(arm->numeric->core(), arm->geometry, arm->limits,
                                 searched(arm->known.family), !slides);
  if (slides && arm->curves)
    arm->report += "; the nearest by sliding along curves of states that leave the pose alone";
  arm_ = std::move(arm);
}

InverseKinematics::InverseKinematics(const description::RobotModel& model, int tip, IkSettings settings)
    : InverseKinematics(Chain(model, tip), std::move(settings)) {}

InverseKinematics::~InverseKinematics() = default;
InverseKinematics::InverseKinematics(InverseKinematics&&) noexcept = default;
InverseKinematics& InverseKinematics::operator=(InverseKinematics&&) noexcept = default;

InverseKinematics::operator bool() const noexcept {
  return arm_->formed();
}
IkWay InverseKinematics::way() const noexcept {
  if (!arm_->solvable() && !arm_->numeric) return IkWay::none;
  if (!arm_->formed()) return IkWay::descent;
  if (arm_->spare >= 0) return IkWay::spare_axis;
  if (arm_->algebraic()) return IkWay::algebra;
  return searched(arm_->known.family) ? IkWay::search : IkWay::closed_form;
}
ArmFamily InverseKinematics::family() const noexcept {
  return arm_->known.family;
}
bool InverseKinematics::complete() const noexcept {
  return (way() == IkWay::closed_form && !arm_->weak) || way() == IkWay::algebra;
}
const std::string& InverseKinematics::report() const noexcept {
  return arm_->report;
}
const Chain& InverseKinematics::chain() const noexcept {
  return *arm_->described;
}
const IkSettings& InverseKinematics::settings() const noexcept {
  return arm_->settings;
}

IkOutcome InverseKinematics::Arm::solve_slowly(const Pose& target, std::span<const double> seed,
                                               IkSolution& out) const noexcept {
  out = {};
  std::copy(seed.begin(), seed.begin() + static_cast<std::ptrdiff_t>(std::min(seed.size(), out.q.size())),
            out.q.begin());
  if (!solvable()) {
    if (!numeric) return IkOutcome::immovable;
    return numeric->solve(target, seed, out);
  }
  if (!accepts(target, seed)) return IkOutcome::malformed;
  Gathered found;
  gather(target, seed, true, found);
  if (found.count == 0) {
    if (found.nearest_size < 1e299) write(found.nearest, seed, out);
    return found.beyond_limits ? IkOutcome::limits : IkOutcome::unreachable;
  }
  write(found.best(), seed, out);
  return IkOutcome::solved;
}

IkOutcome InverseKinematics::Arm::solve_all_slowly(const Pose& target, std::span<const double> seed,
                                                   IkSolutions& out) const noexcept {
  out.count = 0;
  if (!solvable()) {
    if (!numeric) return IkOutcome::immovable;
    return numeric->solve_all(target, seed, out);
  }
  if (!accepts(target, seed)) return IkOutcome::malformed;
  Gathered found;
  gather(target, seed, false, found);
  std::array<std::uint8_t, IkSolutions::kCapacity> order;
  for (std::size_t k = 0; k < found.count; ++k) {
    std::size_t at = k;
    for (; at > 0 && found.all[order[at - 1]].distance2 > found.all[k].distance2; --at)
      order[at] = order[at - 1];
    order[at] = static_cast<std::uint8_t>(k);
  }
  for (std::size_t k = 0; k < found.count; ++k) write(found.all[order[k]], seed, out.all[k]);
  out.count = found.count;
  if (found.count > 0) return IkOutcome::solved;
  return found.beyond_limits ? IkOutcome::limits : IkOutcome::unreachable;
}

IkOutcome InverseKinematics::solve(const Pose& target, std::span<const double> seed,
                                   IkSolution& out) const noexcept {
  QuickAnswers found;
  if (!arm_->takes_quick(seed) || !solve_quickly(arm_->quick, arm_->lanes, target, seed.data(), found) ||
      found.good == 0) {
    if (arm_->start && arm_->solve_from_start(target, seed, out)) return IkOutcome::solved;
    return arm_->solve_slowly(target, seed, out);
  }
  std::size_t best = static_cast<std::size_t>(std::countr_zero(found.good));
  for (std::uint32_t rest = found.good & (found.good - 1); rest != 0; rest &= rest - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(rest));
    best = found.distance[k] < found.distance[best] ? k : best;
  }
  arm_->write_quick(found, best, seed, out);
  return IkOutcome::solved;
}

IkOutcome InverseKinematics::solve_all(const Pose& target, std::span<const double> seed,
                                       IkSolutions& out) const noexcept {
  QuickAnswers found;
  if (!arm_->takes_quick(seed) || !solve_quickly(arm_->quick, arm_->lanes, target, seed.data(), found) ||
      found.good == 0)
    return arm_->solve_all_slowly(target, seed, out);
  // Sorts without branches, which the processor cannot predict: each index is the number of nearer ones.
  std::array<std::uint8_t, kBranches> lane;
  std::array<std::uint8_t, kBranches> place{};
  std::array<double, kBranches> distance;
  std::size_t n = 0;
  for (std::uint32_t rest = found.good; rest != 0; rest &= rest - 1, ++n) {
    lane[n] = static_cast<std::uint8_t>(std::countr_zero(rest));
    distance[n] = found.distance[lane[n]];
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const bool nearer = distance[j] < distance[i];
      place[i] = static_cast<std::uint8_t>(place[i] + nearer);
      place[j] = static_cast<std::uint8_t>(place[j] + !nearer);
    }
  for (std::size_t i = 0; i < n; ++i) arm_->write_quick(found, lane[i], seed, out.all[place[i]]);
  out.count = n;
  return IkOutcome::solved;
}

std::size_t InverseKinematics::solve_batch(std::span<const Pose> targets, std::span<const double> seed,
                                           std::span<IkSolution> out,
                                           std::span<IkOutcome> outcomes) const noexcept {
  std::size_t solved = 0;
  const bool quick = arm_->takes_quick(seed);
  std::array<std::uint8_t, 32> good{};
  constexpr std::size_t kAtOnce = good.size() * kBranches;
  for (std::size_t first = 0; first < targets.size(); first += kAtOnce) {
    const std::size_t n = std::min(kAtOnce, targets.size() - first);
    if (quick)
      solve_together(arm_->quick, arm_->lanes, targets.subspan(first, n), seed, out.subspan(first, n), good);
    for (std::size_t k = 0; k < n; ++k) {
      IkOutcome& outcome = outcomes[first + k];
      outcome = IkOutcome::solved;
      if ((good[k / kBranches] >> k % kBranches & 1u) == 0)
        outcome = solve(targets[first + k], seed, out[first + k]);
      solved += outcome == IkOutcome::solved;
    }
  }
  return solved;
}

}  // namespace polyarm::ik
