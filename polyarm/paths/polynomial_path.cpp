#include "polyarm/paths/polynomial_path.hpp"

#include <algorithm>
#include <cassert>

#include "polyarm/paths/hermite.hpp"

namespace polyarm::paths {

PolynomialPath::PolynomialPath(std::span<const double> start) : start_(start.begin(), start.end()) {}

void PolynomialPath::append(double length, std::span<const double> coefficients, PieceJoin join) {
  assert(length > 0 && coefficients.size() == joints() * kCoefficients);
  const double begin = breaks_.back();
  begins_.push_back(begin);
  lengths_.push_back(length);
  coefficients_.insert(coefficients_.end(), coefficients.begin(), coefficients.end());
  if (begins_.size() > 1 && join == PieceJoin::third_jumps) breaks_.push_back(begin);
  breaks_.back() = begin + length;
}

void PolynomialPath::at(double s, const PathDerivatives& out) const noexcept {
  const auto fill = [](std::span<double> values, std::size_t j, double value) {
    if (!values.empty()) values[j] = value;
  };
  if (begins_.empty()) {
    for (std::size_t j = 0; j < joints(); ++j) {
      fill(out.q, j, start_[j]);
      for (std::span<double> values : {out.first, out.second, out.third}) fill(values, j, 0);
    }
    return;
  }
  s = std::clamp(s, 0.0, length());
  const auto after = std::upper_bound(begins_.begin() + 1, begins_.end(), s);
  const std::size_t piece = static_cast<std::size_t>(after - begins_.begin()) - 1;
  const double tau = std::min((s - begins_[piece]) / lengths_[piece], 1.0);
  for (std::size_t j = 0; j < joints(); ++j) {
    const double* c = coefficients_.data() + (piece * joints() + j) * kCoefficients;
    const Jet<double> at = polynomial_at(c, kCoefficients, tau, lengths_[piece]);
    fill(out.q, j, at.value);
    fill(out.first, j, at.first);
    fill(out.second, j, at.second);
    fill(out.third, j, at.third);
  }
}

}  // namespace polyarm::paths
