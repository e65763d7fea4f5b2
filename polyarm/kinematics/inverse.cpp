#include "polyarm/kinematics/inverse.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace polyarm::kinematics {

namespace {

constexpr double kPi = std::numbers::pi;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;

struct PoseError {
  Vector6 twist;  // from the present pose to the target, world axes
  double position, orientation;
};

PoseError error_between(const Pose& now, const Pose& target, bool orientation_free) {
  const Vec3 p = target.position - now.position;
  const Vec3 r = orientation_free ? Vec3{} : to_rotation_vector(target.rotation * inverse(now.rotation));
  PoseError out;
  out.twist << p.x, p.y, p.z, r.x, r.y, r.z;
  out.position = norm(p);
  out.orientation = norm(r);
  return out;
}

/// One descent. Keeps the best state seen in `best`.
class Descent {
 public:
  Descent(const Chain& chain, const Pose& target, const IkOptions& options)
      : chain_(chain), target_(target), options_(options), jacobian_(6, static_cast<Eigen::Index>(chain.joints())) {}

  bool run(std::vector<double>& q, bool keep_limits) {
    double last = 1e300;
    int stuck = 0;
    for (int i = 0; i < options_.iterations; ++i) {
      const Pose now = chain_.jacobian(q, {jacobian_.data(), static_cast<std::size_t>(jacobian_.size())});
      const PoseError error = error_between(now, target_, options_.orientation_free);
      const double size = error.twist.norm();
      if (size < best_size_) remember(q, error, size);
      if (error.position <= polish_ * options_.position_tolerance &&
          error.orientation <= polish_ * options_.orientation_tolerance)
        return true;
      stuck = size > 0.97 * last ? stuck + 1 : 0;
      if (stuck > 8) break;
      last = size;
      step(q, error, size, keep_limits);
    }
    return best_.position <= options_.position_tolerance && best_.orientation <= options_.orientation_tolerance &&
           finish(q);
  }
  const PoseError& best() const { return best_; }
  const std::vector<double>& best_q() const { return best_q_; }

 private:
  static constexpr double polish_ = 1e-3;

  void remember(const std::vector<double>& q, const PoseError& error, double size) {
    best_size_ = size;
    best_ = error;
    best_q_ = q;
  }
  bool finish(std::vector<double>& q) const {
    q = best_q_;
    return true;
  }

  void step(std::vector<double>& q, const PoseError& error, double size, bool keep_limits) {
    Eigen::VectorXd dq = solve(jacobian_, error.twist, size);
    if (keep_limits && block_limits(q, dq)) dq = solve(jacobian_, error.twist, size);
    const double biggest = dq.cwiseAbs().maxCoeff();
    if (biggest > 0.6) dq *= 0.6 / biggest;
    for (std::size_t j = 0; j < q.size(); ++j) {
      q[j] += dq[static_cast<Eigen::Index>(j)];
      if (keep_limits) q[j] = std::clamp(q[j], chain_.lower()[j], chain_.upper()[j]);
    }
  }

  /// Columns of joints that would leave their limits are taken out for this step.
  bool block_limits(const std::vector<double>& q, const Eigen::VectorXd& dq) {
    bool any = false;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double d = dq[static_cast<Eigen::Index>(j)];
      if ((d > 0 && q[j] >= chain_.upper()[j]) || (d < 0 && q[j] <= chain_.lower()[j])) {
        jacobian_.col(static_cast<Eigen::Index>(j)).setZero();
        any = true;
      }
    }
    return any;
  }

  static Eigen::VectorXd solve(const Jacobian& jacobian, const Vector6& twist, double size) {
    const double damping = 2e-2 * size * size + 1e-12;
    Matrix6 a = jacobian * jacobian.transpose();
    a.diagonal().array() += damping;
    return jacobian.transpose() * a.ldlt().solve(twist);
  }

  const Chain& chain_;
  const Pose& target_;
  const IkOptions& options_;
  Jacobian jacobian_;
  double best_size_ = 1e300;
  PoseError best_{Vector6::Zero(), 1e300, 1e300};
  std::vector<double> best_q_;
};

/// Brings joints that turn to the turn nearest `near` that is inside the limits.
void unwind(const Chain& chain, std::vector<double>& q, std::span<const double> near) {
  for (std::size_t j = 0; j < q.size(); ++j) {
    if (!chain.turns()[j]) continue;
    const double turns = std::round((near[j] - q[j]) / (2 * kPi));
    double best = q[j], best_distance = 1e300;
    for (const double k : {turns - 1, turns, turns + 1}) {
      const double candidate = q[j] + 2 * kPi * k;
      if (candidate < chain.lower()[j] - 1e-12 || candidate > chain.upper()[j] + 1e-12) continue;
      if (std::abs(candidate - near[j]) < best_distance) {
        best = candidate;
        best_distance = std::abs(candidate - near[j]);
      }
    }
    q[j] = best;
  }
}

bool inside(const Chain& chain, const std::vector<double>& q) {
  for (std::size_t j = 0; j < q.size(); ++j)
    if (q[j] < chain.lower()[j] - 1e-9 || q[j] > chain.upper()[j] + 1e-9) return false;
  return true;
}

std::vector<double> random_state(const Chain& chain, std::mt19937_64& random) {
  std::vector<double> q(chain.joints());
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double lower = std::max(chain.lower()[j], -kPi), upper = std::min(chain.upper()[j], kPi);
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    q[j] = lower < upper ? lower + share * (upper - lower) : std::clamp(0.0, chain.lower()[j], chain.upper()[j]);
  }
  return q;
}

double distance(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
  return std::sqrt(sum);
}

/// First without limits and then wound back into them; if that is not possible, with the limits as walls.
bool descend(const Chain& chain, const Pose& target, std::vector<double>& q, std::span<const double> near,
             const IkOptions& options, IkResult& best) {
  const std::vector<double> start = q;
  for (const bool keep_limits : {false, true}) {
    q = start;
    Descent descent(chain, target, options);
    const bool found = descent.run(q, keep_limits);
    if (found) unwind(chain, q, near);
    if (found && inside(chain, q)) return true;
    if (keep_limits && descent.best().position + descent.best().orientation <
                           best.position_error + best.orientation_error) {
      best.q = descent.best_q();
      best.position_error = descent.best().position;
      best.orientation_error = descent.best().orientation;
    }
  }
  return false;
}

/// The joint that a solution without limits breaks worst, as a sentence; empty when there is none.
std::string broken_limit(const Chain& chain, const Pose& target, std::span<const double> seed,
                         const IkOptions& options) {
  std::mt19937_64 random(99);
  std::vector<double> q(seed.begin(), seed.end());
  std::string best;
  double best_excess = 1e300;
  for (int k = 0; k < 24; ++k) {
    Descent descent(chain, target, options);
    if (descent.run(q, false)) {
      unwind(chain, q, seed);
      double excess = 0;
      std::string text;
      for (std::size_t j = 0; j < q.size(); ++j) {
        const double over = std::max(chain.lower()[j] - q[j], q[j] - chain.upper()[j]);
        if (over <= excess) continue;
        excess = over;
        text = fmt::format("only with {} {:.3f} beyond its limit of {:.3f}", chain.names()[j], over,
                           q[j] > chain.upper()[j] ? chain.upper()[j] : chain.lower()[j]);
      }
      if (!text.empty() && excess < best_excess) {
        best_excess = excess;
        best = text;
      }
    }
    q = random_state(chain, random);
  }
  return best;
}

IkResult explain(const Chain& chain, const Pose& target, std::span<const double> seed, const IkOptions& options,
                 IkResult result) {
  const double away = norm(target.position - chain.reach_center());
  if (away > chain.reach()) {
    result.status = IkStatus::unreachable;
    result.reason = fmt::format("it is {:.2f} m from the base, this robot reaches {:.2f} m", away, chain.reach());
    return result;
  }
  if (const std::string limit = broken_limit(chain, target, seed, options); !limit.empty()) {
    result.status = IkStatus::limits;
    result.reason = limit;
    return result;
  }
  IkOptions position_only = options;
  position_only.orientation_free = true;
  std::vector<double> q(seed.begin(), seed.end());
  IkResult ignored;
  ignored.position_error = ignored.orientation_error = 1e300;
  if (!options.orientation_free && descend(chain, target, q, seed, position_only, ignored)) {
    result.status = IkStatus::unreachable;
    result.reason = fmt::format(
        "the place can be reached, but not with this orientation: the nearest found is {:.1f} mm and {:.1f} deg off",
        1e3 * result.position_error, result.orientation_error * 180 / kPi);
    return result;
  }
  result.status = IkStatus::unreachable;
  result.reason = fmt::format("no joint state within limits brings the TCP nearer than {:.1f} mm and {:.1f} deg",
                              1e3 * result.position_error, result.orientation_error * 180 / kPi);
  return result;
}

IkResult solved(const Chain& chain, const Pose& target, std::vector<double> q, const IkOptions& options) {
  IkResult out;
  const PoseError error = error_between(chain.forward(q), target, options.orientation_free);
  out.status = IkStatus::solved;
  out.q = std::move(q);
  out.position_error = error.position;
  out.orientation_error = error.orientation;
  return out;
}

bool finite(const Pose& p) {
  return std::isfinite(p.position.x + p.position.y + p.position.z + p.rotation.x + p.rotation.y + p.rotation.z +
                       p.rotation.w);
}

IkResult refused(std::span<const double> seed, const char* reason) {
  IkResult out;
  out.status = IkStatus::unreachable;
  out.q.assign(seed.begin(), seed.end());
  out.reason = reason;
  return out;
}

}  // namespace

const char* name(IkStatus status) {
  constexpr const char* kNames[] = {"solved", "unreachable", "limits", "no_convergence"};
  return kNames[static_cast<std::size_t>(status)];
}

IkResult solve_inverse(const Chain& chain, const Pose& target, std::span<const double> seed,
                       const IkOptions& options) {
  if (!finite(target)) return refused(seed, "the pose has values that are no numbers");
  if (chain.joints() == 0) return refused(seed, "the robot has no joints that move");
  IkResult best;
  best.position_error = best.orientation_error = 1e300;
  std::mt19937_64 random(1);
  std::vector<double> q(seed.begin(), seed.end());
  const bool far_away = norm(target.position - chain.reach_center()) > chain.reach() + options.position_tolerance;
  for (int k = 0; k <= (far_away ? 0 : options.restarts); ++k) {
    if (descend(chain, target, q, seed, options, best)) return solved(chain, target, std::move(q), options);
    q = random_state(chain, random);
  }
  return explain(chain, target, seed, options, std::move(best));
}

std::vector<std::vector<double>> find_solutions(const Chain& chain, const Pose& target,
                                                std::span<const double> rank_from, const IkOptions& options) {
  std::vector<std::vector<double>> out;
  if (!finite(target) || chain.joints() == 0 || norm(target.position - chain.reach_center()) > chain.reach() + 1e-9)
    return out;
  std::mt19937_64 random(2);
  std::vector<double> q(rank_from.begin(), rank_from.end());
  IkResult ignored;
  ignored.position_error = ignored.orientation_error = 1e300;
  for (int k = 0; k <= options.restarts; ++k) {
    if (descend(chain, target, q, rank_from, options, ignored) &&
        std::none_of(out.begin(), out.end(), [&](const auto& other) { return distance(other, q) < 1e-3; }))
      out.push_back(q);
    q = random_state(chain, random);
  }
  std::stable_sort(out.begin(), out.end(),
                   [&](const auto& a, const auto& b) { return distance(a, rank_from) < distance(b, rank_from); });
  return out;
}

IkResult solve_nearest(const Chain& chain, const Pose& target, std::span<const double> current,
                       std::span<const double> home, const IkOptions& options) {
  if (!finite(target)) return refused(current, "the pose has values that are no numbers");
  constexpr double kNear = 1.6;  // rad: the same configuration, going by how far a joint turns
  IkResult ignored;
  ignored.position_error = ignored.orientation_error = 1e300;
  for (const std::span<const double> seed : {current, home}) {
    std::vector<double> q(seed.begin(), seed.end());
    if (!descend(chain, target, q, current, options, ignored)) continue;
    double biggest = 0;
    for (std::size_t j = 0; j < q.size(); ++j) biggest = std::max(biggest, std::abs(q[j] - current[j]));
    if (biggest < kNear) return solved(chain, target, std::move(q), options);
  }
  std::vector<std::vector<double>> found = find_solutions(chain, target, current, options);
  if (found.empty()) return solve_inverse(chain, target, current, options);
  const auto rank = [&](const std::vector<double>& q) { return distance(q, current) + 0.5 * distance(q, home); };
  const auto best = std::min_element(found.begin(), found.end(),
                                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  return solved(chain, target, *best, options);
}

}  // namespace polyarm::kinematics
