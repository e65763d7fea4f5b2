#pragma once
/// The squared path speed on a grid, as fast as rows of limits allow. Part of timing.hpp; outside the cycle.
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace polyarm::trajectory {

/// Limits of one kind at some points of the grid. A row's value at a point is
/// first·basis0 + second·basis1 + third·basis2 and stays within [low, 1] times the point's scale. The bases
/// are functions of up to three neighbouring squared speeds. Rows' coefficients lie as [row][point].
struct LimitRows {
  std::size_t rows = 0, points = 0;
  std::array<std::vector<double>, 3> coefficient;
  std::vector<double> low;        ///< of each row, per the upper limit
  std::vector<std::size_t> at;    ///< of each point: its node, or the interval that begins there
  std::vector<double> scale;      ///< of each point
  std::vector<signed char> side;  ///< of edges: -1 before the node, 1 behind it; else empty
  /// Rows that are norms: row r's components are component_end[r-1]..component_end[r]; empty: plain rows.
  std::vector<std::size_t> component_end;
  std::array<std::vector<double>, 3> component;

  void resize(std::size_t rows, std::size_t points);
};

/// b = ṡ² at the nodes s_0..s_N. Velocity rows: basis b_k. Acceleration rows, one point per interval: bases
/// s̈ of the interval and the mean of b. Jerk rows at nodes: bases s⃛, ṡ·s̈, ṡ³.
struct SpeedProblem {
  std::vector<double> s;
  LimitRows velocity, acceleration, jerk;
  LimitRows norm_acceleration, norm_jerk;
  /// Jerk rows at an end of the stretch around a node over which s⃛ is constant (midway to a neighbour):
  /// added where those at nodes say too little.
  LimitRows edge_jerk, norm_edge_jerk;
};

struct SpeedSolution {
  int iterations = 0;
  bool converged = false;
};

/// Improves squared speeds to the least duration that rows allow.
///
/// Method: primal-dual interior point steps on min ∫ds/ṡ (e.g. Nocedal and Wright 2006, ch. 19) with the
/// rows linearised anew in each step and without their curvature; each step solves one system with five
/// diagonals.
class SpeedSolver {
 public:
  /// Both stay with the caller, who may change scales and add points to the edges between calls. `b`:
  /// positive inside; its ends are given and stay.
  SpeedSolver(const SpeedProblem& problem, std::vector<double>& b);
  ~SpeedSolver();
  /// `precision`: relative gap of the duration at which it stops. Goes on from what the last call knew.
  SpeedSolution improve(double precision, int most_iterations);

 private:
  class Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace polyarm::trajectory
