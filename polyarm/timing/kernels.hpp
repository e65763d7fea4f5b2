#pragma once
/// The inner loops of timing, compiled for several vector instructions; one set is chosen when the program
/// runs. All sets give the same bits: no product is fused with a sum, no sum reordered. Part of timing.hpp.
#include <cstddef>

namespace polyarm::timing::kernels {

/// Of the solver's rows: steps need not be exact, and twice as many numbers go into a register.
using Real = float;

/// One row of limits at `points` points during the solver's iterations: value = q0 v0 + q1 v1 + q2 v2 has to
/// stay within [low, 1] times the scale; slacks and multipliers of both sides.
struct Row {
  std::size_t points;
  const Real *q0, *q1, *q2, *scale;
  Real *value, *high_slack, *high_multiplier, *low_slack, *low_multiplier;
  Real low;
};

/// The largest relative decrease that a step asks of any slack and of any multiplier.
struct Decrease {
  Real primal = 0, dual = 0;
};

/// Where pieces are looked at: their ends from inside, and three places between, at equal distances of s.
inline constexpr std::size_t kPlaces = 5;

/// What happens in `pieces` pieces: lists of one value each for every place.
struct Pieces {
  std::size_t pieces;
  const double *speed[kPlaces], *square[kPlaces], *cube[kPlaces];  // ṡ, ṡ², ṡ³
  const double *acceleration[kPlaces], *product[kPlaces];          // s̈, 3ṡs̈
  const double* jerk;
};
/// One row of the path there: q', q'', q'''.
struct PathRow {
  const double *first[kPlaces], *second[kPlaces], *third[kPlaces];
};
/// The highest use of a limit in each piece so far.
struct Peaks {
  double* most;   // anywhere in the piece
  double* above;  // the same with what may have been missed between places
  double* rows;   // where rows of the problem are: its ends and, if asked for, its middle
  double* row;    // whose it is
};

struct Set {
  void (*evaluate)(const Row&, const Real* v0, const Real* v1, const Real* v2);
  /// Adds the row's part of the normal matrix (00 01 02 11 12 22 of three bases) and of the right side to the
  /// nine lists of `sums`.
  void (*assemble)(const Row&, Real centre, Real* const* sums);
  /// The basis changes by d0, d1, d2.
  void (*decrease)(const Row&, Real centre, const Real* d0, const Real* d1, const Real* d2, Decrease&);
  void (*step)(const Row&, Real centre, const Real* d0, const Real* d1, const Real* d2, Real primal,
               Real dual);
  /// Adds slacks times multipliers to sixteen sums; the largest excess of a value over its limit, per scale.
  void (*measure)(const Row&, Real* sums, Real& residual);
  /// From the normal matrix and right side by bases, nine lists, those by three neighbours, nine lists.
  /// `gradient`: of basis b by neighbour i in list 3 b + i.
  void (*project)(std::size_t points, const Real* const* sums, const double* const* gradient,
                  double* const* out);
  /// The changes of the bases where the neighbours change by the lists x.
  void (*turn)(std::size_t points, const double* const* gradient, const double* const* x, Real* const* d);
  /// Of each piece, with constant jerk from speed and acceleration over `way` in `end` s: the times when a
  /// quarter, half and three quarters of the way are done.
  void (*times)(std::size_t pieces, const double* speed, const double* acceleration, const double* jerk,
                const double* way, const double* end, double* const* times);
  /// The values of a row: velocity, acceleration and jerk at all places, kPlaces lists of `pieces` each.
  void (*values)(const Pieces&, const PathRow&, double* velocity, double* acceleration, double* jerk);
  /// Takes the peaks of such values into account: over their highest (1 / limit) and their lowest.
  void (*peaks)(std::size_t pieces, const double* values, double per_high, double per_low, bool middle,
                double number, const Peaks&);
};

/// The fastest that this processor has.
const Set& best() noexcept;
/// What every processor has.
const Set& portable() noexcept;

}  // namespace polyarm::timing::kernels
