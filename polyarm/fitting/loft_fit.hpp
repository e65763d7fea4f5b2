#pragma once
/// Describes a convex polyhedron by a loft through few sections. Lengths in m. Any thread; deterministic.
#include "polyarm/hulls/hull.hpp"
#include "polyarm/shapes/measured_look.hpp"

namespace polyarm::fitting {

/// The loft that needs the fewest numbers while no section of the hull differs from it by more than
/// `tolerance`, along the best of several axes. Its link and paint are empty.
shapes::MeasuredLoft fit_loft(const hulls::Hull& hull, double tolerance);

}  // namespace polyarm::fitting
