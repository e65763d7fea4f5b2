#pragma once
/// The rows of limits on a grid of a path, and how near a motion comes to them between its nodes. Part of
/// timing.hpp.
#include <array>
#include <cstddef>
#include <vector>

#include "polyarm/trajectory/timing_pieces.hpp"
#include "polyarm/trajectory/timing_rows.hpp"
#include "polyarm/trajectory/timing_solver.hpp"

namespace polyarm::trajectory {

class TimingProblem {
 public:
  /// `rows` stays with the caller and belongs to the problem: its places are the problem's.
  TimingProblem(PathRows& rows, const std::vector<double>& s);

  const SpeedProblem& speeds() const { return speeds_; }
  /// How much of the limits `motion` uses in each piece (from 1), by samples and by the parabolas through
  /// neighbouring ones.
  void look(const NodeMotion& motion, const JerkPieces& pieces, std::vector<PieceUse>& out);
  /// Lowers the scales of rows in pieces that exceed their limits, by a little more than that.
  void tighten(const std::vector<PieceUse>& use);
  /// To the grid `s` with a node more in each piece of `halve`; scales go along.
  PointOrigins refine(const std::vector<double>& s, const std::vector<char>& halve);

 private:
  /// Places of each piece at which the path is looked at: the ends from inside, and three between.
  static constexpr std::size_t kPlaces = 5;

  void set_up(const std::vector<double>& s);
  void places_of(const NodeMotion& m, const JerkPieces& pieces, std::size_t k, PathMotion* out) const;
  std::size_t begin_of(std::size_t piece) const { return (piece - 1) * kPlaces; }
  std::size_t middle_of(std::size_t piece) const { return (piece - 1) * kPlaces + kPlaces / 2; }
  std::size_t end_of(std::size_t piece) const { return piece * kPlaces - 1; }
  void fill_velocity();
  void fill_acceleration();
  bool jumps(std::size_t before, std::size_t behind) const;
  void fill_jerk();
  void fill(LimitRows& plain, LimitRows& norm, const std::vector<std::size_t>& places, LimitKind kind);

  PathRows& rows_;
  SpeedProblem speeds_;
  std::size_t count_ = 0;
  std::vector<PathMotion> motion_;
  std::vector<Ratios> ratios_;
};

}  // namespace polyarm::trajectory
