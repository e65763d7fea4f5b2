#pragma once
/// The cubic spline through points, with knot intervals equal to the lengths of the curve between the points.
/// Any thread; allocates.
#include <cstddef>
#include <span>
#include <vector>

namespace polyarm::paths {

/// A natural cubic spline (second derivative zero at both ends) in `dimensions` coordinates.
struct CubicSpline {
  std::vector<double> knots;                 ///< from 0; one for each point
  std::vector<double> value, first, second;  ///< [knot][dimension]; derivatives by the knots' parameter
};

/// The spline through `points` ([point][dimension], at least two, neighbours distinct). The knot intervals
/// start as the chords. They are then replaced several times by the lengths of the pieces, measured with
/// `weights` (one for each dimension; empty: 1 each) by Gauss's rule. So the parameter is nearly the length
/// of the curve, and the curve overshoots less than with equal knots (Farin, Curves and Surfaces for CAGD, on
/// the choice of knots). `shortest` (empty, or one for each interval): the smallest length of each knot
/// interval.
CubicSpline cubic_spline(std::span<const double> points, std::size_t dimensions,
                         std::span<const double> weights = {}, std::span<const double> shortest = {});

}  // namespace polyarm::paths
