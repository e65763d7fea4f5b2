#pragma once
/// The rows of limits during the solver's iterations, and the linear system of its steps. Part of solver.hpp;
/// not for the control cycle.
#include <array>
#include <cstddef>
#include <vector>

#include "polyarm/timing/jerk_pieces.hpp"
#include "polyarm/timing/kernels.hpp"
#include "polyarm/timing/solver.hpp"

namespace polyarm::timing {

using Basis = std::array<double, 3>;

/// The change of b and a at both ends of a piece along the three directions that touch it.
using Moves = std::array<Basis, 4>;
Moves moves_at(const JerkPieces& pieces, std::size_t piece);

/// A symmetric system with five diagonals.
class FiveDiagonals {
 public:
  explicit FiveDiagonals(std::size_t n) : d0_(n + 4), d1_(n + 4), d2_(n + 4), right_(n + 4) {}
  void clear();
  /// `at`: the first of three neighbours, counted from one before the first node. `m`: 00 01 02 11 12 22.
  void add(std::size_t at, const std::array<double, 6>& m, const Basis& right);
  /// The same for `count` triples of neighbours, the first at `at`: nine lists with a value for each.
  void add(std::size_t at, std::size_t count, const std::array<const double*, 9>& lists);
  /// Solves for 2..last; the other unknowns are 0.
  void solve(std::size_t last, std::vector<double>& x);

 private:
  std::vector<double> d0_, d1_, d2_, right_;
};

enum class RowKind { velocity, acceleration, jerk };

/// One kind of rows during the iterations: values, slacks and multipliers of both sides.
class SolverRows {
 public:
  using Real = kernels::Real;
  using Steps = kernels::Decrease;

  /// Keeps a reference to `limits`.
  SolverRows(const LimitRows& limits, RowKind kind);
  std::size_t sides() const { return 2 * limits_.rows * limits_.points; }
  bool empty() const { return sides() == 0; }

  /// The rows at the present motion.
  void evaluate(const NodeMotion& motion, const JerkPieces& pieces);
  /// Initialises slacks and multipliers for the values; with `again`, keeps the present ones but moves them
  /// away from zero.
  void begin(double complementarity, double least, bool again);
  void inherit(const SolverRows& before, const std::vector<std::size_t>& origins);
  /// The sum of slacks times multipliers, and the largest excess of a row over its limits.
  void measure(double& complementarity, double& residual) const;
  void assemble(double complementarity, FiveDiagonals& system);
  /// The effect of the step `db` of directions; updates the largest decreases in `steps`.
  void direction(double complementarity, const std::vector<double>& db, Steps& steps);
  /// Takes that step.
  void go(double complementarity, double primal, double dual);

 private:
  /// Slacks and multipliers of one side.
  struct Side {
    std::vector<Real> slack, multiplier;
  };
  /// Points with consecutive indices in the system.
  struct Run {
    std::size_t begin, count, at;
  };

  template <typename Each>
  void for_rows(Each each) const {
    for (std::size_t r = 0; r < limits_.rows; ++r) each(r, r * limits_.points);
  }
  kernels::Row row(std::size_t r) const;
  void find_runs(const std::vector<std::size_t>& at);
  void jerk_bases(const NodeMotion& motion, const JerkPieces& pieces);
  void node_bases(const NodeMotion& motion, const JerkPieces& pieces);
  void middle_bases(const NodeMotion& motion, const JerkPieces& pieces);
  void aim_norms();
  void bend_norms();
  double* gradient(std::size_t basis, std::size_t neighbour) {
    return &gradient_[(3 * basis + neighbour) * limits_.points];
  }
  Real* sums(std::size_t list) { return &m_[list * limits_.points]; }
  Real* basis(std::size_t b) { return &basis_[b * limits_.points]; }

  const LimitRows& limits_;
  RowKind kind_;
  std::size_t points_;  // number of points of the limits at construction; the limits may have a finer grid
                        // since then
  double weight_ = 1;   // weight of the product of slack and multiplier
  mutable Side high_, low_;
  mutable std::vector<Real> value_;
  std::vector<Real> scale_, m_, basis_, turn_;
  std::array<std::vector<Real>, 3> coefficient_;
  std::vector<double> gradient_, projected_;  // nine lists with a value for each point
  std::vector<Run> runs_;
};

}  // namespace polyarm::timing
