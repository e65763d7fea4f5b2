#pragma once
/// Where on a path its time is planned. Part of timing.hpp.
#include <cstddef>
#include <vector>

#include "polyarm/timing/rows.hpp"

namespace polyarm::timing {

/// Nodes of s, with every break, and a first guess of ṡ² there.
struct TimingGrid {
  std::vector<double> s, b;
};

/// What a grid is made for.
struct GridRequest {
  double start_speed, end_speed, fineness;
  /// The guess has no corners, from which the solver is quick; not so where speeds differ by hundreds.
  bool rounded;
  /// Intervals also follow the time in which jerk changes the speed by a multiple, so that speeds that differ
  /// by hundreds are far apart.
  bool slow_places;
};

/// The grid is fine where the path turns, where it is slow, and towards an end at rest (there equal steps of
/// time at constant jerk: s ~ k³). Neighbouring intervals are alike to a factor of about 1.5.
TimingGrid timing_grid(PathRows& rows, const GridRequest& request);

/// The middles of pieces between breaks that have to be passed much more slowly than what is before and
/// behind: to stop there takes hardly longer.
std::vector<double> slow_places(PathRows& rows);

/// The highest ṡ² that velocity limits allow at a place of `rows`.
double velocity_ceiling(const PathRows& rows, std::size_t place);
/// The same that velocity, and acceleration and jerk at constant ṡ, allow at a place of `rows`.
double speed_ceiling(const PathRows& rows, std::size_t place);

/// Lowers `b` (at the places of `rows`) until accelerations between neighbours are within limits, and
/// towards an end at rest also jerks.
void limit_accelerations(const PathRows& rows, std::vector<double>& b);

}  // namespace polyarm::timing
