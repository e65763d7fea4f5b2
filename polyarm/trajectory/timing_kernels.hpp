#pragma once
/// The inner loops of timing, compiled for several vector instructions; one set is chosen when the program
/// runs. All sets give the same bits: no product is fused with a sum, no sum reordered. Part of timing.hpp.
#include <cstddef>

namespace polyarm::trajectory::kernels {

/// One row of limits at `points` points during the solver's iterations: value = q0 v0 + q1 v1 + q2 v2 has to
/// stay within [low, 1] times the scale; slacks and multipliers of both sides.
struct Row {
  std::size_t points;
  const double *q0, *q1, *q2, *scale;
  double *value, *high_slack, *high_multiplier, *low_slack, *low_multiplier;
  double low;
};

/// The largest relative decrease that a step asks of any slack and of any multiplier.
struct Decrease {
  double primal = 0, dual = 0;
};

/// One row of a path at places: q', q'', q''' and the reciprocals of its limits; `number` is the row's.
struct PathRow {
  std::size_t places;
  const double *first, *second, *third;
  double v_high, v_low, a_high, a_low, jerk;
  double number;
};
/// How the places are passed: ṡ, s̈, s⃛ with ṡ² and ṡ³.
struct Passing {
  const double *speed, *acceleration, *jerk, *square, *cube;
};
/// The highest use of a limit so far at each place, of velocity, acceleration and jerk, and its row.
struct Use {
  double* value[3];
  double* row[3];
};

struct Set {
  void (*evaluate)(const Row&, const double* v0, const double* v1, const double* v2);
  /// Adds the row's part of the normal matrix (00 01 02 11 12 22 of three bases) and of the right side to the
  /// nine lists of `sums`.
  void (*assemble)(const Row&, double centre, double* const* sums);
  void (*decrease)(const Row&, double centre, const double* d0, const double* d1, const double* d2,
                   Decrease&);
  void (*step)(const Row&, double centre, const double* d0, const double* d1, const double* d2, double primal,
               double dual);
  /// Sum of slacks times multipliers, and the largest excess of a value over its limit, per scale.
  void (*measure)(const Row&, double& complementarity, double& residual);
  void (*use)(const PathRow&, const Passing&, const Use&);
};

/// The fastest that this processor has.
const Set& best() noexcept;
/// What every processor has.
const Set& portable() noexcept;

}  // namespace polyarm::trajectory::kernels
