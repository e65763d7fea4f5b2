#pragma once
/// Paths for tests of timing, with exact derivatives.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "polyarm/paths/path.hpp"

namespace polyarm::test {

/// Polynomials between breaks: coefficients[piece][joint][power of s, from the start of the piece].
class PolynomialPath final : public paths::Path {
 public:
  using Coefficients = std::vector<std::vector<std::vector<double>>>;
  PolynomialPath(std::vector<double> breaks, Coefficients coefficients)
      : breaks_(std::move(breaks)), joints_(coefficients.front().size()) {
    for (const auto& piece : coefficients)
      for (const auto& joint : piece) terms_ = std::max(terms_, joint.size());
    for (const auto& piece : coefficients)
      for (const auto& joint : piece) {
        flat_.insert(flat_.end(), joint.begin(), joint.end());
        flat_.resize(flat_.size() + terms_ - joint.size());
      }
  }
  std::size_t joints() const noexcept override { return joints_; }
  double length() const noexcept override { return breaks_.back(); }
  std::span<const double> breaks() const noexcept override { return breaks_; }
  void at(double s, const paths::PathDerivatives& out) const noexcept override {
    s = std::clamp(s, 0.0, length());
    const auto next = std::upper_bound(breaks_.begin(), breaks_.end() - 1, s);
    const auto piece = std::size_t(next - breaks_.begin()) - 1;
    const double x = s - breaks_[piece];
    for (std::size_t j = 0; j < joints_; ++j) {
      const double* c = &flat_[(piece * joints_ + j) * terms_];
      double q = 0, d1 = 0, d2 = 0, d3 = 0;
      for (std::size_t k = terms_; k-- > 0;) {
        d3 = d3 * x + d2, d2 = d2 * x + d1, d1 = d1 * x + q;
        q = q * x + c[k];
      }
      if (!out.q.empty()) out.q[j] = q;
      if (!out.first.empty()) out.first[j] = d1;
      if (!out.second.empty()) out.second[j] = 2 * d2;
      if (!out.third.empty()) out.third[j] = 6 * d3;
    }
  }

 private:
  std::vector<double> breaks_, flat_;
  std::size_t joints_, terms_ = 0;
};

/// A natural cubic spline through points; s runs over the sum of the chord lengths.
inline std::shared_ptr<const paths::Path> cubic_spline(const std::vector<std::vector<double>>& points) {
  const std::size_t n = points.size() - 1, joints = points.front().size();
  std::vector<double> s{0};
  for (std::size_t i = 0; i < n; ++i) {
    double square = 0;
    for (std::size_t j = 0; j < joints; ++j) square += std::pow(points[i + 1][j] - points[i][j], 2);
    s.push_back(s.back() + std::sqrt(square));
  }
  PolynomialPath::Coefficients c(n, std::vector<std::vector<double>>(joints));
  for (std::size_t j = 0; j < joints; ++j) {
    std::vector<double> second(n + 1, 0.0), diagonal(n + 1, 1.0), right(n + 1, 0.0);
    for (std::size_t i = 1; i < n; ++i) {
      const double before = s[i] - s[i - 1], after = s[i + 1] - s[i];
      const double factor = i > 1 ? before / diagonal[i - 1] : 0;
      diagonal[i] = 2 * (before + after) - factor * before;
      right[i] =
          6 * ((points[i + 1][j] - points[i][j]) / after - (points[i][j] - points[i - 1][j]) / before) -
          factor * right[i - 1];
    }
    for (std::size_t i = n - 1; i > 0; --i)
      second[i] = (right[i] - (i + 1 < n ? (s[i + 1] - s[i]) * second[i + 1] : 0)) / diagonal[i];
    for (std::size_t i = 0; i < n; ++i) {
      const double h = s[i + 1] - s[i];
      c[i][j] = {points[i][j],
                 (points[i + 1][j] - points[i][j]) / h - h * (2 * second[i] + second[i + 1]) / 6,
                 second[i] / 2, (second[i + 1] - second[i]) / (6 * h)};
    }
  }
  return std::make_shared<PolynomialPath>(s, c);
}

/// A spline through random points within ±spread.
inline std::shared_ptr<const paths::Path> random_spline(std::size_t joints, std::size_t points,
                                                        std::uint64_t seed, double spread = 1.5) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> draw(-spread, spread);
  std::vector<std::vector<double>> all(points, std::vector<double>(joints));
  for (auto& p : all)
    for (double& x : p) x = draw(engine);
  return cubic_spline(all);
}

/// q_j = amplitude_j · sin(2π f_j s + phase_j) + drift_j · s, without breaks inside.
class SinePath final : public paths::Path {
 public:
  struct Wave {
    double amplitude, omega, phase, drift;
  };
  SinePath(double length, std::vector<Wave> waves) : breaks_{0, length}, waves_(std::move(waves)) {}
  std::size_t joints() const noexcept override { return waves_.size(); }
  double length() const noexcept override { return breaks_[1]; }
  std::span<const double> breaks() const noexcept override { return breaks_; }
  void at(double s, const paths::PathDerivatives& out) const noexcept override {
    s = std::clamp(s, 0.0, length());
    for (std::size_t j = 0; j < waves_.size(); ++j) {
      const Wave& w = waves_[j];
      const double x = w.omega * s + w.phase, sine = w.amplitude * std::sin(x),
                   cosine = w.amplitude * std::cos(x);
      if (!out.q.empty()) out.q[j] = sine + w.drift * s;
      if (!out.first.empty()) out.first[j] = cosine * w.omega + w.drift;
      if (!out.second.empty()) out.second[j] = -sine * w.omega * w.omega;
      if (!out.third.empty()) out.third[j] = -cosine * w.omega * w.omega * w.omega;
    }
  }

 private:
  std::vector<double> breaks_;
  std::vector<Wave> waves_;
};

inline std::shared_ptr<const paths::Path> random_sines(std::size_t joints, double length,
                                                       std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> draw(0, 1);
  std::vector<SinePath::Wave> waves;
  for (std::size_t j = 0; j < joints; ++j)
    waves.push_back({draw(engine), (1 + 8 * draw(engine)) / length, 6.3 * draw(engine), draw(engine) - 0.5});
  return std::make_shared<SinePath>(length, waves);
}

inline std::shared_ptr<const paths::Path> straight_line(const std::vector<double>& from,
                                                        const std::vector<double>& to, double length) {
  PolynomialPath::Coefficients c(1);
  for (std::size_t j = 0; j < from.size(); ++j) c[0].push_back({from[j], (to[j] - from[j]) / length});
  return std::make_shared<PolynomialPath>(std::vector<double>{0, length}, c);
}

/// Lines through points. Each corner is rounded over `cut` on both sides by a quartic in s whose curvature is
/// zero at its ends.
inline std::shared_ptr<const paths::Path> blended_lines(const std::vector<std::vector<double>>& points,
                                                        double cut) {
  const std::size_t joints = points.front().size();
  std::vector<double> breaks{0};
  PolynomialPath::Coefficients c;
  const auto direction = [&](std::size_t i, double& way) {
    std::vector<double> d(joints);
    double square = 0;
    for (std::size_t j = 0; j < joints; ++j) d[j] = points[i + 1][j] - points[i][j], square += d[j] * d[j];
    way = std::sqrt(square);
    for (double& x : d) x /= way;
    return d;
  };
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    double way = 0;
    const std::vector<double> d = direction(i, way);
    const double from = i > 0 ? cut : 0, to = i + 2 < points.size() ? cut : 0;
    std::vector<std::vector<double>> line(joints);
    for (std::size_t j = 0; j < joints; ++j) line[j] = {points[i][j] + from * d[j], d[j]};
    c.push_back(line), breaks.push_back(breaks.back() + way - from - to);
    if (i + 2 == points.size()) break;
    double unused = 0;
    const std::vector<double> next = direction(i + 1, unused);
    // q'' = k x (h - x), which turns the direction d into next over h and ends on the next line.
    const double h = 2 * cut;
    std::vector<std::vector<double>> blend(joints);
    for (std::size_t j = 0; j < joints; ++j) {
      const double k = (next[j] - d[j]) * 6 / (h * h * h);
      blend[j] = {points[i + 1][j] - cut * d[j], d[j], 0, k * h / 6, -k / 12};
    }
    c.push_back(blend), breaks.push_back(breaks.back() + h);
  }
  return std::make_shared<PolynomialPath>(breaks, c);
}

}  // namespace polyarm::test
