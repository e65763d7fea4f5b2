#include "polyarm/kinematics/descent.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::kinematics {

namespace {

constexpr double kLargestStep = 0.8;  // rad or m in one iteration
constexpr double kDamping = 0.02;     // times the squared error
constexpr double kLeastDamping = 1e-12;
constexpr int kPatience = 8;         // iterations in a row that hardly improve
constexpr double kRounding = 1e-14;  // errors below this are noise

/// Solves a x = b for a symmetric positive definite 6 x 6 matrix by Cholesky's method; false where it is not
/// definite.
bool solve_definite(std::array<double, 36>& a, std::array<double, 6>& b) {
  for (int j = 0; j < 6; ++j) {
    for (int k = 0; k < j; ++k)
      for (int i = j; i < 6; ++i) a[6 * i + j] -= a[6 * i + k] * a[6 * j + k];
    if (!(a[7 * j] > 0)) return false;
    const double scale = 1 / std::sqrt(a[7 * j]);
    for (int i = j; i < 6; ++i) a[6 * i + j] *= scale;
  }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= a[6 * i + k] * b[k];
    b[i] /= a[7 * i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) b[i] -= a[6 * k + i] * b[k];
    b[i] /= a[7 * i];
  }
  return true;
}

}  // namespace

PoseError Descent::measure(const JointState& q) {
  const std::size_t n = chain_.joints();
  const Pose now = chain_.jacobian({q.data(), n}, {jacobian_.data(), 6 * n});
  const Vec3 p = target_.position - now.position;
  const Vec3 r = weight_ > 0 ? to_rotation_vector(target_.rotation * inverse(now.rotation)) : Vec3{};
  twist_ = {p.x, p.y, p.z, weight_ * r.x, weight_ * r.y, weight_ * r.z};
  for (std::size_t k = 3 * n; k < 6 * n; ++k) jacobian_[k] *= weight_;
  const PoseError error{norm(p), norm(r)};
  size_ = std::hypot(error.position, weight_ * error.orientation);
  return error;
}

bool Descent::within_tolerance() const noexcept {
  return best_error_.position <= options_.position_tolerance &&
         best_error_.orientation <= options_.orientation_tolerance;
}

bool Descent::run(JointState& q, bool walls) {
  JointState best = q;
  best_size_ = 1e300;
  best_error_ = {};
  double last = 1e300;
  int stuck = 0;
  for (int i = 0; i < options_.iterations && stuck <= kPatience; ++i) {
    const PoseError error = measure(q);
    if (!std::isfinite(size_)) break;
    const bool better = size_ < best_size_;
    const bool polishing = within_tolerance();
    if (polishing && size_ > 0.5 * best_size_) break;
    if (better) {
      best_size_ = size_;
      best_error_ = error;
      best = q;
    }
    if (best_size_ < kRounding) break;
    stuck = size_ > 0.97 * last ? stuck + 1 : 0;
    last = size_;
    step(q, walls);
  }
  q = best;
  return within_tolerance();
}

bool Descent::solve(std::array<double, kMost>& dq) const {
  const std::size_t n = chain_.joints();
  std::array<double, 36> a;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < n; ++k) sum += jacobian_[i * n + k] * jacobian_[j * n + k];
      a[6 * i + j] = sum;
    }
  const double damping = kDamping * size_ * size_ + kLeastDamping;
  for (std::size_t i = 0; i < 6; ++i) a[7 * i] += damping;
  Twist x = twist_;
  if (!solve_definite(a, x)) return false;
  for (std::size_t k = 0; k < n; ++k) {
    dq[k] = 0;
    for (std::size_t i = 0; i < 6; ++i) dq[k] += jacobian_[i * n + k] * x[i];
  }
  return true;
}

/// Takes joints that stand at a limit and would go beyond it out of this step.
bool Descent::pin(const JointState& q, const std::array<double, kMost>& dq) {
  const std::size_t n = chain_.joints();
  bool any = false;
  for (std::size_t k = 0; k < n; ++k) {
    const bool beyond = (dq[k] > 0 && q[k] >= chain_.upper()[k]) || (dq[k] < 0 && q[k] <= chain_.lower()[k]);
    if (!beyond) continue;
    for (std::size_t i = 0; i < 6; ++i) jacobian_[i * n + k] = 0;
    any = true;
  }
  return any;
}

void Descent::step(JointState& q, bool walls) {
  const std::size_t n = chain_.joints();
  std::array<double, kMost> dq{};
  bool sound = solve(dq);
  while (walls && sound && pin(q, dq)) sound = solve(dq);
  if (!sound) return;
  double biggest = 0;
  for (std::size_t k = 0; k < n; ++k) biggest = std::max(biggest, std::abs(dq[k]));
  const double scale = biggest > kLargestStep ? kLargestStep / biggest : 1.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (!chain_.moves_tcp(k)) continue;
    q[k] += scale * dq[k];
    if (walls) q[k] = std::clamp(q[k], chain_.lower()[k], chain_.upper()[k]);
  }
}

double excess(const Chain& chain, const JointState& q, std::size_t i) {
  return std::max({0.0, chain.lower()[i] - q[i], q[i] - chain.upper()[i]});
}

void unwind(const Chain& chain, JointState& q, std::span<const double> near) {
  for (std::size_t i = 0; i < chain.joints(); ++i) {
    const double period = chain.period(i);
    if (!(period > 0) || !chain.moves_tcp(i)) continue;
    // Half a turn away is as near on either side; rounding must not decide which it is.
    q[i] += period * std::round((near[i] - q[i]) / period - 1e-9);
    if (q[i] < chain.lower()[i]) q[i] += period * std::ceil((chain.lower()[i] - q[i]) / period - 1e-12);
    if (q[i] > chain.upper()[i]) {
      const double down = period * std::ceil((q[i] - chain.upper()[i]) / period - 1e-12);
      const double over = q[i] - chain.upper()[i], under = chain.lower()[i] - (q[i] - down);
      if (under <= 1e-12 || under < over) q[i] -= down;
    }
  }
}

bool inside_limits(const Chain& chain, const JointState& q) {
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (chain.moves_tcp(i) && excess(chain, q, i) > 1e-12) return false;
  return true;
}

void scatter(const Chain& chain, JointState& q, Random& random) {
  for (std::size_t i = 0; i < chain.joints(); ++i)
    if (chain.moves_tcp(i)) q[i] = random_value(chain, i, random);
}

}  // namespace polyarm::kinematics
