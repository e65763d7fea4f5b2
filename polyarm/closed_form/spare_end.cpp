#include "polyarm/closed_form/spare_end.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/closed_form/curve_dips.hpp"
#include "polyarm/closed_form/planar_form.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr std::size_t kScanned = 32;
constexpr double kNowhere = 1e300;

}  // namespace

std::optional<SpareEnd> SpareEnd::of(const ArmGeometry& arm, const LaneLimits& limits) {
  if (arm.count != 7) return std::nullopt;
  for (std::size_t k = 0; k < 7; ++k)
    if (arm.axes[k].slides) return std::nullopt;
  for (const std::size_t spare : {std::size_t{6}, std::size_t{0}}) {
    const ArmGeometry six = locked(arm, spare, 0);
    const SixAxisClass known = classify(six);
    if (!takes_quick(known)) continue;
    SpareEnd out;
    out.axis_ = spare;
    out.joint_ = arm.axes[spare].joint;
    out.last_ = spare == 6;
    const Rotation back = transposed(arm.tool_rotation);
    const Vec3 &h = arm.axes[spare].direction, &p = arm.axes[spare].point;
    out.direction_ = out.last_ ? back * h : h;
    out.point_ = out.last_ ? back * (p - arm.tool_position) : p;
    out.lower_ = limits.lower[spare];
    out.upper_ = limits.upper[spare];
    out.weight_ = limits.weight[spare];
    out.six_ = lane_arm(six);
    QuickJob& job = out.job_;
    job.form = form_for_quick(known);
    planar_form(job.form, job.planar);
    job.most_weight = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t i = known.from_tool ? 5 - k : k, whole = i + (spare == 0);
      job.to_arm[k] = static_cast<std::uint8_t>(i);
      job.joint[k] = static_cast<std::uint8_t>(arm.axes[whole].joint);
      job.window[k] = window_of(limits.lower[whole], limits.upper[whole], limits.weight[whole]);
      job.most_weight = std::max(job.most_weight, limits.weight[whole]);
    }
    if (takes_quick(job)) return out;
  }
  return std::nullopt;
}

void SpareEnd::ask(const Pose& target, const double* seed, double first, double step, QuickAnswers& found,
                   double* costs) const noexcept {
  std::array<Pose, kBranches> poses;
  double s = std::sin(-0.5 * first), c = std::cos(-0.5 * first);
  const double ds = std::sin(-0.5 * step), dc = std::cos(-0.5 * step);
  for (Pose& pose : poses) {
    const Quaternion by{s * direction_.x, s * direction_.y, s * direction_.z, c};
    const Pose turned{point_ - by * point_, by};
    pose = last_ ? target * turned : turned * target;
    const double next = s * dc + c * ds;
    c = c * dc - s * ds;
    s = next;
  }
  solve_eight(job_, six_, poses, seed, found);
  for (std::size_t k = 0; k < kBranches; ++k) {
    const double at = first + static_cast<double>(k) * step, away = at - seed[joint_];
    const bool inside = at >= lower_ && at <= upper_ && (found.good >> k & 1u) != 0;
    costs[k] = inside ? found.distance[k] * found.distance[k] + weight_ * away * away : kNowhere;
  }
}

std::size_t SpareEnd::dips(const Pose& target, const double* seed,
                           std::span<State, kMostDips> out) const noexcept {
  const double middle = seed[joint_], least = std::max(lower_, middle - kTurn / 2),
               most = std::min(upper_, least + kTurn);
  if (!(most > least)) return 0;
  std::array<double, kScanned> costs;
  std::array<std::array<double, kScanned>, 7> values;
  QuickAnswers found;
  const double step = (most - least) / static_cast<double>(kScanned);
  for (std::size_t from = 0; from < kScanned; from += kBranches) {
    const double first = least + (static_cast<double>(from) + 0.5) * step;
    ask(target, seed, first, step, found, costs.data() + from);
    for (std::size_t i = 0; i < 6; ++i)
      std::copy_n(found.value[i], kBranches, values[i + (axis_ == 0)].begin() + from);
    for (std::size_t k = 0; k < kBranches; ++k)
      values[axis_][from + k] = first + static_cast<double>(k) * step;
  }
  Dips<kMostDips> best(out);
  Dips<kMostDips>::Rows rows;
  for (std::size_t i = 0; i < 7; ++i) rows[i] = values[i].data();
  best.take_all(costs.data(), rows, kScanned, false);
  return best.count();
}

}  // namespace polyarm::kinematics
