#pragma once
/// Dense linear algebra in the sizes that GeneralSix needs, row-major. Private to GeneralSix. The same in
/// Eigen takes a minute to compile. Nothing here allocates.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace polyarm::kinematics {

template <std::size_t kRows, std::size_t kColumns>
using Grid = std::array<std::array<double, kColumns>, kRows>;

template <std::size_t N>
double inner(const std::array<double, N>& a, const std::array<double, N>& b) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
  return sum;
}
/// to += part * what
template <std::size_t N>
void add_part(double part, const std::array<double, N>& what, std::array<double, N>& to) noexcept {
  for (std::size_t i = 0; i < N; ++i) to[i] += part * what[i];
}

/// Twelve equations, solved by elimination with the largest pivot of each column.
class TwelveEquations {
 public:
  explicit TwelveEquations(const Grid<12, 12>& rows) noexcept : upper_(rows) {
    for (std::size_t k = 0; k < 12; ++k) {
      std::size_t at = k;
      for (std::size_t i = k + 1; i < 12; ++i)
        if (std::abs(upper_[i][k]) > std::abs(upper_[at][k])) at = i;
      std::swap(upper_[k], upper_[at]);
      std::swap(lower_[k], lower_[at]);
      from_[k] = at;
      if (upper_[k][k] == 0) continue;
      for (std::size_t i = k + 1; i < 12; ++i) {
        lower_[i][k] = upper_[i][k] / upper_[k][k];
        add_part(-lower_[i][k], upper_[k], upper_[i]);
      }
    }
  }
  /// The smallest pivot relative to the largest.
  double least_pivot() const noexcept {
    double least = std::abs(upper_[0][0]), most = least;
    for (std::size_t k = 1; k < 12; ++k) {
      least = std::min(least, std::abs(upper_[k][k]));
      most = std::max(most, std::abs(upper_[k][k]));
    }
    return least / most;
  }
  /// Replaces right sides by solutions; not finite if a pivot is zero.
  template <std::size_t N>
  void solve(Grid<12, N>& b) const noexcept {
    for (std::size_t k = 0; k < 12; ++k) {
      std::swap(b[k], b[from_[k]]);
      for (std::size_t i = 0; i < k; ++i) add_part(-lower_[k][i], b[i], b[k]);
    }
    for (std::size_t k = 12; k-- > 0;) {
      for (std::size_t i = k + 1; i < 12; ++i) add_part(-upper_[k][i], b[i], b[k]);
      for (double& value : b[k]) value /= upper_[k][k];
    }
  }

 private:
  Grid<12, 12> upper_, lower_{};
  std::array<std::size_t, 12> from_;  ///< the original row at this position
};

/// Fourteen equations for eight unknowns, by reflections with the largest remaining column first.
class FourteenForEight {
 public:
  using Column = std::array<double, 14>;
  /// Takes the columns of the unknowns.
  void take(std::array<Column, 8> columns) noexcept {
    double most = 0;
    rank_ = 0;
    for (std::size_t k = 0; k < 8; ++k) order_[k] = k;
    for (std::size_t k = 0; k < 8; ++k) {
      std::size_t at = k;
      double largest = -1;
      for (std::size_t j = k; j < 8; ++j) {
        double square = 0;
        for (std::size_t f = k; f < 14; ++f) square += columns[j][f] * columns[j][f];
        if (square > largest) largest = square, at = j;
      }
      most = std::max(most, largest);
      if (!(largest > kNone * most)) break;
      std::swap(columns[k], columns[at]);
      std::swap(order_[k], order_[at]);
      reflect(columns, k, std::sqrt(largest));
      ++rank_;
    }
    upper_ = columns;
  }
  /// Transforms rows so that all but the first eight are free of the unknowns.
  template <std::size_t N>
  void turn(Grid<14, N>& rows) const noexcept {
    for (std::size_t k = 0; k < rank_; ++k) {
      std::array<double, N> along{};
      for (std::size_t f = k; f < 14; ++f) add_part(normal_[k][f], rows[f], along);
      for (std::size_t f = k; f < 14; ++f) add_part(-normal_[k][f], along, rows[f]);
    }
  }
  /// The least-squares solution for `b`; unknowns that the columns do not determine are zero.
  std::array<double, 8> solve(Column b) const noexcept {
    for (std::size_t k = 0; k < rank_; ++k) add_part(-inner(normal_[k], b), normal_[k], b);
    std::array<double, 8> x{};
    for (std::size_t k = rank_; k-- > 0;) {
      const double value = x[order_[k]] = b[k] / upper_[k][k];
      for (std::size_t i = 0; i < k; ++i) b[i] -= upper_[k][i] * value;
    }
    return x;
  }

 private:
  static constexpr double kNone = 1e-32;  ///< of the largest column's square: below this it is rounding

  /// Moves column k, with length `size` from row k on, into place and transforms the others with it.
  void reflect(std::array<Column, 8>& columns, std::size_t k, double size) noexcept {
    Column& normal = normal_[k];
    normal = columns[k];
    std::fill_n(normal.begin(), k, 0.0);
    const double to = normal[k] > 0 ? -size : size;
    normal[k] -= to;
    const double scale = 1 / std::sqrt(size * std::abs(normal[k]));  // makes the square 2
    for (double& value : normal) value *= scale;
    columns[k][k] = to;
    for (std::size_t j = k + 1; j < 8; ++j) add_part(-inner(normal, columns[j]), normal, columns[j]);
  }

  std::array<Column, 8> normal_, upper_;
  std::array<std::size_t, 8> order_;
  std::size_t rank_ = 0;
};

/// Makes `v` a unit vector perpendicular to the first `count` vectors of `basis`; if it lies in their span,
/// any such vector.
template <std::size_t N, std::size_t kMost>
void make_square_to(const std::array<std::array<double, N>, kMost>& basis, std::size_t count,
                    std::array<double, N>& v) noexcept {
  double size = std::sqrt(inner(v, v));
  for (std::size_t round = 0; round < 2 * N; ++round) {
    if (!(size > 0)) v = {}, v[round % N] = size = 1;
    for (double& value : v) value /= size;
    for (std::size_t k = 0; k < count; ++k) add_part(-inner(basis[k], v), basis[k], v);
    size = std::sqrt(inner(v, v));
    if (size > 0.7) break;  // the remaining parts along the others are rounding errors
  }
  for (double& value : v) value /= size;
}

}  // namespace polyarm::kinematics
