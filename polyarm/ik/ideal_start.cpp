// The fast path of slightly non-ideal arms: the branches of the ideal arm, improved on the true arm.
#include <algorithm>
#include <cmath>

#include "polyarm/ik/ik_arm.hpp"
#include "polyarm/kinematics/random.hpp"

namespace polyarm::ik {

namespace {

constexpr double kOfDeviation = 30;     // errors of the ideal arm's answers on the true arm, in deviations
constexpr double kMostError = 0.1;      // m and rad: a descent from farther off is not worth it
constexpr double kClose = 0.05;         // m and rad: a descent that ends this close may hide a solution
constexpr double kCloseOfFewer = 1e-3;  // the same for five axes and fewer, which come close to most poses
constexpr double kSameBranch = 1e-3;    // rad
constexpr double kSeedNear = 0.3;       // in units of the arm's size, and rad: a descent from the seed is
                                        // worth it
constexpr double kHere = 0.1;           // weighted rad: no other solution is nearer than one this near
constexpr int kPatientFromSeed = 14;    // steps
constexpr double kAside = 0.1;          // rad: how far from a doubtful branch another solution may be
constexpr int kPatient = 6;             // steps

double squared(double v) {
  return v * v;
}

bool alike(const Branches& a, std::size_t j, std::size_t k, std::size_t axes) {
  for (std::size_t i = 0; i < axes; ++i)
    if (std::abs(a.value[i][j] - a.value[i][k]) > kSameBranch) return false;
  return true;
}

bool is_near(const Pose& a, const Pose& b, double size) {
  const Quaternion &p = a.rotation, &q = b.rotation;
  const double cosine = std::abs(p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w);
  return norm(a.position - b.position) < kSeedNear * size && cosine > 1 - squared(kSeedNear) / 8;
}

/// True if another solution may be nearer to the seed than the best one.
bool hides_nearer(const NearestBranch& best) {
  const double least = std::max(0.0, std::sqrt(best.doubt2) - kAside);
  return least * least < best.distance2;
}

}  // namespace

IdealStart InverseKinematics::Arm::start_of(const SixAxisClass& seen, const std::array<int, 6>& axes) const {
  return {form_of(seen), form_of(seen, true), axes,
          seen.worst_gap + seen.worst_angle * std::max(1.0, lanes.size)};
}

void InverseKinematics::Arm::find_start() {
  const auto slides = [](const JointAxis& axis) { return axis.slides; };
  const auto behind = geometry.axes.begin() + static_cast<std::ptrdiff_t>(geometry.count);
  if (spare >= 0 || sliding || geometry.count < 3 || geometry.count > 6 ||
      std::any_of(geometry.axes.begin(), behind, slides))
    return;
  if (known.family != ArmFamily::none && !searched(known.family)) {
    if (!known.exact()) start = start_of(known, to_arm);
    return;
  }
  if (geometry.count < 6) return find_start_of_fewer();
  const SixAxisClass seen = classify(geometry, kWidestStart);
  if (seen.family == ArmFamily::none || searched(seen.family) || seen.exact()) return;
  std::array<int, 6> axes{0, 1, 2, 3, 4, 5};
  if (seen.from_tool) std::reverse(axes.begin(), axes.end());
  start = start_of(seen, axes);
}

/// For a number of states within limits: how many poses are solved from the start.
int InverseKinematics::Arm::states_found_from_start(int states) const noexcept {
  Random random(9);
  JointValues q{}, seed{};
  int out = 0;
  for (int i = 0; i < states; ++i) {
    for (std::size_t j = 0; j < joints; ++j) {
      q[j] = random_value(*described, j, random);
      seed[j] = random_value(*described, j, random);
    }
    IkSolution one;
    out += solve_from_start(described->forward({q.data(), joints}), {seed.data(), joints}, one);
  }
  return out;
}

/// Takes exact solutions within limits, and notes where another may exist.
void InverseKinematics::Arm::compare(const Branches& found, NearestBranch& best) const noexcept {
  const double position2 = squared(settings.position_tolerance),
               orientation2 = squared(settings.orientation_tolerance);
  const double close2 = squared(geometry.count < 6 ? kCloseOfFewer : kClose);
  std::uint32_t exact = 0, doubtful = found.free;
  for (std::size_t k = 0; k < kBranches; ++k) {
    const double p2 = found.position_error2[k], o2 = found.orientation_error2[k];
    if (p2 <= position2 && o2 <= orientation2)
      exact |= 1u << k;
    else if (std::max(p2, o2) < close2)
      doubtful |= 1u << k;
  }
  for (std::size_t k = 0; k < kBranches; ++k) {
    if (!(exact >> k & 1)) continue;
    // Two branches have merged: the other solution may be elsewhere.
    for (std::size_t j = 0; j < k; ++j)
      if ((exact >> j & 1) && alike(found, j, k, geometry.count)) doubtful |= 1u << k;
    if (!(found.inside >> k & 1) || !(found.distance2[k] < best.distance2)) continue;
    best.distance2 = found.distance2[k];
    best.position2 = found.position_error2[k];
    best.orientation2 = found.orientation_error2[k];
    for (std::size_t i = 0; i < geometry.count; ++i) best.value[i] = found.value[i][k];
  }
  for (std::size_t k = 0; k < kBranches; ++k)
    if (doubtful >> k & 1) best.doubt2 = std::min(best.doubt2, found.distance2[k]);
}

/// Descends from the seed if that is worth it, so that a small step of the target stays on its branch.
void InverseKinematics::Arm::descend_from_seed(BranchJob job, NearestBranch& best) const noexcept {
  Branches at;
  for (std::size_t i = 0; i < geometry.count; ++i) std::fill_n(at.value[i], kBranches, job.seed[i]);
  at.free = 0;
  job.worth_polishing = 2 * kSeedNear;
  job.patience = kPatientFromSeed;
  polish_branches(job, at);
  compare(at, best);
}

/// Takes the solution of a descent from a nearby seed, else the nearest improved branch of the ideal arm. If
/// one of them may hide a nearer solution, also looks at branches beside singularities. False if none is
/// exact.
bool InverseKinematics::Arm::solve_from_start(const Pose& target, std::span<const double> seed,
                                              IkSolution& out) const noexcept {
  if (!accepts(target, seed)) return false;
  AxisValues near;
  for (std::size_t i = 0; i < geometry.count; ++i) near[i] = seed[geometry.axes[i].joint];
  BranchJob job;
  job.form = &start->strict;
  job.arm = &lanes;
  job.target = {rotation_of(normalized(target.rotation)), target.position};
  job.to_arm = start->to_arm;
  job.seed = job.near = near.data();
  job.limits = &limits;
  job.worth_polishing = std::max(geometry.count < 5 ? worth_polishing : 0.0,
                                 std::min(kMostError, kClose + kOfDeviation * start->deviation));
  Branches found;
  NearestBranch best;
  if (is_near(described->forward(seed), {target.position, normalized(target.rotation)}, lanes.size)) {
    descend_from_seed(job, best);
    if (best.distance2 < squared(kHere)) {
      write({best.value, best.position2, best.orientation2, best.distance2, true, false}, seed, out);
      return true;
    }
  }
  solve_branches(job, found);
  compare(found, best);
  if (hides_nearer(best)) {
    job.patience = kPatient;
    found.free = 0;
    polish_branches(job, found);
    compare(found, best);
    job.form = &start->wary;
    solve_branches(job, found);
    compare(found, best);
  }
  if (!(best.distance2 < 1e300)) return false;
  const Candidate one{best.value, best.position2, best.orientation2, best.distance2, true, false};
  write(one, seed, out);
  return true;
}

/// For arms that are searched or solved by algebra: adds the branches of the ideal arm.
void InverseKinematics::Arm::offer_start(BranchJob job, std::size_t before, Gathered& out) const noexcept {
  job.to_arm = start->to_arm;
  job.worth_polishing = kMostError;
  job.patience = 14;
  Branches found;
  for (const SixAxisForm* ideal : {&start->strict, &start->wary}) {
    job.form = ideal;
    solve_branches(job, found);
    sift(job, found, before, out);
  }
}

}  // namespace polyarm::ik
