#include "polyarm/calibration/fit.hpp"

#include <numeric>

#include "polyarm/base/error.hpp"

namespace polyarm::calibration {

namespace {
/// The continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8), by Lentz's method.
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  double c = 1, d = 1 - (a + b) * x / (a + 1);
  d = 1 / (std::abs(d) < kTiny ? kTiny : d);
  double out = d;
  for (int m = 1; m <= 300; ++m) {
    for (const double term : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                              -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1 + term * d;
      d = 1 / (std::abs(d) < kTiny ? kTiny : d);
      c = 1 + term / c;
      if (std::abs(c) < kTiny) c = kTiny;
      out *= c * d;
    }
    if (std::abs(c * d - 1) < 1e-14) break;
  }
  return out;
}

/// The regularised incomplete beta function.
double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}
}  // namespace

void refuse(const std::string& why, const std::string& advice) {
  throw Error("bad-points", why, advice);
}

double f_exceeds(double f, double d1, double d2) {
  if (!(f > 0)) return 1;
  return incomplete_beta(d2 / 2, d1 / 2, d2 / (d2 + d1 * f));
}

double variance_of(const Fit& fit) {
  const auto freedom = static_cast<double>(fit.jacobian.rows() - fit.jacobian.cols());
  return freedom > 0 ? fit.cost() / freedom : 0;
}

Matrix covariance_of(const Fit& fit, double variance) {
  const Matrix normal = fit.jacobian.transpose() * fit.jacobian;
  return variance * normal.completeOrthogonalDecomposition().pseudoInverse();
}

std::optional<Outlier> find_outlier(const std::vector<double>& each, double numbers_of_one, double unknowns,
                                    const std::function<std::optional<double>(std::size_t)>& cost_without) {
  constexpr std::size_t kTried = 5;
  constexpr double kChance = 0.01;
  const auto samples = static_cast<double>(each.size());
  const double cost = std::accumulate(each.begin(), each.end(), 0.0);
  const double left = numbers_of_one * (samples - 1) - unknowns;  // degrees of freedom without it
  if (left < 2 || cost < 1e-20 * samples) return std::nullopt;
  std::vector<std::size_t> order(each.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return each[a] > each[b]; });
  order.resize(std::min(order.size(), kTried));
  std::optional<Outlier> worst;
  for (const std::size_t k : order) {
    const std::optional<double> rest = cost_without(k);
    if (!rest) continue;
    const double without = std::max(*rest, 1e-12 * cost);
    const double f = (cost - without) / numbers_of_one / (without / left);
    const double chance = samples * f_exceeds(f, numbers_of_one, left);
    if (worst && worst->chance <= chance) continue;
    worst = Outlier{k, chance, std::sqrt(cost / samples) / std::sqrt(without / (samples - 1))};
  }
  return worst && worst->chance < kChance ? worst : std::nullopt;
}

Residuals summarised(std::vector<Residual> each) {
  Residuals out;
  for (const Residual& one : each) {
    out.rms.position += one.position * one.position;
    out.rms.rotation += one.rotation * one.rotation;
    out.largest.position = std::max(out.largest.position, one.position);
    out.largest.rotation = std::max(out.largest.rotation, one.rotation);
  }
  const double n = std::max<double>(1, static_cast<double>(each.size()));
  out.rms = {std::sqrt(out.rms.position / n), std::sqrt(out.rms.rotation / n)};
  out.each = std::move(each);
  return out;
}

}  // namespace polyarm::calibration
