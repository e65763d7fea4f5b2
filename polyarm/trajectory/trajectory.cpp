#include "polyarm/trajectory/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pair.hpp"

namespace polyarm::trajectory {

void Trajectory::append(double duration, std::span<const double> coefficients) {
  if (!(duration > 0) || !std::isfinite(duration))
    throw Error("bad-trajectory",
                "a segment lasts " + std::to_string(duration) + " s; it must last longer than 0");
  if (coefficients.size() != joints_ * kCoefficients)
    throw Error("bad-trajectory", "a segment has " + std::to_string(coefficients.size()) + " coefficients; " +
                                      std::to_string(joints_) + " joints need " +
                                      std::to_string(joints_ * kCoefficients));
  for (std::size_t k = 0; k < kCoefficients; ++k)
    for (std::size_t j = 0; j < joints_; ++j) coefficients_.push_back(coefficients[j * kCoefficients + k]);
  ends_.push_back(this->duration() + duration);
}

void Trajectory::set_piece(std::size_t segment, std::size_t joint,
                           std::span<const double> coefficients) noexcept {
  for (std::size_t k = 0; k < kCoefficients; ++k)
    coefficients_[(segment * kCoefficients + k) * joints_ + joint] = coefficients[k];
}

void Trajectory::shift(std::size_t joint, double offset) noexcept {
  for (std::size_t i = joint; i < coefficients_.size(); i += joints_ * kCoefficients)
    coefficients_[i] += offset;
}

namespace {
/// The polynomials of some joints at one time. Each joint has the same operations in the same order for any
/// number of joints, so the bits are equal.
template <typename Number>
struct Polynomials {
  Number c0, c1, c2, c3, c4, c5;
  Number position(double x) const noexcept { return c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5)))); }
  Number velocity(double x) const noexcept {
    return c1 + x * (2 * c2 + x * (3 * c3 + x * (4 * c4 + x * 5 * c5)));
  }
  Number acceleration(double x) const noexcept { return 2 * c2 + x * (6 * c3 + x * (12 * c4 + x * 20 * c5)); }
};

/// `c` is [power][joint], of n joints.
inline Polynomials<Pair> pair_at(const double* c, std::size_t n) noexcept {
  return {load_pair(c),         load_pair(c + n),     load_pair(c + 2 * n),
          load_pair(c + 3 * n), load_pair(c + 4 * n), load_pair(c + 5 * n)};
}
inline Polynomials<double> one_at(const double* c, std::size_t n) noexcept {
  return {c[0], c[n], c[2 * n], c[3 * n], c[4 * n], c[5 * n]};
}

void sample_all(const double* c, std::size_t n, double x, double* position, double* velocity,
                double* acceleration) noexcept {
  std::size_t j = 0;
  for (; j + 2 <= n; j += 2) {
    const Polynomials<Pair> p = pair_at(c + j, n);
    store_pair(position + j, p.position(x));
    store_pair(velocity + j, p.velocity(x));
    store_pair(acceleration + j, p.acceleration(x));
  }
  if (j == n) return;
  const Polynomials<double> p = one_at(c + j, n);
  position[j] = p.position(x);
  velocity[j] = p.velocity(x);
  acceleration[j] = p.acceleration(x);
}

template <typename Of>
void sample_one(const double* c, std::size_t n, std::span<double> out, Of of) noexcept {
  for (std::size_t j = 0; j < n; ++j) out[j] = of(one_at(c + j, n));
}
}  // namespace

void Trajectory::sample(double t, std::span<double> position, std::span<double> velocity,
                        std::span<double> acceleration, std::size_t& hint) const noexcept {
  if (ends_.empty()) return;
  const std::size_t last = ends_.size() - 1;
  const auto begin_of = [&](std::size_t i) { return i == 0 ? 0.0 : ends_[i - 1]; };
  const auto holds = [&](std::size_t i) {
    return (t >= begin_of(i) || i == 0) && (t < ends_[i] || i == last);
  };
  std::size_t i = std::min(hint, last);
  if (!holds(i) && i < last && t >= ends_[i]) ++i;  // usually the next one; else searches all
  if (!holds(i))
    i = std::min(last,
                 static_cast<std::size_t>(std::upper_bound(ends_.begin(), ends_.end(), t) - ends_.begin()));
  if (std::isnan(t)) i = 0;
  hint = i;
  const bool outside = !(t >= 0) || t > ends_[last];
  const double x = !(t >= 0) ? 0.0 : std::min(t, ends_[i]) - begin_of(i);
  const double* c = coefficients_.data() + i * joints_ * kCoefficients;
  if (!position.empty() && !velocity.empty() && !acceleration.empty() && !outside)
    return sample_all(c, joints_, x, position.data(), velocity.data(), acceleration.data());
  if (!position.empty()) sample_one(c, joints_, position, [x](const auto& p) { return p.position(x); });
  if (outside) {
    std::fill_n(velocity.begin(), velocity.empty() ? 0 : joints_, 0.0);
    std::fill_n(acceleration.begin(), acceleration.empty() ? 0 : joints_, 0.0);
    return;
  }
  if (!velocity.empty()) sample_one(c, joints_, velocity, [x](const auto& p) { return p.velocity(x); });
  if (!acceleration.empty())
    sample_one(c, joints_, acceleration, [x](const auto& p) { return p.acceleration(x); });
}

}  // namespace polyarm::trajectory
