#pragma once
/// Nonlinear least squares, and statistics of its residuals. Private to this room.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/calibration/eigen_pose.hpp"

namespace polyarm::calibration {

[[noreturn]] void refuse(const std::string& why, const std::string& advice);

/// A least-squares fit at its minimum.
struct Fit {
  Matrix jacobian;
  Vector residual;
  double cost() const { return residual.squaredNorm(); }
};

/// Levenberg-Marquardt. `state` is moved by steps of `unknowns` numbers to the minimum of |residual|^2.
/// Derivatives are central differences: steps are metres and radians, so one step size suits all.
template <typename State, typename ResidualOf, typename Moved>
Fit fit(State& state, Eigen::Index unknowns, const ResidualOf& residual_of, const Moved& moved_by) {
  constexpr double kStep = 1e-6, kSmallest = 1e-13, kMostDamping = 1e10;
  constexpr int kRounds = 100;
  Fit out;
  out.residual = residual_of(state);
  const auto derive = [&] {
    out.jacobian.resize(out.residual.size(), unknowns);
    for (Eigen::Index k = 0; k < unknowns; ++k) {
      Vector step = Vector::Zero(unknowns);
      step[k] = kStep;
      const Vector up = residual_of(moved_by(state, step));
      step[k] = -kStep;
      out.jacobian.col(k) = (up - residual_of(moved_by(state, step))) / (2 * kStep);
    }
  };
  derive();
  double damping = 1e-8;
  for (int round = 0; round < kRounds && damping < kMostDamping; ++round) {
    const Matrix normal = out.jacobian.transpose() * out.jacobian;
    Matrix damped = normal;
    damped.diagonal() += damping * (normal.diagonal().array() + 1e-12).matrix();
    const Vector step = -damped.ldlt().solve(out.jacobian.transpose() * out.residual);
    if (!step.allFinite() || step.norm() < kSmallest) break;
    State next = moved_by(state, step);
    const Vector residual = residual_of(next);
    if (!(residual.squaredNorm() < out.cost())) {
      damping *= 10;
      continue;
    }
    const bool settled = out.cost() - residual.squaredNorm() < 1e-12 * out.cost();
    state = std::move(next);
    out.residual = residual;
    damping = std::max(damping / 10, 1e-12);
    derive();
    if (settled) break;
  }
  return out;
}

/// Variance of the residuals: cost per degree of freedom; 0 without any.
double variance_of(const Fit& fit);
/// Covariance of the unknowns: variance times the inverse of the normal matrix.
Matrix covariance_of(const Fit& fit, double variance);

/// The probability that a variable with the F distribution exceeds `f`.
double f_exceeds(double f, double d1, double d2);

/// The sample whose removal improves the fit more than chance allows. `each`: squared weighted residuals of
/// the samples, whose sum is `cost`. `cost_without(k)`: cost of a fit without sample k; empty if the others
/// do not determine it.
std::optional<Outlier> find_outlier(const std::vector<double>& each, double numbers_of_one, double unknowns,
                                    const std::function<std::optional<double>(std::size_t)>& cost_without);

/// Root mean square and largest values of `each`.
Residuals summarised(std::vector<Residual> each);

/// The span without element k.
template <typename T>
std::vector<T> without(const std::vector<T>& all, std::size_t k) {
  std::vector<T> out = all;
  out.erase(out.begin() + static_cast<std::ptrdiff_t>(k));
  return out;
}

}  // namespace polyarm::calibration
