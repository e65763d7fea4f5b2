#pragma once
/// The squared path speed on a grid, as fast as rows of limits allow. Part of timing.hpp; not for the control
/// cycle.
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "polyarm/timing/jerk_pieces.hpp"

namespace polyarm::timing {

/// Limits of one kind at some points of the grid. A row's value at a point is
/// first·basis0 + second·basis1 + third·basis2 and stays within [low, 1] times the point's scale. The bases
/// are functions of the motion at one or two nodes. Coefficients are stored as [row][point].
struct LimitRows {
  std::size_t rows = 0, points = 0;
  std::array<std::vector<double>, 3> coefficient;
  std::vector<double> low;    ///< of each row, relative to the upper limit
  std::vector<double> scale;  ///< of each point
  /// For points at nodes, which come first; the middles of all pieces follow, if there are more points.
  std::vector<std::size_t> node;
  /// For rows that are norms: row r has the components component_end[r-1]..component_end[r]; empty: plain
  /// rows.
  std::vector<std::size_t> component_end;
  std::array<std::vector<double>, 3> component;

  void resize(std::size_t rows, std::size_t points);
};

/// For N pieces between nodes 0..N. Velocity rows at nodes and middles: basis b. Acceleration rows likewise:
/// bases s̈ and b. Jerk rows at the start of each piece (points 0..N-1) and at its end (N..2N-1): bases s⃛,
/// ṡ·s̈, ṡ³.
struct SpeedProblem {
  LimitRows velocity, acceleration, jerk, norm_acceleration, norm_jerk;
};

/// For each point of the rows of a problem: the point of the previous problem that it comes from, or kNew.
struct PointOrigins {
  static constexpr std::size_t kNew = std::size_t(-1);
  std::vector<std::size_t> velocity, acceleration, jerk;
};

struct SpeedSolution {
  int iterations = 0;
  bool converged = false;
};

/// Improves a motion to the shortest duration that the rows allow.
///
/// Method: primal-dual interior point steps on min Σ durations of pieces (e.g. Nocedal and Wright 2006, ch.
/// 19) in the directions that keep the pieces connected. Each step linearises the rows anew, without their
/// curvature, and solves one system with five diagonals.
class SpeedSolver {
 public:
  /// Keeps references to both; the caller may change scales between calls. `motion`: positive speeds inside;
  /// its ends are fixed.
  SpeedSolver(const SpeedProblem& problem, NodeMotion& motion);
  /// Starts with the results of `before` for the points that come from its grid.
  SpeedSolver(const SpeedProblem& problem, NodeMotion& motion, const SpeedSolver& before,
              const PointOrigins& origins);
  ~SpeedSolver();
  /// `precision`: relative gap of the duration at which it stops; `residual`: the excess of rows that is then
  /// allowed. Continues from the state of the last call.
  SpeedSolution improve(double precision, double residual, int most_iterations);
  const JerkPieces& pieces() const;

 private:
  class Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace polyarm::timing
