#include "polyarm/kinematics/inverse_kinematics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/kinematics/closed_form.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kAtLimit = 1e-10;      // rad beyond a limit that are rounding
constexpr double kSameSolution = 1e-6;  // rad: nearer than this is one solution
using AxisValues = std::array<double, ArmGeometry::kMostAxes>;

/// What one branch offers. Without initial values: sixty-four of them would cost more than the solve.
struct Candidate {
  AxisValues value;
  double position2, orientation2;  ///< squares of the errors
  double distance2;                ///< square of the weighted distance from the seed
  bool exact, singular;
};

/// The candidates of one question that are within limits and exact, and the best of the others.
struct Gathered {
  std::array<Candidate, IkSolutions::kCapacity> all;
  std::size_t count = 0;
  Candidate nearest;  ///< to the pose, of those that are not exact
  double nearest_size = 1e300;
  AxisValues seed{};
  bool beyond_limits = false;  ///< something exact was found outside of them

  const Candidate& best() const noexcept {
    std::size_t out = 0;
    for (std::size_t k = 1; k < count; ++k)
      if (all[k].distance2 < all[out].distance2) out = k;
    return all[out];
  }
  void take(const Candidate& one) noexcept {
    if (count < all.size()) {
      all[count++] = one;
      return;
    }
    const auto further = [](const Candidate& a, const Candidate& b) { return a.distance2 < b.distance2; };
    Candidate& furthest = *std::max_element(all.begin(), all.end(), further);
    if (one.distance2 < furthest.distance2) furthest = one;
  }
};

/// std::rint and std::ceil for |a| < 2^51, without the call that they are where any x86-64 must do.
double nearest_whole(double a) noexcept {
  constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52: no bits are left for fractions
  return (a + kShift) - kShift;
}
double whole_above(double a) noexcept {
  const double near = nearest_whole(a);
  return near < a ? near + 1 : near;
}

/// Within these limits, the turn of `value` nearest to `seed`; false where no turn is inside.
bool unwind(double& value, double seed, double lower, double upper) noexcept {
  // Half a turn away is as near on either side; rounding must not decide which it is.
  value += kTurn * nearest_whole((seed - value) * (1 / kTurn) - 1e-9);
  if (value < lower - kAtLimit) value += kTurn * whole_above((lower - value) * (1 / kTurn) - 1e-11);
  if (value > upper + kAtLimit) {
    value -= kTurn * whole_above((value - upper) * (1 / kTurn) - 1e-11);
    if (value < lower - kAtLimit) return false;
  }
  value = std::min(std::max(value, lower), upper);
  return true;
}

double largest_change(const AxisValues& a, const AxisValues& b, std::size_t n) noexcept {
  double most = 0;
  for (std::size_t i = 0; i < n; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

/// The point nearest to two axes that are not parallel.
Vec3 nearest_point(const JointAxis& a, const JointAxis& b) noexcept {
  const Vec3 n = cross(a.direction, b.direction), way = b.point - a.point;
  const double scale = 1 / dot(n, n);
  const double s = scale * dot(way, cross(b.direction, n)), t = scale * dot(way, cross(a.direction, n));
  return 0.5 * (a.point + s * a.direction + b.point + t * b.direction);
}

bool finite(const Pose& p) noexcept {
  const auto& [x, y, z, w] = p.rotation;
  return std::isfinite(p.position.x + p.position.y + p.position.z + x + y + z + w) &&
         x * x + y * y + z * z + w * w > 1e-12;
}

}  // namespace

struct InverseKinematics::Arm {
  IkSettings settings;
  std::string report;
  SixAxisClass known;
  ArmGeometry geometry;
  LaneArm lanes;
  SixAxisForm form;
  /// The same, but what is nearly singular counts as singular.
  SixAxisForm wary;
  std::array<int, 6> to_arm{0, 1, 2, 3, 4, 5};
  int spare = -1;  ///< the axis that is held at one value after another; -1: none
  std::size_t joints = 0;
  AxisValues lower{}, upper{}, weight{};
  double worth_polishing = 1e-3;

  bool solvable() const noexcept { return known.family != ArmFamily::none; }
  void read(const Chain& chain);
  std::string describe_known() const;
  void settle(const SixAxisClass& found, std::array<int, 6> six);
  void find_form();
  void find_six();
  void find_five();
  void find_seven();
  bool accepts(const Pose& target, std::span<const double> seed) const noexcept;
  void gather(const Pose& target, std::span<const double> seed, bool nearest_only,
              Gathered& out) const noexcept;
  void sample(BranchJob& job, AxisValues& at, bool nearest_only, Gathered& out) const noexcept;
  void solve_at(BranchJob& job, const SixAxisForm& strict_form, const SixAxisForm& wary_form,
                Gathered& out) const noexcept;
  void look_for_twins(const BranchJob& job, std::size_t since, Gathered& out) const noexcept;
  void sift(const BranchJob& job, const Branches& branches, std::size_t since, Gathered& out) const noexcept;
  void write(const Candidate& from, std::span<const double> seed, IkSolution& to) const noexcept;
};

void InverseKinematics::Arm::read(const Chain& chain) {
  joints = chain.joints();
  for (std::size_t i = 0; i < geometry.count; ++i) {
    const std::size_t joint = geometry.axes[i].joint;
    lower[i] = chain.lower()[joint];
    upper[i] = chain.upper()[joint];
    weight[i] = joint < settings.weights.size() ? settings.weights[joint] : 1.0;
    weight[i] *= weight[i];
  }
  lanes = lane_arm(geometry);
}

/// What is known of the six axes that the closed form is about, in words.
std::string InverseKinematics::Arm::describe_known() const {
  std::string out = describe(known.family);
  if (known.from_tool) out += ", counted from the tool";
  if (!known.exact())
    out += fmt::format("; true within {:.2g} mm and {:.2g} mrad, so answers are improved on the true arm",
                       1000 * known.worst_gap, 1000 * known.worst_angle);
  return out;
}

/// `six` are axes of the arm, -1 one that it has not.
void InverseKinematics::Arm::settle(const SixAxisClass& found, std::array<int, 6> six) {
  known = found;
  if (found.from_tool) std::reverse(six.begin(), six.end());
  to_arm = six;
  if (!found.exact()) worth_polishing = 0.1;
  form = form_of(found);
  wary = form_of(found, true);
}

void InverseKinematics::Arm::find_form() {
  if (std::any_of(geometry.axes.begin(), geometry.axes.begin() + static_cast<std::ptrdiff_t>(geometry.count),
                  [](const JointAxis& axis) { return axis.slides; })) {
    report = "no closed form for sliding joints yet";
  } else if (geometry.count == 6) {
    find_six();
  } else if (geometry.count == 5) {
    find_five();
  } else if (geometry.count == 7) {
    find_seven();
  } else {
    report = fmt::format("no closed form for {} axes yet", geometry.count);
  }
}

void InverseKinematics::Arm::find_six() {
  const SixAxisClass found = classify(geometry);
  if (found.family == ArmFamily::none) {
    report = "no closed form: " + why_no_family(geometry);
  } else if (quartic(found.family)) {
    report = fmt::format("no closed form yet for {}", describe(found.family));
  } else {
    settle(found, {0, 1, 2, 3, 4, 5});
    report = describe_known();
  }
}

/// Five axes are six of which one stands still: an axis at the tool that meets the last, or one in a wrist
/// whose other two meet. The true arm decides which of the six axes' answers are its own.
void InverseKinematics::Arm::find_five() {
  const auto with_axis = [&](std::size_t at, const Vec3& direction, const Vec3& point) {
    ArmGeometry six = geometry;
    std::copy_backward(six.axes.begin() + static_cast<std::ptrdiff_t>(at), six.axes.begin() + 5,
                       six.axes.begin() + 6);
    six.axes[at] = {normalized(direction), point};
    six.count = 6;
    return six;
  };
  const auto &four = geometry.axes[3], &last = geometry.axes[4];
  const Vec3 foot = last.point + dot(last.direction, geometry.tool_position - last.point) * last.direction;
  const Vec3 square = cross(four.direction, last.direction);
  const Vec3 along = cross(last.direction, square);
  const struct {
    std::size_t at;
    ArmGeometry six;
  } attempts[] = {{5, with_axis(5, square, foot)},
                  {5, with_axis(5, along, foot)},
                  {3, with_axis(3, square, nearest_point(four, last))},
                  {3, with_axis(3, along, nearest_point(four, last))}};
  for (const auto& [at, six] : attempts) {
    const SixAxisClass found = classify(six);
    if (norm(square) < 0.1 || found.family == ArmFamily::none || quartic(found.family)) continue;
    std::array<int, 6> axes{};
    for (std::size_t k = 0; k < 6; ++k) axes[k] = k == at ? -1 : static_cast<int>(k < at ? k : k - 1);
    settle(found, axes);
    report =
        fmt::format("five axes, solved as six of which axis {} stands still: {}", at + 1, describe_known());
    return;
  }
  report = "no closed form for these five axes";
}

/// Seven axes are six for each value of the one that is held; the one whose hold leaves a family whatever its
/// value.
void InverseKinematics::Arm::find_seven() {
  constexpr std::size_t kOrder[] = {2, 6, 4, 0, 3, 5, 1};
  constexpr double kValues[] = {0.37, 1.1, -0.9, 2.3};
  SixAxisClass best;
  for (const std::size_t k : kOrder) {
    SixAxisClass common = classify(locked(geometry, k, kValues[0]));
    for (const double value : kValues) {
      const SixAxisClass other = classify(locked(geometry, k, value));
      if (other.family != common.family || other.from_tool != common.from_tool)
        common.family = ArmFamily::none;
    }
    if (common.family == ArmFamily::none || quartic(common.family)) continue;
    if (best.family != ArmFamily::none && (best.exact() || !common.exact())) continue;
    best = common;
    spare = static_cast<int>(k);
  }
  if (spare < 0) {
    report = "no closed form: no joint whose hold leaves one";
    return;
  }
  std::array<int, 6> axes{};
  for (int k = 0; k < 6; ++k) axes[static_cast<std::size_t>(k)] = k < spare ? k : k + 1;
  settle(best, axes);
  report = fmt::format("seven axes, solved with axis {} at one value after another: {}", spare + 1,
                       describe_known());
}

bool InverseKinematics::Arm::accepts(const Pose& target, std::span<const double> seed) const noexcept {
  if (seed.size() != joints || !finite(target)) return false;
  for (std::size_t i = 0; i < geometry.count; ++i)
    if (!(std::abs(seed[geometry.axes[i].joint]) < 1e9)) return false;
  return true;
}

/// All branches. Near singularities both those with the seed's value of what is nearly free, and those that
/// the pose determines; of an arm that is not ideal also what descent finds around the seed and beyond folds.
void InverseKinematics::Arm::solve_at(BranchJob& job, const SixAxisForm& strict_form,
                                      const SixAxisForm& wary_form, Gathered& out) const noexcept {
  const std::size_t before = out.count;
  Branches branches;
  job.form = &wary_form;
  solve_branches(job, branches);
  sift(job, branches, before, out);
  if (branches.free == 0) return;
  if (known.exact()) {
    job.form = &strict_form;
    solve_branches(job, branches);
    return sift(job, branches, before, out);
  }
  job.patience = 14;
  for (int quarter = 1; quarter < 4; ++quarter) {
    job.beside_seed = quarter * kTurn / 4;
    solve_branches(job, branches);
    sift(job, branches, before, out);
  }
  job.beside_seed = 0;
  job.form = &strict_form;
  solve_branches(job, branches);
  sift(job, branches, before, out);
  for (std::size_t i = 0; i < geometry.count; ++i)
    for (std::size_t k = 0; k < kBranches; ++k)
      branches.value[i][k] = job.seed[i] + 0.02 * std::sin(static_cast<double>(k * (i + 1)));
  branches.free = 0;
  polish_branches(job, branches);
  sift(job, branches, before, out);
  if (spare < 0) look_for_twins(job, before, out);
}

/// Near a fold a solution has a twin on the other side of it, in the direction that hardly moves the tool.
void InverseKinematics::Arm::look_for_twins(const BranchJob& job, std::size_t since,
                                            Gathered& out) const noexcept {
  constexpr double kNear = 0.02, kSteps[] = {3, 10, 40, 150};
  Branches branches;
  const std::size_t end = out.count;
  for (std::size_t c = since; c < end; ++c) {
    const AxisValues at = out.all[c].value;
    AxisValues way{};
    const double least = geometry.least_motion(at, way);
    if (least > kNear) continue;
    for (std::size_t k = 0; k < kBranches; ++k) {
      const double step = std::clamp(kSteps[k / 2] * least, 1e-4, 0.4) * (k % 2 ? 1 : -1);
      for (std::size_t i = 0; i < geometry.count; ++i) branches.value[i][k] = at[i] + step * way[i];
    }
    branches.free = 0;
    polish_branches(job, branches);
    sift(job, branches, since, out);
  }
}

/// Looks at what each branch offers. Candidates `since` that number are of the same question.
void InverseKinematics::Arm::sift(const BranchJob& job, const Branches& branches, std::size_t since,
                                  Gathered& out) const noexcept {
  const std::size_t n = geometry.count;
  const double position2 = settings.position_tolerance * settings.position_tolerance;
  const double orientation2 = settings.orientation_tolerance * settings.orientation_tolerance;
  for (std::size_t k = 0; k < kBranches; ++k) {
    Candidate one;
    one.distance2 = 0;
    one.position2 = branches.position_error2[k];
    one.orientation2 = branches.orientation_error2[k];
    one.exact = one.position2 <= position2 && one.orientation2 <= orientation2;
    const double size = one.position2 / (lanes.size * lanes.size) + one.orientation2;
    if (!one.exact && !(size < 1.02 * out.nearest_size)) continue;
    bool inside = true;
    for (std::size_t i = 0; i < n; ++i) {
      one.value[i] = branches.value[i][k];
      inside &= unwind(one.value[i], out.seed[i], lower[i], upper[i]);
      const double away = one.value[i] - out.seed[i];
      one.distance2 += weight[i] * away * away;
    }
    out.beyond_limits |= one.exact && !inside;
    if (!inside) continue;
    one.singular = (branches.free >> k & 1u) != 0;
    if (!one.exact) {
      // As good as the best so far: the one nearer to the seed.
      if (size > 0.98 * out.nearest_size && one.distance2 > out.nearest.distance2) continue;
      out.nearest = one;
      out.nearest_size = size;
      continue;
    }
    bool known_already = false;
    for (std::size_t j = since; j < out.count; ++j)
      known_already |= largest_change(out.all[j].value, one.value, n) < kSameSolution;
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
  job.worth_polishing = worth_polishing;
  if (spare < 0) return solve_at(job, form, wary, out);
  sample(job, at, nearest_only, out);
}

/// The spare axis at its seed's value and at values all over its range; then, where only the nearest solution
/// is wanted, at values ever closer around the best one.
void InverseKinematics::Arm::sample(BranchJob& job, AxisValues& at, bool nearest_only,
                                    Gathered& out) const noexcept {
  const auto k = static_cast<std::size_t>(spare);
  const double least = std::max(lower[k], out.seed[k] - kTurn / 2), most = std::min(upper[k], least + kTurn);
  const double cell = (most - least) / std::max(1, settings.samples);
  const auto look_at = [&](double value) {
    at[k] = std::clamp(value, least, most);
    const SixAxisClass six = seen_as(locked(geometry, k, at[k]), known.family, known.from_tool);
    solve_at(job, form_of(six), form_of(six, true), out);
  };
  look_at(out.seed[k]);
  for (int i = 0; i < settings.samples; ++i) look_at(least + (i + 0.5) * cell);
  // Where limits leave but a little of the range: look closer before giving up.
  constexpr int kCloser = 4;
  for (int i = 0; out.count == 0 && i < kCloser * settings.samples; ++i) look_at(least + i * cell / kCloser);
  if (!nearest_only || out.count == 0) return;
  constexpr int kHalvings = 14;
  double step = cell / 2;
  for (int i = 0; i < kHalvings; ++i, step /= 2) {
    const double center = out.best().value[k];
    look_at(center - step);
    look_at(center + step);
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
  std::string why_not;
  if (const auto geometry = geometry_of(chain, why_not)) {
    arm->geometry = *geometry;
    arm->read(chain);
    arm->find_form();
  } else {
    arm->report = "no closed form: " + why_not;
  }
  arm_ = std::move(arm);
}

InverseKinematics::~InverseKinematics() = default;
InverseKinematics::InverseKinematics(InverseKinematics&&) noexcept = default;
InverseKinematics& InverseKinematics::operator=(InverseKinematics&&) noexcept = default;

InverseKinematics::operator bool() const noexcept {
  return arm_->solvable();
}
ArmFamily InverseKinematics::family() const noexcept {
  return arm_->known.family;
}
bool InverseKinematics::complete() const noexcept {
  return arm_->solvable() && arm_->spare < 0;
}
const std::string& InverseKinematics::report() const noexcept {
  return arm_->report;
}

IkOutcome InverseKinematics::solve(const Pose& target, std::span<const double> seed,
                                   IkSolution& out) const noexcept {
  out = {};
  std::copy(seed.begin(), seed.begin() + static_cast<std::ptrdiff_t>(std::min(seed.size(), out.q.size())),
            out.q.begin());
  if (!arm_->solvable()) return IkOutcome::no_closed_form;
  if (!arm_->accepts(target, seed)) return IkOutcome::malformed;
  Gathered found;
  arm_->gather(target, seed, true, found);
  if (found.count == 0) {
    if (found.nearest_size < 1e299) arm_->write(found.nearest, seed, out);
    return found.beyond_limits ? IkOutcome::limits : IkOutcome::unreachable;
  }
  arm_->write(found.best(), seed, out);
  return IkOutcome::solved;
}

IkOutcome InverseKinematics::solve_all(const Pose& target, std::span<const double> seed,
                                       IkSolutions& out) const noexcept {
  out.count = 0;
  if (!arm_->solvable()) return IkOutcome::no_closed_form;
  if (!arm_->accepts(target, seed)) return IkOutcome::malformed;
  Gathered found;
  arm_->gather(target, seed, false, found);
  std::array<std::uint8_t, IkSolutions::kCapacity> order;
  for (std::size_t k = 0; k < found.count; ++k) {
    std::size_t at = k;
    for (; at > 0 && found.all[order[at - 1]].distance2 > found.all[k].distance2; --at)
      order[at] = order[at - 1];
    order[at] = static_cast<std::uint8_t>(k);
  }
  for (std::size_t k = 0; k < found.count; ++k) arm_->write(found.all[order[k]], seed, out.all[k]);
  out.count = found.count;
  if (found.count > 0) return IkOutcome::solved;
  return found.beyond_limits ? IkOutcome::limits : IkOutcome::unreachable;
}

const char* name(IkOutcome outcome) {
  switch (outcome) {
    case IkOutcome::solved:
      return "solved";
    case IkOutcome::no_closed_form:
      return "no_closed_form";
    case IkOutcome::malformed:
      return "malformed";
    case IkOutcome::unreachable:
      return "unreachable";
    case IkOutcome::limits:
      return "limits";
  }
  return "";
}

}  // namespace polyarm::kinematics
