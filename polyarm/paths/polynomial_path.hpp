#pragma once
/// A path of polynomial pieces. Lines, splines and the inverse kinematics of Cartesian paths produce it.
/// Joint values in rad or m.
#include <cstddef>
#include <span>
#include <vector>

#include "polyarm/paths/path.hpp"

namespace polyarm::paths {

/// Whether the third derivative is continuous with the previous piece.
enum class PieceJoin { third_jumps, third_continues };

/// Polynomials of degree at most kDegree, one for each joint in each piece. The caller ensures that the
/// pieces fit together. Built on any thread; then const, and at() allocates nothing.
class PolynomialPath final : public Path {
 public:
  static constexpr std::size_t kDegree = 7, kCoefficients = kDegree + 1;

  /// A path of length 0 at `start` (rad or m).
  explicit PolynomialPath(std::span<const double> start);

  /// Appends a piece of `length` > 0. `coefficients[j * kCoefficients + k]` belongs to joint j and power k of
  /// the fraction of the piece, from 0 at its start to 1 at its end.
  void append(double length, std::span<const double> coefficients, PieceJoin join = PieceJoin::third_jumps);

  std::size_t joints() const noexcept override { return start_.size(); }
  double length() const noexcept override { return breaks_.back(); }
  void at(double s, const PathDerivatives& out) const noexcept override;
  /// {0, 0} for a path without pieces.
  std::span<const double> breaks() const noexcept override { return breaks_; }
  std::size_t pieces() const noexcept { return lengths_.size(); }

 private:
  std::vector<double> start_;
  std::vector<double> begins_, lengths_;
  std::vector<double> coefficients_;  // [piece][joint][power]
  std::vector<double> breaks_{0, 0};
};

}  // namespace polyarm::paths
