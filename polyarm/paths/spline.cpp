#include "polyarm/paths/spline.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "polyarm/paths/hermite.hpp"

namespace polyarm::paths {
namespace {

constexpr int kRounds = 4;  // rounds of measuring the pieces; the lengths then agree to a few percent

class Fit {
 public:
  Fit(std::span<const double> points, std::size_t dimensions, std::span<const double> weights)
      : points_(points), dimensions_(dimensions), count_(points.size() / dimensions), weights_(weights) {}

  std::vector<double> chords() const {
    std::vector<double> out(count_ - 1);
    for (std::size_t i = 0; i + 1 < count_; ++i) {
      double sum = 0;
      for (std::size_t d = 0; d < dimensions_; ++d) {
        const double way = weight(d) * (point(i + 1, d) - point(i, d));
        sum += way * way;
      }
      out[i] = std::sqrt(sum);
    }
    return out;
  }

  CubicSpline through(std::span<const double> gaps) const {
    CubicSpline out;
    out.knots.assign(1, 0.0);
    for (const double gap : gaps) out.knots.push_back(out.knots.back() + gap);
    out.value.assign(points_.begin(), points_.end());
    out.first.resize(points_.size());
    out.second.resize(points_.size());
    for (std::size_t d = 0; d < dimensions_; ++d) solve(gaps, d, out);
    return out;
  }

  /// The length of a piece, by Gauss's rule of five points on both halves.
  double length_of(const CubicSpline& spline, std::size_t i, double gap) const {
    constexpr std::array<double, 5> kAt{-0.906179845938664, -0.538469310105683, 0, 0.538469310105683,
                                        0.906179845938664};
    constexpr std::array<double, 5> kWeight{0.236926885056189, 0.478628670499366, 0.568888888888889,
                                            0.478628670499366, 0.236926885056189};
    double sum = 0;
    for (const double middle : {0.25, 0.75})
      for (std::size_t k = 0; k < kAt.size(); ++k)
        sum += kWeight[k] * gap / 4 * speed(spline, i, gap, middle + kAt[k] / 4);
    return sum;
  }

 private:
  double point(std::size_t i, std::size_t d) const { return points_[i * dimensions_ + d]; }
  double weight(std::size_t d) const { return weights_.empty() ? 1.0 : weights_[d]; }

  double speed(const CubicSpline& spline, std::size_t i, double gap, double tau) const {
    double sum = 0;
    for (std::size_t d = 0; d < dimensions_; ++d) {
      const std::size_t at = i * dimensions_ + d, next = at + dimensions_;
      const double slope = weight(d) * (spline.first[at] + tau * gap * spline.second[at] +
                                        tau * tau * gap / 2 * (spline.second[next] - spline.second[at]));
      sum += slope * slope;
    }
    return std::sqrt(sum);
  }

  /// First the second derivatives, from the tridiagonal equations of continuity; then the first derivatives.
  void solve(std::span<const double> gaps, std::size_t d, CubicSpline& out) const {
    const std::size_t last = count_ - 1;
    std::vector<double> upper(count_, 0.0), right(count_, 0.0);
    const auto slope = [&](std::size_t i) { return (point(i + 1, d) - point(i, d)) / gaps[i]; };
    for (std::size_t i = 1; i < last; ++i) {
      const double pivot = 2 * (gaps[i - 1] + gaps[i]) - gaps[i - 1] * upper[i - 1];
      upper[i] = gaps[i] / pivot;
      right[i] = (6 * (slope(i) - slope(i - 1)) - gaps[i - 1] * right[i - 1]) / pivot;
    }
    const auto second = [&](std::size_t i) -> double& { return out.second[i * dimensions_ + d]; };
    second(0) = second(last) = 0;
    for (std::size_t i = last; i-- > 1;) second(i) = right[i] - upper[i] * second(i + 1);
    for (std::size_t i = 0; i < last; ++i)
      out.first[i * dimensions_ + d] = slope(i) - gaps[i] / 6 * (2 * second(i) + second(i + 1));
    out.first[last * dimensions_ + d] = slope(last - 1) + gaps[last - 1] / 6 * (second(last - 1));
  }

  std::span<const double> points_;
  std::size_t dimensions_, count_;
  std::span<const double> weights_;
};

}  // namespace

CubicSpline cubic_spline(std::span<const double> points, std::size_t dimensions,
                         std::span<const double> weights, std::span<const double> shortest) {
  const Fit fit(points, dimensions, weights);
  const std::vector<double> chords = fit.chords();
  const auto at_least = [&](std::size_t i, double gap) {
    return shortest.empty() ? gap : std::max(gap, shortest[i]);
  };
  std::vector<double> gaps = chords;
  for (std::size_t i = 0; i < gaps.size(); ++i) gaps[i] = at_least(i, gaps[i]);
  CubicSpline spline = fit.through(gaps);
  for (int round = 0; round < kRounds && gaps.size() > 1; ++round) {
    // A piece that reverses may be much longer than its chord. This limits its length.
    for (std::size_t i = 0; i < gaps.size(); ++i)
      gaps[i] = at_least(i, std::clamp(fit.length_of(spline, i, gaps[i]), chords[i], 2 * chords[i]));
    spline = fit.through(gaps);
  }
  return spline;
}

}  // namespace polyarm::paths
