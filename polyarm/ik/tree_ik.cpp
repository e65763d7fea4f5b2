#include "polyarm/ik/tree_ik.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/kinematics/arm_geometry.hpp"
#include "polyarm/kinematics/random.hpp"

namespace polyarm::ik {

namespace {

constexpr double kLargestStep = 0.8;  // rad or lengths
constexpr double kDamping = 0.02;     // times the squared error (Chan and Lawrence 1988)
constexpr double kLeastDamping = 1e-11;
constexpr int kTimeout = 8;
constexpr std::size_t kMost = TreeIk::kMostMoving;

bool finite(const Pose& p) {
  const auto& [x, y, z, w] = p.rotation;
  const double size2 = x * x + y * y + z * z + w * w;
  return norm(p.position) < 1e9 && std::isfinite(size2) && size2 > 1e-12;
}

/// The part of `e` outside the tolerance: deviations -e in [low, high] count as zero.
double rest(double e, double low, double high) {
  return std::max(0.0, e + low) + std::min(0.0, e + high);
}

/// The single tool axis about which the task allows rotation; -1 if there is none or several.
int free_spin_of(const IkTask& task) {
  int free = -1, count = 0;
  for (int i = 0; i < 3; ++i) {
    const auto row = static_cast<std::size_t>(3 + i);
    if (task.low[row] != -IkTask::kFree || task.high[row] != IkTask::kFree) continue;
    free = i;
    ++count;
  }
  return count == 1 && task.frame == IkTask::Frame::tool ? free : -1;
}

}  // namespace

/// One descent: the normal equations of all rows, and errors. q, seed and jacobian cover all joints; the
/// other members cover the joints that move a tip.
struct TreeIk::Work {
  std::array<double, Chain::kMaxJoints> q, seed;
  std::array<double, 6 * Chain::kMaxJoints> jacobian;
  std::array<double, kMost> gradient, dq;
  std::array<double, kMost * kMost> square;  ///< J^T J, its lower half
  std::array<double, TreeSolution::kMaxTips> position{}, orientation{};
  double size2 = 0;  ///< the objective
  bool within = false;
};

TreeIk::TreeIk(const description::RobotModel& model, std::span<const TreeTip> tips, const Pose& T_world_base,
               TreeSettings settings)
    : settings_(settings) {
  if (tips.empty() || tips.size() > TreeSolution::kMaxTips)
    throw Error("bad-model", "a tree has 1 to 8 tips, here are " + std::to_string(tips.size()),
                "solve for fewer tips at once");
  for (const TreeTip& tip : tips) chains_.emplace_back(model, tip.link, T_world_base, tip.T_link_tcp);
  double reach = 0;
  for (const Chain& chain : chains_)
    if (std::isfinite(chain.reach())) reach = std::max(reach, chain.reach());
  length_ = reach > 1e-6 ? reach / 2 : 0.5;
  for (std::size_t i = 0; i < joints(); ++i) {
    unit_[i] = chains_.front().slides(i) ? length_ : 1.0;
    bool turns = true;
    for (const Chain& chain : chains_) {
      if (!chain.moves_tcp(i)) continue;
      turns &= chain.period(i) > 0;
      period_[i] = std::max(period_[i], chain.period(i));
    }
    if (!turns) period_[i] = 0;
    const auto moved = [&](const Chain& chain) { return chain.moves_tcp(i); };
    if (std::any_of(chains_.begin(), chains_.end(), moved)) moving_.push_back(i);
  }
  if (moving_.size() > kMost)
    throw Error("too-many-joints",
                std::to_string(moving_.size()) + " joints move the tips, at most " + std::to_string(kMost) +
                    " are taken",
                "solve for fewer tips at once");
}

bool TreeIk::accepts(std::span<const TreeTask> tasks, std::span<const double> seed) const noexcept {
  if (tasks.size() != tips() || seed.size() != joints()) return false;
  for (const TreeTask& one : tasks) {
    if (!finite(one.target) || !(one.weight >= 0) || !std::isfinite(one.weight)) return false;
    for (std::size_t i = 0; i < 6; ++i)
      if (!(one.task.low[i] <= one.task.high[i]) || !(one.task.weight[i] >= 0)) return false;
  }
  return std::all_of(seed.begin(), seed.end(), [](double v) { return std::abs(v) < 1e9; });
}

void TreeIk::add_rows(std::size_t tip, const TreeTask& one, Work& work) const noexcept {
  const std::size_t n = joints();
  const Chain& chain = chains_[tip];
  const Pose now = chain.jacobian({work.q.data(), n}, {work.jacobian.data(), 6 * n});
  const Quaternion wanted = normalized(one.target.rotation);
  const Rotation frame = one.task.frame == IkTask::Frame::tool ? rotation_of(wanted) : Rotation{};
  Vec3 turn = to_rotation_vector(wanted * inverse(now.rotation));
  if (const int spin = free_spin_of(one.task); spin >= 0) {
    const Vec3 axis{spin == 0 ? 1.0 : 0.0, spin == 1 ? 1.0 : 0.0, spin == 2 ? 1.0 : 0.0};
    turn = to_rotation_vector(rotation_between(now.rotation * axis, wanted * axis));
  }
  const Rotation into = transposed(frame);
  const Vec3 p = into * (one.target.position - now.position), r = into * turn;
  const double off[6] = {p.x, p.y, p.z, r.x, r.y, r.z};
  double error[6], square2[2] = {0, 0};
  for (std::size_t i = 0; i < 6; ++i) {
    error[i] = rest(off[i], one.task.low[i], one.task.high[i]);
    square2[i / 3] += error[i] * error[i];
  }
  work.position[tip] = std::sqrt(square2[0]);
  work.orientation[tip] = std::sqrt(square2[1]);
  if (one.weight == 0) return;
  work.within &= work.position[tip] <= settings_.position_tolerance &&
                 work.orientation[tip] <= settings_.orientation_tolerance;
  const Vec3 axes[3] = {frame.x, frame.y, frame.z};
  for (std::size_t i = 0; i < 6; ++i) {
    const bool exact = one.task.low[i] == 0 && one.task.high[i] == 0;
    const double unit = i < 3 ? 1 / length_ : 1.0;
    const double weight = one.weight * one.task.weight[i] * unit;
    if ((!exact && error[i] == 0) || weight == 0) continue;
    work.size2 += weight * weight * error[i] * error[i];
    std::array<double, kMost> row;
    const double* rows = work.jacobian.data() + (i < 3 ? 0 : 3 * n);
    const std::size_t m = moving_.size();
    for (std::size_t k = 0; k < m; ++k) {
      const std::size_t joint = moving_[k];
      const Vec3 column{rows[joint], rows[n + joint], rows[2 * n + joint]};
      row[k] = weight * unit_[joint] * dot(axes[i % 3], column);
      work.gradient[k] += row[k] * weight * error[i];
    }
    for (std::size_t k = 0; k < m; ++k)
      for (std::size_t j = 0; j <= k && row[k] != 0; ++j) work.square[k * m + j] += row[k] * row[j];
  }
}

void TreeIk::measure(std::span<const TreeTask> tasks, Work& work) const noexcept {
  const std::size_t n = moving_.size();
  work.size2 = 0;
  work.within = true;
  std::fill_n(work.gradient.begin(), n, 0.0);
  std::fill_n(work.square.begin(), n * n, 0.0);
  for (std::size_t tip = 0; tip < tips(); ++tip) add_rows(tip, tasks[tip], work);
}

/// Solves (J^T J + damping) dq = J^T e by Cholesky's method and moves. Leaves out joints at a limit that
/// would be pushed beyond it.
bool TreeIk::step(Work& work) const noexcept {
  const std::size_t n = moving_.size();
  const Chain& limits = chains_.front();
  double* a = work.square.data();
  double* x = work.dq.data();
  const auto free = [&](std::size_t joint) {
    return period_[joint] > 0 && limits.upper()[joint] - limits.lower()[joint] >= period_[joint];
  };
  for (std::size_t k = 0; k < n; ++k) {
    const double drawn = work.gradient[k];
    const std::size_t joint = moving_[k];
    const bool pinned = !free(joint) && ((drawn > 0 && work.q[joint] >= limits.upper()[joint]) ||
                                         (drawn < 0 && work.q[joint] <= limits.lower()[joint]));
    x[k] = pinned ? 0.0 : drawn;
    for (std::size_t j = 0; pinned && j < n; ++j) (j <= k ? a[k * n + j] : a[j * n + k]) = 0;
    a[k * n + k] += kDamping * work.size2 + kLeastDamping;
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t j = 0; j <= k; ++j) {
      double sum = a[k * n + j];
      for (std::size_t i = 0; i < j; ++i) sum -= a[k * n + i] * a[j * n + i];
      if (j == k && !(sum > 0)) return false;
      a[k * n + j] = j == k ? std::sqrt(sum) : sum / a[j * n + j];
    }
    for (std::size_t i = 0; i < k; ++i) x[k] -= a[k * n + i] * x[i];
    x[k] /= a[k * n + k];
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t i = k + 1; i < n; ++i) x[k] -= a[i * n + k] * x[i];
    x[k] /= a[k * n + k];
  }
  double largest = kLargestStep;
  for (std::size_t k = 0; k < n; ++k) largest = std::max(largest, std::abs(x[k]));
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t joint = moving_[k];
    work.q[joint] += unit_[joint] * x[k] * (kLargestStep / largest);
    if (free(joint)) continue;
    work.q[joint] = std::clamp(work.q[joint], limits.lower()[joint], limits.upper()[joint]);
  }
  return true;
}

bool TreeIk::descend(std::span<const TreeTask> tasks, Work& work, TreeSolution& best,
                     double& least) const noexcept {
  double last = 1e300;
  bool found = false;
  int stuck = 0;
  for (int i = 0; i < settings_.steps && stuck < kTimeout; ++i) {
    measure(tasks, work);
    if (!std::isfinite(work.size2)) break;
    // Within tolerance, continues while that helps much.
    if (found && work.size2 > 0.25 * least) break;
    if (work.size2 < least || (work.within && !found)) {
      least = work.size2;
      found |= work.within;
      std::copy_n(work.q.begin(), joints(), best.q.begin());
      best.position_error = work.position;
      best.orientation_error = work.orientation;
    }
    if (least < 1e-28) break;
    stuck = work.size2 > 0.97 * last ? stuck + 1 : 0;
    last = work.size2;
    if (!step(work)) break;
  }
  return found;
}

IkOutcome TreeIk::solve(std::span<const TreeTask> tasks, std::span<const double> seed,
                        TreeSolution& out) const noexcept {
  out.exact = false;
  if (!accepts(tasks, seed)) return IkOutcome::malformed;
  const std::size_t n = joints();
  const Chain& limits = chains_.front();
  std::array<bool, Chain::kMaxJoints> moves{};
  Work work;
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t tip = 0; tip < tips(); ++tip)
      moves[k] |= tasks[tip].weight > 0 && chains_[tip].moves_tcp(k);
    work.q[k] = work.seed[k] = std::clamp(seed[k], limits.lower()[k], limits.upper()[k]);
  }
  Random random(4);
  double least = 1e300;
  for (int attempt = 0; attempt <= settings_.restarts && !out.exact; ++attempt) {
    out.exact = descend(tasks, work, out, least);
    for (std::size_t k = 0; k < n; ++k)
      if (moves[k]) work.q[k] = random_value(limits, k, random);
  }
  if (least > 1e299) std::copy_n(work.seed.begin(), n, out.q.begin());
  for (std::size_t k = 0; k < n; ++k) {
    const double lower = limits.lower()[k], upper = limits.upper()[k], period = period_[k];
    if (!moves[k]) out.q[k] = seed[k];
    if (!moves[k] || !(period > 0)) continue;
    double q = out.q[k] + period * std::round((work.seed[k] - out.q[k]) / period - 1e-9);
    if (q < lower) q += period * std::ceil((lower - q) / period - 1e-12);
    if (q > upper) q -= period * std::ceil((q - upper) / period - 1e-12);
    out.q[k] = std::clamp(q, lower, upper);
  }
  return out.exact ? IkOutcome::solved : IkOutcome::unreachable;
}

}  // namespace polyarm::ik
