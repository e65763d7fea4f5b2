#pragma once
/// The rows of limits on a grid of a path, and how close a motion comes to them between its nodes. Part of
/// timing.hpp; not for the control cycle.
#include <array>
#include <cstddef>
#include <vector>

#include "polyarm/timing/jerk_pieces.hpp"
#include "polyarm/timing/kernels.hpp"
#include "polyarm/timing/rows.hpp"
#include "polyarm/timing/solver.hpp"

namespace polyarm::timing {

class TimingProblem {
 public:
  /// Keeps a reference to `rows`, which then belongs to the problem: it replaces their places.
  TimingProblem(PathRows& rows, const std::vector<double>& s);

  const SpeedProblem& speeds() const { return speeds_; }
  /// The use of the limits by `motion` in each piece (from 1): at five places; between them by the polynomial
  /// through these; and the possible error of the polynomial.
  void look(const NodeMotion& motion, const JerkPieces& pieces, std::vector<PieceUse>& out);
  /// Lowers the scales of rows in pieces that exceed their limits, by slightly more than the excess.
  void tighten(const std::vector<PieceUse>& use);
  /// Refines the grid `s` by a node in each piece marked in `halve`; scales are carried over.
  PointOrigins refine(const std::vector<double>& s, const std::vector<char>& halve);

 private:
  static constexpr std::size_t kPlaces = kernels::kPlaces;

  void set_up(const std::vector<double>& s);
  /// Order of the places: first the first places of all pieces, then the second places, and so on.
  std::size_t place(std::size_t piece, std::size_t i) const { return i * count_ + piece - 1; }
  std::size_t begin_of(std::size_t piece) const { return place(piece, 0); }
  std::size_t middle_of(std::size_t piece) const { return place(piece, kPlaces / 2); }
  std::size_t end_of(std::size_t piece) const { return place(piece, kPlaces - 1); }
  void pass(const NodeMotion& motion, const JerkPieces& pieces);
  void values_of(std::size_t component);
  void check_joint_in_detail(std::size_t joint);
  void check_norm(std::size_t norm);
  void peaks(std::size_t kind, const double* values, std::size_t row, double per_high, double per_low);
  std::vector<double> slacks(const LimitRows& rows, const std::vector<PieceUse>& use, std::size_t norm,
                             std::size_t kind) const;
  void fill_velocity();
  void fill_acceleration();
  bool jumps(std::size_t before, std::size_t behind) const;
  void fill_jerk();
  void fill(LimitRows& plain, LimitRows& norm, const std::vector<std::size_t>& places, LimitKind kind);

  PathRows& rows_;
  SpeedProblem speeds_;
  std::size_t count_ = 0;
  /// The motion at the places, and the values of a row there.
  struct Passing {
    std::vector<double> speed, square, cube, acceleration, product, jerk, way, end, times;
  } passing_;
  std::array<std::vector<double>, 3> value_, norm_;
  /// By row type (plain or norm) and by kind, for all pieces: see kernels::Peaks.
  struct Peaks {
    std::vector<double> most, above, rows, row;
  };
  std::array<std::array<Peaks, 3>, 2> peaks_;
};

}  // namespace polyarm::timing
