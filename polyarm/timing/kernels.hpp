#pragma once
/// The inner loops of timing, compiled for several vector instruction sets; the program chooses one when it
/// runs. All sets give the same bits: no product is fused with a sum, and no sum is reordered. Part of
/// timing.hpp. Any thread; nothing allocates or throws.
#include <cstddef>

namespace polyarm::timing::kernels {

/// The type of the solver's rows: steps need not be exact, and a register holds twice as many floats.
using Real = float;

/// One row of limits at `points` points during the iterations: value = q0 v0 + q1 v1 + q2 v2 must stay within
/// [low, 1] times the scale; slacks and multipliers of both sides.
struct Row {
  std::size_t points;
  const Real *q0, *q1, *q2, *scale;
  Real *value, *high_slack, *high_multiplier, *low_slack, *low_multiplier;
  Real low;
};

/// The largest relative decrease of any slack and of any multiplier in a step.
struct Decrease {
  Real primal = 0, dual = 0;
};

/// Places per piece: both ends from inside and three places between, at equal distances of s.
inline constexpr std::size_t kPlaces = 5;

/// The motion in `pieces` pieces: for every place a list of one value per piece.
struct Pieces {
  std::size_t pieces;
  const double *speed[kPlaces], *square[kPlaces], *cube[kPlaces];  // ṡ, ṡ², ṡ³
  const double *acceleration[kPlaces], *product[kPlaces];          // s̈, 3ṡs̈
  const double* jerk;
};
/// The derivatives q', q'', q''' of one row of the path there.
struct PathRow {
  const double *first[kPlaces], *second[kPlaces], *third[kPlaces];
};
/// The highest use of a limit in each piece so far.
struct Peaks {
  double* most;   // anywhere in the piece
  double* above;  // the same, with an estimate for the peaks between places
  double* rows;   // at the rows of the problem: at both ends and, if requested, in the middle
  double* row;    // the row of the peak
};

struct Set {
  void (*evaluate)(const Row&, const Real* v0, const Real* v1, const Real* v2);
  /// Adds the row's part of the normal matrix (00 01 02 11 12 22 of three bases) and of the right side to the
  /// nine lists of `sums`.
  void (*assemble)(const Row&, Real centre, Real* const* sums);
  /// For a change of the bases by d0, d1, d2.
  void (*decrease)(const Row&, Real centre, const Real* d0, const Real* d1, const Real* d2, Decrease&);
  void (*step)(const Row&, Real centre, const Real* d0, const Real* d1, const Real* d2, Real primal,
               Real dual);
  /// Adds slacks times multipliers to sixteen sums, and updates the largest relative excess of a value over
  /// its limit.
  void (*measure)(const Row&, Real* sums, Real& residual);
  /// Converts the normal matrix and right side from bases (nine lists) to three neighbours (nine lists).
  /// `gradient`: basis b with respect to neighbour i is list 3 b + i.
  void (*project)(std::size_t points, const Real* const* sums, const double* const* gradient,
                  double* const* out);
  /// The changes of the bases when the neighbours change by the lists x.
  void (*turn)(std::size_t points, const double* const* gradient, const double* const* x, Real* const* d);
  /// For each piece, with constant jerk from speed and acceleration over `way` in `end` s: the times at a
  /// quarter, half and three quarters of the way.
  void (*times)(std::size_t pieces, const double* speed, const double* acceleration, const double* jerk,
                const double* way, const double* end, double* const* times);
  /// The values of a row: velocity, acceleration and jerk at all places, kPlaces lists of `pieces` values
  /// each.
  void (*values)(const Pieces&, const PathRow&, double* velocity, double* acceleration, double* jerk);
  /// Updates the peaks with these values, relative to their highest (1 / limit) and their lowest limit.
  void (*peaks)(std::size_t pieces, const double* values, double per_high, double per_low, bool middle,
                double number, const Peaks&);
};

/// The fastest set for this processor.
const Set& best() noexcept;
/// The set that every processor supports.
const Set& portable() noexcept;

}  // namespace polyarm::timing::kernels
