#include "polyarm/closed_form/spare_end.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/closed_form/eightfold_search.hpp"
#include "polyarm/closed_form/planar_form.hpp"

namespace polyarm::kinematics {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kScanned = 24;
constexpr int kCloser = 96;  // where limits leave but a little of the range
constexpr int kDips = 3;
constexpr double kAsDeep = 1.4;  // of the best cost: what a search may still make better than it
constexpr double kClose = 1.02;  // and after one look around
constexpr double kFine = 1e-6;   // rad: closer than this nothing is gained

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
    costs[k] =
        inside ? found.distance[k] * found.distance[k] + weight_ * away * away : EightfoldSearch::kNowhere;
  }
}

bool SpareEnd::nearest(const Pose& target, const double* seed, State& out) const noexcept {
  const double middle = seed[joint_], least = std::max(lower_, middle - kTurn / 2),
               most = std::min(upper_, least + kTurn), cell = (most - least) / (kScanned - 1);
  if (!(cell > 0)) return false;
  QuickAnswers found;
  const auto keep = [&](std::size_t lane, double value) {
    for (std::size_t i = 0; i < 6; ++i) out[i + (axis_ == 0)] = found.value[i][lane];
    out[axis_] = value;
  };
  constexpr std::size_t kMost = kCloser + 2 * kBranches;
  std::array<double, kMost> costs;
  std::size_t count = 0;
  double best = EightfoldSearch::kNowhere;
  const auto scan = [&](double first, double step) {
    for (count = 0; count + kBranches <= kMost && first + static_cast<double>(count) * step <= most;
         count += kBranches) {
      const double from = first + static_cast<double>(count) * step;
      ask(target, seed, from, step, found, costs.data() + count);
      for (std::size_t k = 0; k < kBranches; ++k) {
        if (!(costs[count + k] < best)) continue;
        best = costs[count + k];
        keep(k, from + static_cast<double>(k) * step);
      }
    }
  };
  // The seed's own value is one of them.
  double first = middle >= least && middle <= most ? least + std::fmod(middle - least, cell) : least,
         step = cell;
  scan(first, step);
  if (best == EightfoldSearch::kNowhere) scan(first = least, step = (most - least) / (kCloser - 1));
  if (best == EightfoldSearch::kNowhere) return false;
  // Around the best, and around other dips that might go as deep.
  for (int dip = 0; dip < kDips; ++dip) {
    std::size_t at = count;
    for (std::size_t k = 0; k < count; ++k) {
      const bool low = (k == 0 || costs[k] <= costs[k - 1]) && (k + 1 == count || costs[k] <= costs[k + 1]);
      if (low && costs[k] < kAsDeep * best && (at == count || costs[k] < costs[at])) at = k;
    }
    if (at == count) break;
    EightfoldSearch search(first + static_cast<double>(at) * step, costs[at], step);
    costs[at] = EightfoldSearch::kNowhere;
    while (search.going(kFine)) {
      double around[kBranches];
      ask(target, seed, search.first(), search.step(), found, around);
      const std::size_t k = search.see(around);
      if (search.cost() > kClose * best) break;  // of another dip: no more than this is gained
      if (k == kBranches || !(search.cost() < best)) continue;
      best = search.cost();
      keep(k, search.best());
    }
  }
  return true;
}

}  // namespace polyarm::kinematics
