#pragma once
/// The cubic spline through points, over knots as far apart as the curve between them is long.
#include <cstddef>
#include <span>
#include <vector>

namespace polyarm::paths {

/// A natural cubic spline (second derivative zero at both ends) in `dimensions` coordinates.
struct CubicSpline {
  std::vector<double> knots;                 ///< from 0; one of each point
  std::vector<double> value, first, second;  ///< [knot][dimension]; derivatives by the knots' parameter
};

/// Through `points` ([point][dimension], at least two, neighbours apart). The knots begin as the chords and
/// become the lengths of the pieces between them, measured with `weights` (one of each dimension; empty: 1
/// each) by Gauss's rule, again and again: so that the parameter is nearly the length of the curve, and the
/// curve overshoots less than over equal knots (Farin, Curves and Surfaces for CAGD, on the choice of knots).
/// `shortest` (empty, or one of each interval): no interval of knots becomes shorter.
CubicSpline cubic_spline(std::span<const double> points, std::size_t dimensions,
                         std::span<const double> weights = {}, std::span<const double> shortest = {});

}  // namespace polyarm::paths
