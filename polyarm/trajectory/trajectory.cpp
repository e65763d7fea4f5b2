#include "polyarm/trajectory/trajectory.hpp"

#include <algorithm>
#include <cassert>

namespace polyarm::trajectory {

void Trajectory::append(double duration, std::span<const double> coefficients) {
  assert(duration > 0 && coefficients.size() == joints_ * kCoefficients);
  ends_.push_back((ends_.empty() ? 0.0 : ends_.back()) + duration);
  coefficients_.insert(coefficients_.end(), coefficients.begin(), coefficients.end());
}

void Trajectory::sample(double t, std::span<double> position, std::span<double> velocity,
                        std::span<double> acceleration, std::size_t& hint) const noexcept {
  if (ends_.empty()) return;
  const std::size_t last = ends_.size() - 1;
  std::size_t i = std::min(hint, last);
  while (i < last && t > ends_[i]) ++i;
  while (i > 0 && t <= ends_[i - 1]) --i;
  hint = i;
  const double begin = i == 0 ? 0.0 : ends_[i - 1];
  const bool outside = t <= 0 || t >= ends_[last];
  const double x = std::clamp(t, begin, ends_[i]) - begin;
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
