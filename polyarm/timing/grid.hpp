#pragma once
/// The grid of path places on which the timing is planned. Part of timing.hpp; not for the control cycle.
#include <cstddef>
#include <vector>

#include "polyarm/timing/rows.hpp"

namespace polyarm::timing {

/// Nodes of s, including every break, and a first guess of ṡ² there.
struct TimingGrid {
  std::vector<double> s, b;
};

/// Properties of the requested grid.
struct GridRequest {
  double start_speed, end_speed, fineness;
  /// The guess has no corners. The solver is fast from such a guess, except if speeds differ by a factor of
  /// hundreds.
  bool rounded;
  /// Intervals also follow the time in which jerk multiplies the speed, so that places whose speeds differ by
  /// a factor of hundreds are many nodes apart.
  bool slow_places;
};

/// The grid is fine where the path turns, where it is slow, and towards an end at rest (equal time steps at
/// constant jerk: s ~ k³). Neighbouring intervals differ by at most a factor of about 1.5.
TimingGrid timing_grid(PathRows& rows, const GridRequest& request);

/// The middles of pieces between breaks where the path is much slower than before and after. A stop there
/// costs little time.
std::vector<double> slow_places(PathRows& rows);

/// The highest ṡ² that velocity limits allow at a place of `rows`.
double velocity_ceiling(const PathRows& rows, std::size_t place);
/// The highest ṡ² that velocity limits allow, and acceleration and jerk limits at constant ṡ, at a place of
/// `rows`.
double speed_ceiling(const PathRows& rows, std::size_t place);

/// Lowers `b` (at the places of `rows`) until accelerations between neighbours are within limits, and jerks
/// too towards an end at rest.
void limit_accelerations(const PathRows& rows, std::vector<double>& b);

}  // namespace polyarm::timing
