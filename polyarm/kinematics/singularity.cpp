#include "polyarm/kinematics/singularity.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace polyarm::kinematics {

namespace {

using Square = std::array<std::array<double, 6>, 6>;

/// One rotation of Jacobi's method: makes a[p][q] zero.
void rotate(Square& a, std::size_t p, std::size_t q) {
  if (std::abs(a[p][q]) < 1e-300) return;
  const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
  const double c = 1 / std::sqrt(t * t + 1), s = t * c;
  for (std::size_t k = 0; k < 6; ++k) {
    const double x = a[k][p], y = a[k][q];
    a[k][p] = c * x - s * y;
    a[k][q] = s * x + c * y;
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const double x = a[p][k], y = a[q][k];
    a[p][k] = c * x - s * y;
    a[q][k] = s * x + c * y;
  }
}

/// The smallest eigenvalue of a symmetric matrix, by Jacobi's cyclic method (Golub and Van Loan, Matrix
/// Computations, section 8.5).
double smallest_eigenvalue(Square a) {
  constexpr int kSweeps = 8;
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (std::size_t p = 0; p < 5; ++p)
      for (std::size_t q = p + 1; q < 6; ++q) rotate(a, p, q);
  double least = a[0][0];
  for (std::size_t i = 1; i < 6; ++i) least = std::min(least, a[i][i]);
  return least;
}

}  // namespace

double smallest_singular_value(const Chain& chain, std::span<const double> q) {
  const std::size_t n = chain.joints();
  std::array<double, 6 * Chain::kMaxJoints> jacobian;
  chain.jacobian(q, {jacobian.data(), 6 * n});
  const double length = std::isfinite(chain.reach()) && chain.reach() > 0 ? chain.reach() : 1.0;
  for (std::size_t k = 0; k < 3 * n; ++k) jacobian[k] /= length;
  std::array<std::size_t, Chain::kMaxJoints> columns;
  std::size_t used = 0;
  for (std::size_t k = 0; k < n; ++k)
    if (chain.moves_tcp(k)) columns[used++] = k;
  // Uses the smaller of J J^T and J^T J. With fewer than six joints the rest is filled with values that are
  // never the smallest.
  Square square{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) {
      double& cell = square[i][j];
      if (used >= 6) {
        for (std::size_t k = 0; k < used; ++k)
          cell += jacobian[i * n + columns[k]] * jacobian[j * n + columns[k]];
      } else if (i < used && j < used) {
        for (std::size_t k = 0; k < 6; ++k)
          cell += jacobian[k * n + columns[i]] * jacobian[k * n + columns[j]];
      } else if (i == j) {
        cell = 1e6;
      }
    }
  return used == 0 ? 0.0 : std::sqrt(std::max(0.0, smallest_eigenvalue(square)));
}

}  // namespace polyarm::kinematics
