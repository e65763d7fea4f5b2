// Chooses the method for an arm from its axes when the robot is loaded.
#include "polyarm/ik/ik_arm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "polyarm/closed_form/planar_form.hpp"
#include "polyarm/kinematics/arm_length.hpp"
#include "polyarm/kinematics/random.hpp"

namespace polyarm::ik {

namespace {

/// True if neighbouring axes are parallel or perpendicular, to the rounding of descriptions.
bool right_angled(const ArmGeometry& arm) noexcept {
  constexpr double kRounded = 2e-5;  // rad
  for (std::size_t i = 0; i + 1 < arm.count; ++i) {
    const Vec3 &a = arm.axes[i].direction, &b = arm.axes[i + 1].direction;
    if (std::min(std::abs(dot(a, b)), norm(cross(a, b))) > kRounded) return false;
  }
  return true;
}

}  // namespace

void InverseKinematics::Arm::read(const Chain& chain) {
  joints = chain.joints();
  for (std::size_t i = 0; i < geometry.count; ++i) {
    const std::size_t joint = geometry.axes[i].joint;
    limits.lower[i] = chain.lower()[joint];
    limits.upper[i] = chain.upper()[joint];
    limits.weight[i] = joint < settings.weights.size() ? settings.weights[joint] : 1.0;
    limits.weight[i] *= limits.weight[i];
  }
  lanes = lane_arm(geometry);
}

NumericSettings InverseKinematics::Arm::numeric_settings() const {
  NumericSettings out;
  out.position_tolerance = settings.position_tolerance;
  out.orientation_tolerance = settings.orientation_tolerance;
  out.weights = settings.weights;
  return out;
}

NumericSettings InverseKinematics::Arm::move_settings() const {
  constexpr int kStepsPerRestart = 8;  // each with eight descents side by side
  NumericSettings out;
  out.position_tolerance = out.orientation_tolerance = settings.descent_tolerance;
  out.weights = settings.weights;
  out.goal = settings.goal;
  out.steps = kStepsPerRestart * std::max(1, settings.restarts);
  out.searches = std::max(1, settings.restarts);
  return out;
}

void InverseKinematics::Arm::add_numeric() {
  if (!moves) return;
  numeric.emplace(*moves, numeric_settings());
  if (!solvable()) report += "; solved by iteration";
}

/// Describes the six axes of the closed form, as text for a person.
std::string InverseKinematics::Arm::describe_known() const {
  std::string out = describe(known.family);
  if (known.from_tool) out += ", counted from the tool";
  if (!known.exact())
    out += fmt::format("; true within {:.2g} mm and {:.2g} mrad, so answers are improved on the true arm",
                       1000 * known.worst_gap, 1000 * known.worst_angle);
  return out;
}

/// Restores an earlier settle(): `axes` are those of the form.
void InverseKinematics::Arm::restore(const SixAxisClass& found, std::array<int, 6> axes) {
  if (found.from_tool) std::reverse(axes.begin(), axes.end());
  settle(found, axes);
}

/// `six` are axes of the arm; -1 marks an axis that the arm does not have.
void InverseKinematics::Arm::settle(const SixAxisClass& found, std::array<int, 6> six) {
  known = found;
  if (found.from_tool) std::reverse(six.begin(), six.end());
  to_arm = six;
  if (!found.exact()) worth_polishing = 0.1;
  form = form_of(found);
  wary = form_of(found, true);
  first = tolerant_form_of(form);
  const bool whole = geometry.count == 6 && std::find(six.begin(), six.end(), -1) == six.end();
  quick.form.family = ArmFamily::none;
  if (!whole || !kinematics::takes_quick(found) || settings.position_tolerance < 1e-11 ||
      settings.orientation_tolerance < 1e-11)
    return;
  quick.form = form_for_quick(found);
  planar_form(quick.form, quick.planar);
  quick.most_weight = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto i = static_cast<std::size_t>(six[k]);
    quick.to_arm[k] = static_cast<std::uint8_t>(i);
    quick.joint[k] = static_cast<std::uint8_t>(geometry.axes[i].joint);
    quick.window[k] = window_of(limits.lower[i], limits.upper[i], limits.weight[i]);
    quick.most_weight = std::max(quick.most_weight, limits.weight[i]);
  }
  if (!kinematics::takes_quick(quick)) quick.form.family = ArmFamily::none;
}

void InverseKinematics::Arm::find_form() {
  const auto behind = geometry.axes.begin() + static_cast<std::ptrdiff_t>(geometry.count);
  const auto slides =
      std::count_if(geometry.axes.begin(), behind, [](const JointAxis& axis) { return axis.slides; });
  if (geometry.count == 7 && slides <= 1) {
    find_seven();
  } else if (slides > 0) {
    find_sliding();
  } else if (geometry.count == 6) {
    find_six();
  } else if (geometry.count < 6) {
    find_fewer();
  } else {
    report = fmt::format("no closed form: {} axes", geometry.count);
  }
  if (!formed()) report += "; solved by iteration";
}

namespace {
constexpr int kOwnStates = 6;
}

void InverseKinematics::Arm::find_six() {
  const SixAxisClass found = classify(geometry);
  if (found.family == ArmFamily::none) {
    report = why_no_family(geometry);
    find_general(true);
    report = std::string(general ? "six axes of any kind, by the roots of a polynomial of degree 16"
                                 : "no closed form") +
             ": " + report;
  } else {
    settle(found, {0, 1, 2, 3, 4, 5});
    report = describe_known();
    if (searched(found.family)) {
      // For an arm of right angles the polynomial finds almost nothing that the search misses
      // (bench/journal/kinematics.md).
      constexpr double kRounded = 1e-6;  // m
      if (found.worst_gap > kRounded || !right_angled(geometry)) find_general(false);
      return;
    }
    if (found.exact() || found_of_own_states(kOwnStates) == kOwnStates) return;
    // A deviation can be small compared with the arm and large compared with the lengths that its solution
    // depends on.
    const std::string nearly = report;
    find_general(true);
    weak = !general;
    if (weak) return;
    known = {};
    quick.form.family = ArmFamily::none;
    report = "six axes of any kind, by the roots of a polynomial of degree 16: too far from " + nearly;
  }
}

namespace {

constexpr int kStates = 4;

/// Counts how many of a few states the algebra recovers; arms with special axes may suit it from one end
/// only. Stops if `needed` is out of reach or `enough` are found.
int found_again(const ArmGeometry& arm, GeneralSix& six, int needed, int enough) {
  Random random(7);
  int out = 0;
  for (int i = 0; i < kStates && out + kStates - i >= needed && out < enough; ++i) {
    GeneralSix::State q;
    for (double& value : q) value = random.between(-3, 3);
    PoseTarget target;
    arm.forward(q, target.rotation, target.position);
    const GeneralSix::Finds found = six.finds(q, target, 1e-3);
    if (found == GeneralSix::Finds::nothing_ever) return out;
    out += found == GeneralSix::Finds::it;
  }
  return out;
}

}  // namespace

/// True if `value(axis)` equals state `q`, except for whole turns.
template <typename Value>
bool InverseKinematics::Arm::is_state(const JointValues& q, const Value& value) const noexcept {
  double worst = 0;
  for (std::size_t a = 0; a < geometry.count; ++a) {
    const double d = value(a) - q[geometry.axes[a].joint];
    worst = std::max(worst, std::abs(geometry.axes[a].slides ? d : std::remainder(d, kTurn)));
  }
  return worst < 1e-3;
}

/// Counts how many of a few states within limits are among the solutions of their poses.
int InverseKinematics::Arm::found_of_own_states(int states) const noexcept {
  Random random(8);
  int out = 0;
  JointValues q{}, seed{};
  for (int i = 0; i < states; ++i) {
    for (std::size_t j = 0; j < joints; ++j) {
      q[j] = random_value(*described, j, random);
      seed[j] = random_value(*described, j, random);
    }
    const Pose target = described->forward({q.data(), joints});
    if (branches_hold(target, q, seed)) {
      ++out;
      continue;
    }
    Gathered found;
    gather(target, {seed.data(), joints}, false, found);
    bool there = false;
    for (std::size_t k = 0; k < found.count; ++k)
      there |= is_state(q, [&](std::size_t a) { return found.all[k].value[a]; });
    out += there;
  }
  return out;
}

/// True if the improved branches of the ideal arm contain state `q` of its pose: then the state counts as
/// found without a search beside singularities.
bool InverseKinematics::Arm::branches_hold(const Pose& target, const JointValues& q,
                                           const JointValues& seed) const noexcept {
  AxisValues at;
  for (std::size_t i = 0; i < geometry.count; ++i) at[i] = seed[geometry.axes[i].joint];
  BranchJob job;
  constexpr int kPatient = 14, kAtOnce = 4;  // steps
  job.form = known.exact() ? &wary : &first;
  job.arm = &lanes;
  job.target = {rotation_of(normalized(target.rotation)), target.position};
  job.to_arm = to_arm;
  job.seed = job.near = at.data();
  job.limits = &limits;
  job.worth_polishing = worth_polishing;
  const double position2 = settings.position_tolerance * settings.position_tolerance,
               orientation2 = settings.orientation_tolerance * settings.orientation_tolerance;
  const auto hold = [&](const Branches& found) {
    for (std::size_t k = 0; k < kBranches; ++k) {
      const bool good = (found.inside >> k & 1u) != 0 && found.position_error2[k] <= position2 &&
                        found.orientation_error2[k] <= orientation2;
      if (good && is_state(q, [&](std::size_t a) { return found.value[a][k]; })) return true;
    }
    return false;
  };
  if (known.exact()) job.most_steps = kAtOnce;
  Branches found;
  solve_branches(job, found);
  if (hold(found)) return true;
  if (known.exact()) return false;
  job.patience = kPatient;
  job.form = &form;
  solve_branches(job, found);
  return hold(found);
}

void InverseKinematics::Arm::find_general(bool both_ends) {
  constexpr int kLeast = 3;
  int most = kLeast - 1;
  for (const bool from_tool : {false, true}) {
    auto six = std::make_unique<GeneralSix>(geometry, from_tool, false);
    // For the last end it only matters whether it is good enough and better than the others.
    const int enough = !from_tool || most == kLeast ? kStates : kLeast;
    const int again = found_again(geometry, *six, both_ends ? kLeast : most + 1, enough);
    if (again < kLeast) continue;
    std::unique_ptr<const GeneralSix> other = std::move(six);
    if (again > most) {
      most = again;
      std::swap(general, other);
    }
    if (both_ends) general_too = std::move(other);
    if (again == kStates && !both_ends) break;
  }
}

/// SCARAs and gantries.
void InverseKinematics::Arm::find_sliding() {
  const SlidingArm::Kind kind = SlidingArm::kind_of(geometry);
  if (kind == SlidingArm::Kind::none) {
    report = "no closed form: joints that slide";
    return;
  }
  sliding = std::make_unique<SlidingArm>(geometry, kind);
  report = kind == SlidingArm::Kind::scara ? "three parallel axes and one that slides along them"
                                           : "three axes that slide, the others turn";
}

/// Seven axes are six axes for each value of the fixed one. Fixes the axis that leaves a family at any value.
void InverseKinematics::Arm::find_seven() {
  constexpr std::size_t kOrder[] = {2, 6, 4, 0, 3, 5, 1};
  constexpr double kValues[] = {0.37, 1.1, -0.9, 2.3};
  SixAxisClass best;
  for (const std::size_t k : kOrder) {
    SixAxisClass common = classify(locked(geometry, k, kValues[0]));
    const int less = effort(common.family) - effort(best.family);
    if (less > 0 || (less == 0 && (best.exact() || !common.exact()))) continue;
    for (const double value : kValues) {
      if (value == kValues[0] || common.family == ArmFamily::none) continue;
      const SixAxisClass other = classify(locked(geometry, k, value));
      if (other.family != common.family || other.from_tool != common.from_tool)
        common.family = ArmFamily::none;
    }
    if (common.family == ArmFamily::none) continue;
    best = common;
    spare = static_cast<int>(k);
    if (effort(best.family) == 0 && best.exact()) break;
  }
  if (spare < 0) {
    report = "no closed form: no joint leaves one when it is locked";
    return;
  }
  std::array<int, 6> axes{};
  for (int k = 0; k < 6; ++k) axes[static_cast<std::size_t>(k)] = k < spare ? k : k + 1;
  settle(best, axes);
  if (SrsArm::fits(geometry)) srs = std::make_unique<SrsArm>(geometry, limits);
  report = fmt::format("seven axes, solved with axis {} at one value after another: {}", spare + 1,
                       describe_known());
  if (!srs) end = SpareEnd::of(geometry, limits);
  if (end) report += fmt::format("; the nearest by axis {}, eight values side by side", end->axis() + 1);
  if (srs) report += "; the nearest by elbow angle, as shoulder and wrist are spherical";
}

}  // namespace polyarm::ik
