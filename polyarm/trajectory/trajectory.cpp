#include "polyarm/trajectory/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/error.hpp"

namespace polyarm::trajectory {

void Trajectory::append(double duration, std::span<const double> coefficients) {
  if (!(duration > 0) || !std::isfinite(duration))
    throw Error("bad-trajectory",
                "a segment lasts " + std::to_string(duration) + " s; it must last longer than 0");
  if (coefficients.size() != joints_ * kCoefficients)
    throw Error("bad-trajectory", "a segment has " + std::to_string(coefficients.size()) + " coefficients; " +
                                      std::to_string(joints_) + " joints need " +
                                      std::to_string(joints_ * kCoefficients));
  coefficients_.insert(coefficients_.end(), coefficients.begin(), coefficients.end());
  ends_.push_back(this->duration() + duration);
}

void Trajectory::set_piece(std::size_t segment, std::size_t joint,
                           std::span<const double> coefficients) noexcept {
  std::copy_n(
      coefficients.begin(), kCoefficients,
      coefficients_.begin() + static_cast<std::ptrdiff_t>((segment * joints_ + joint) * kCoefficients));
}

void Trajectory::shift(std::size_t joint, double offset) noexcept {
  for (std::size_t i = joint * kCoefficients; i < coefficients_.size(); i += joints_ * kCoefficients)
    coefficients_[i] += offset;
}

void Trajectory::sample(double t, std::span<double> position, std::span<double> velocity,
                        std::span<double> acceleration, std::size_t& hint) const noexcept {
  if (ends_.empty()) return;
  const std::size_t last = ends_.size() - 1;
  const auto begin_of = [&](std::size_t i) { return i == 0 ? 0.0 : ends_[i - 1]; };
  const auto holds = [&](std::size_t i) {
    return (t >= begin_of(i) || i == 0) && (t < ends_[i] || i == last);
  };
  std::size_t i = std::min(hint, last);
  if (!holds(i) && i < last && t >= ends_[i]) ++i;  // the usual next one; else look everywhere
  if (!holds(i))
    i = std::min(last,
                 static_cast<std::size_t>(std::upper_bound(ends_.begin(), ends_.end(), t) - ends_.begin()));
  if (std::isnan(t)) i = 0;
  hint = i;
  const bool outside = !(t >= 0) || t > ends_[last];
  const double x = !(t >= 0) ? 0.0 : std::min(t, ends_[i]) - begin_of(i);
  const double* c = coefficients_.data() + i * joints_ * kCoefficients;
  for (std::size_t j = 0; j < joints_; ++j, c += kCoefficients) {
    if (!position.empty()) position[j] = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))));
    if (!velocity.empty())
      velocity[j] = outside ? 0.0 : c[1] + x * (2 * c[2] + x * (3 * c[3] + x * (4 * c[4] + x * 5 * c[5])));
    if (!acceleration.empty())
      acceleration[j] = outside ? 0.0 : 2 * c[2] + x * (6 * c[3] + x * (12 * c[4] + x * 20 * c[5]));
  }
}

}  // namespace polyarm::trajectory
