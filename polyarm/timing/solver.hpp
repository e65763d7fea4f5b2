#pragma once
/// The squared path speed on a grid, as fast as rows of limits allow. Part of timing.hpp; outside the cycle.
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/timing/jerk_pieces.hpp"

namespace polyarm::timing {

/// Limits of one kind at some points of the grid. A row's value at a point is
/// first·basis0 + second·basis1 + third·basis2 and stays within [low, 1] times the point's scale. The bases
/// are functions of the motion at one node or at two. Rows' coefficients lie as [row][point].
struct LimitRows {
  std::size_t rows = 0, points = 0;
  std::array<std::vector<double>, 3> coefficient;
  std::vector<double> low;    ///< of each row, per the upper limit
  std::vector<double> scale;  ///< of each point
  /// Of points at nodes, which come first; behind them come the middles of all pieces, if there are more.
  std::vector<std::size_t> node;
  /// Rows that are norms: row r's components are component_end[r-1]..component_end[r]; empty: plain rows.
  std::vector<std::size_t> component_end;
  std::array<std::vector<double>, 3> component;

  void resize(std::size_t rows, std::size_t points);
};

/// With N pieces between nodes 0..N. Velocity rows at nodes and middles: basis b. Acceleration rows likewise:
/// bases s̈ and b. Jerk rows at the begin of each piece (points 0..N-1) and at its end (N..2N-1): bases s⃛,
/// ṡ·s̈, ṡ³.
struct SpeedProblem {
  LimitRows velocity, acceleration, jerk, norm_acceleration, norm_jerk;
};

/// Of each point of the rows of a problem: the point of the problem before from which it comes, or kNew.
struct PointOrigins {
  static constexpr std::size_t kNew = std::size_t(-1);
  std::vector<std::size_t> velocity, acceleration, jerk;
};

struct SpeedSolution {
  int iterations = 0;
  bool converged = false;
};

/// Improves a motion to the least duration that rows allow.
///
/// Method: primal-dual interior point steps on min Σ time of pieces (e.g. Nocedal and Wright 2006, ch. 19) in
/// the directions that keep the pieces together, with the rows linearised anew in each step and without
/// their curvature; each step solves one system with five diagonals.
class SpeedSolver {
 public:
  /// Both stay with the caller, who may change scales between calls. `motion`: positive speeds inside; its
  /// ends are given and stay.
  SpeedSolver(const SpeedProblem& problem, NodeMotion& motion);
  /// Knows what `before` has found out where points come from there.
  SpeedSolver(const SpeedProblem& problem, NodeMotion& motion, const SpeedSolver& before,
              const PointOrigins& origins);
  ~SpeedSolver();
  /// `precision`: relative gap of the duration at which it stops; `residual`: by how much rows may exceed
  /// their limits then. Goes on from what the last call knew.
  SpeedSolution improve(double precision, double residual, int most_iterations);
  const JerkPieces& pieces() const;

 private:
  class Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace polyarm::timing
