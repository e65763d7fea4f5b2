// Slightly non-ideal arms near poses where the ideal arm has a continuous family of solutions. The true arm
// keeps a few members of it, up to about six, anywhere along the family.
#include <algorithm>
#include <cmath>

#include "polyarm/ik/ik_arm.hpp"

namespace polyarm::ik {

namespace {

constexpr int kAround = 24;
constexpr double kCell = kTurn / kAround;  ///< between values of a free axis
constexpr double kNear = 1.2 * kCell;
constexpr double kFollows = 0.1;  ///< rad
constexpr int kRelaxing = 4;
/// Distance between solutions that meet (Edge::part), in deviations of the true arm from the ideal one.
constexpr double kParted = 12;
constexpr double kWider = 30;  ///< the same where branches come close without meeting
/// Lower bound where a descent strayed: 0.1 rad from wrist singularities.
constexpr double kEdgeOfStrayed = 0.01;
constexpr double kLeadsBack = 0.45;  ///< of a parabola: half the distance or less leads back to the known
                                     ///< root
constexpr double kBeside = 1e-4;     ///< rad or m beyond a limit

/// Bit mask of the form's free axes in each branch: those that keep any value of the seed.
using FreeAxes = std::array<std::uint32_t, kBranches>;

void add(WaitingStates& waiting, const Branches& from, std::size_t k, std::size_t axes) {
  for (std::size_t i = 0; i < axes; ++i) waiting.branches.value[i][waiting.count] = from.value[i][k];
  ++waiting.count;
}

double turned_apart(double a, double b) {
  return std::abs(std::remainder(a - b, kTurn));
}

FreeAxes free_axes(BranchJob job, std::size_t axes) {
  constexpr double kAside[] = {0.1, 0.8};
  FreeAxes out;
  out.fill(0x3fu);
  AxisValues seed{};
  for (const double aside : kAside) {
    for (std::size_t i = 0; i < axes; ++i) seed[i] = job.seed[i] + aside;
    job.seed = seed.data();
    Branches found;
    solve_branches(job, found);
    for (std::size_t k = 0; k < kBranches; ++k)
      for (int i = 0; i < 6; ++i) {
        const int axis = job.to_arm[static_cast<std::size_t>(i)];
        const bool follows =
            (found.free >> k & 1u) != 0 && axis >= 0 &&
            turned_apart(found.value[axis][k], seed[static_cast<std::size_t>(axis)]) < kFollows;
        if (!follows) out[k] &= ~(1u << i);
      }
  }
  return out;
}

}  // namespace

/// If descents move the ideal arm's solutions only a little, they are the solutions of the true arm. Else
/// folds and families are near, where the true arm has others.
void InverseKinematics::Arm::solve_nearly_ideal(BranchJob& job, const SixAxisForm& strict_form,
                                                const SixAxisForm& tolerant_form, Gathered& out) const noexcept {
  const std::size_t before = out.count;
  Branches branches;
  SixAxisForm telling;
  if (spare >= 0) telling = tolerant_form_of(strict_form);
  job.form = spare >= 0 ? &telling : &first;
  job.ideal = known.worst_gap + known.worst_angle * std::max(1.0, lanes.size);
  solve_branches(job, branches);
  job.ideal = 0;
  const bool strayed = branches.strayed != 0;
  if (branches.free == 0 && !strayed) return sift(job, branches, before, out);
  job.patience = 14;
  around_seed(job, before, out);
  job.form = &strict_form;
  if (branches.free != 0)
    solve_branches(job, branches);
  else
    polish_branches(job, branches);
  sift(job, branches, before, out);
  job.form = &tolerant_form;
  solve_branches(job, branches);
  sift(job, branches, before, out);
  if (spare >= 0) return;
  along_families(job, strayed ? kEdgeOfStrayed : 0, before, out);
  find_twins(job, before, out);
}

/// Where solutions meet, joint values are known to half the digits, and a value on a limit may seem to
/// violate it. Tries the same state with these axes on their limits, if the others can compensate.
void InverseKinematics::Arm::put_on_limits(const BranchJob& asked, const AxisValues& state,
                                           std::size_t before, Gathered& out) const noexcept {
  BranchJob job = asked;
  Branches branches;
  for (std::size_t i = 0; i < geometry.count; ++i) {
    double value = state[i];
    for (const double limit : {limits.lower[i], limits.upper[i]}) {
      const double beyond = geometry.axes[i].slides ? value - limit : std::remainder(value - limit, kTurn);
      if (!(std::abs(beyond) < kBeside) || (value >= limits.lower[i] && value <= limits.upper[i])) continue;
      value = limit;
      for (int& axis : job.to_arm)
        if (axis == static_cast<int>(i)) axis = -1;
    }
    if (value < limits.lower[i] || value > limits.upper[i]) return;
    for (std::size_t k = 0; k < kBranches; ++k) branches.value[i][k] = value;
  }
  job.all_move = false;
  branches.free = 0;
  polish_branches(job, branches);
  out.at_limit = true;
  sift(job, branches, before, out);
  out.at_limit = false;
}

/// When full, evicts the one of the two closest candidates that is farther from the seed.
void Gathered::replace_most_alike(const Candidate& one) noexcept {
  const auto apart = [](const Candidate& a, const Candidate& b) {
    double sum = 0;
    for (std::size_t i = 0; i < 6; ++i) sum += (a.value[i] - b.value[i]) * (a.value[i] - b.value[i]);
    return sum;
  };
  const auto at = [&](std::size_t k) -> const Candidate& { return k < count ? all[k] : one; };
  double least = 1e300;
  std::size_t goes = count;
  for (std::size_t i = 0; i <= count; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double gap = apart(at(i), at(j));
      if (!(gap < least)) continue;
      least = gap;
      goes = at(i).distance2 < at(j).distance2 ? j : i;
    }
  if (goes < count) all[goes] = one;
}

/// Descends from all waiting states.
void InverseKinematics::Arm::descend_all(const BranchJob& asked, WaitingStates& waiting, std::size_t before,
                                         Gathered& out) const noexcept {
  if (waiting.count == 0) return;
  for (std::size_t k = waiting.count; k < kBranches; ++k)
    for (std::size_t i = 0; i < geometry.count; ++i)
      waiting.branches.value[i][k] = waiting.branches.value[i][0];
  BranchJob job = asked;
  job.good_enough = 1e-13;
  waiting.branches.free = 0;
  polish_branches(job, waiting.branches);
  sift(job, waiting.branches, before, out);
  waiting.count = 0;
}

/// Walks along each family of the ideal arm at this pose; nearly singular counts as singular.
void InverseKinematics::Arm::along_families(const BranchJob& asked, double least_edge, std::size_t before,
                                            Gathered& out) const noexcept {
  BranchJob job = asked;
  SixAxisForm loose = wary;
  loose.wary = false;
  loose.edge = std::clamp((out.nearly_count > 0 ? kWider : 1) * kParted *
                              std::max(known.worst_gap / lanes.size, known.worst_angle),
                          least_edge, 0.1);
  loose.edge_slope = std::sqrt(loose.edge / (1 - loose.edge));
  loose.least_sine = std::max(loose.least_sine, 1.2 * std::sqrt(loose.edge));
  job.form = &loose;
  job.limits = nullptr;
  job.worth_polishing = 0;
  const FreeAxes free = free_axes(job, geometry.count);
  for (std::size_t k = 0; k < kBranches; ++k) {
    if (free[k] == 0 || std::find(free.begin(), free.begin() + k, free[k]) != free.begin() + k) continue;
    std::uint32_t alike = 0;
    for (std::size_t b = k; b < kBranches; ++b) alike |= free[b] == free[k] ? 1u << b : 0u;
    along_family(job, asked, free[k], alike, before, out);
  }
}

/// Fixes the free axes (at most two) at values all around while the others descend as near to the pose as
/// they can. Where a step of all axes from there stays close, descends to the end. `axes` (of the form) and
/// `branches_of_it` are bit masks.
void InverseKinematics::Arm::along_family(BranchJob job, const BranchJob& asked, std::uint32_t axes,
                                          std::uint32_t branches_of_it, std::size_t before,
                                          Gathered& out) const noexcept {
  AxisValues seed{};
  std::copy(job.seed, job.seed + geometry.count, seed.begin());
  BranchJob stepping = whatever_the_error(job, 1), relaxing = whatever_the_error(job, kRelaxing);
  std::array<std::size_t, 2> held{};
  std::size_t dimensions = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    if ((axes >> i & 1u) == 0 || dimensions == held.size()) continue;
    held[dimensions++] = static_cast<std::size_t>(job.to_arm[i]);
    relaxing.to_arm[i] = -1;
  }
  WaitingStates waiting;
  for (int cell = 0; cell < (dimensions == 2 ? kAround * kAround : kAround); ++cell) {
    AxisValues at = seed;
    at[held[0]] += cell % kAround * kCell;
    if (dimensions == 2) at[held[1]] += cell / kAround * kCell;
    job.seed = relaxing.seed = stepping.seed = at.data();
    Branches branches;
    solve_branches(job, branches);
    branches.free = 0;
    polish_branches(relaxing, branches);
    const Branches relaxed = branches;
    polish_branches(stepping, branches);
    for (std::size_t b = 0; b < kBranches; ++b) {
      bool near = (branches_of_it >> b & 1u) != 0;
      for (std::size_t d = 0; d < dimensions; ++d)
        near &= turned_apart(branches.value[held[d]][b], relaxed.value[held[d]][b]) < kNear;
      if (!near) continue;
      add(waiting, branches, b, geometry.count);
      if (waiting.count == kBranches) descend_all(asked, waiting, before, out);
    }
  }
  descend_all(asked, waiting, before, out);
}

/// Near a fold a solution has a twin on the other side; where folds meet it has more.
void InverseKinematics::Arm::find_twins(const BranchJob& asked, std::size_t since,
                                            Gathered& out) const noexcept {
  constexpr std::size_t kMostLookedAt = 24;
  const std::size_t nearly_count = out.nearly_count;
  bool walked = false;
  for (std::size_t from = since, more = 0; from < out.count && from < since + kMostLookedAt; from += more) {
    more = std::min(kBranches, out.count - from);
    LeastMotions flat;
    std::array<AxisValues, kBranches> states;
    for (std::size_t k = 0; k < more; ++k) states[k] = out.all[from + k].value;
    see_motions({states.data(), more}, false, flat);
    if (!walked && known.exact() && *std::min_element(flat.least, flat.least + more) < kFlatCurve) {
      walked = true;
      along_curves(asked, since, out);
    }
    for (std::size_t k = 0; k < more; ++k) search_beside(asked, states[k], flat, k, true, since, out);
  }
  if (nearly_count == 0) return;
  LeastMotions flat;
  see_motions({out.nearly.data(), nearly_count}, false, flat);
  for (std::size_t k = 0; k < nearly_count; ++k)
    search_beside(asked, out.nearly[k], flat, k, false, since, out);
}

/// For up to eight joint states.
void InverseKinematics::Arm::see_motions(std::span<const AxisValues> states, bool both,
                                         LeastMotions& out) const noexcept {
  Branches at;
  for (std::size_t k = 0; k < kBranches; ++k)
    for (std::size_t i = 0; i < geometry.count; ++i) at.value[i][k] = states[k < states.size() ? k : 0][i];
  find_least_motions(lanes, at, both, out);
}

/// In the direction that hardly moves the tool (lane `lane` of `flat`): fixes the axis that moves most at
/// values on either side while the others descend as near to the pose as they can. Where a step of all axes
/// does not lead back to a known solution (`solved`), descends to the end.
void InverseKinematics::Arm::search_beside(const BranchJob& asked, const AxisValues& at,
                                         const LeastMotions& flat, std::size_t lane, bool solved,
                                         std::size_t since, Gathered& out) const noexcept {
  constexpr double kFar = 0.02, kFlat = 0.002, kSteps[] = {3, 10, 40, 150};
  constexpr double kWide[] = {0.03, 0.08, 0.16, 0.35}, kWidest[] = {0.6, 1, 1.5, 2.2};
  constexpr double kFlatter = 1e-4, kOfRoot[] = {1, 2, 4, 8};  // where three solutions meet, their distance
                                                               // grows with the root
  const std::size_t n = geometry.count;
  const double least = flat.least[lane];
  if (least > kFar) return;
  AxisValues way{};
  for (std::size_t i = 0; i < n; ++i) way[i] = flat.way[i][lane];
  std::size_t held = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (std::abs(way[i]) > std::abs(way[held])) held = i;
  const BranchJob stepping = whatever_the_error(asked, 1);
  BranchJob relaxing = whatever_the_error(asked, kRelaxing);
  for (int& axis : relaxing.to_arm)
    if (axis == static_cast<int>(held)) axis = -1;
  relaxing.all_move = false;
  WaitingStates waiting;
  for (int width = 0; width < (least < kFlatter ? 4 : least < kFlat ? 3 : 2); ++width) {
    Branches branches;
    for (std::size_t k = 0; k < kBranches; ++k) {
      const double size = width == 3   ? kOfRoot[k / 2] * std::sqrt(least)
                          : width == 2 ? kWidest[k / 2]
                          : width == 1 ? kWide[k / 2]
                                       : std::clamp(kSteps[k / 2] * least, 1e-4, 0.4);
      const double step = k % 2 ? size : -size;
      for (std::size_t i = 0; i < n; ++i) branches.value[i][k] = at[i] + step * way[i];
    }
    branches.free = 0;
    polish_branches(relaxing, branches);
    const Branches relaxed = branches;
    polish_branches(stepping, branches);
    for (std::size_t k = 0; k < kBranches; ++k) {
      const double there = std::remainder(relaxed.value[held][k] - at[held], kTurn),
                   next = std::remainder(branches.value[held][k] - at[held], kTurn);
      if (std::abs(next / there) > 2 || (solved && next / there < kLeadsBack)) continue;
      add(waiting, branches, k, n);
      if (waiting.count == kBranches) descend_all(asked, waiting, since, out);
    }
  }
  descend_all(asked, waiting, since, out);
}

}  // namespace polyarm::ik
