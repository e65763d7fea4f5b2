#pragma once
/// Geometry without time: what the joints do along a path. What is timed is never the geometry, so a path is
/// the same at every speed.
#include <cstddef>
#include <span>
#include <vector>

namespace polyarm::paths {

/// Values of every joint (rad or m) and their first three derivatives by the path parameter. Spans of
/// joints() values; empty ones are not filled in.
struct PathDerivatives {
  std::span<double> q, first, second, third;
};

/// A path over the parameter s in [0, length()], continuous to the second derivative; the third may jump at
/// breaks(). s is what the maker of the path measures it in: metres of the TCP, radians of a joint.
/// Const after construction: any thread, no allocation in at().
class Path {
 public:
  virtual ~Path() = default;
  virtual std::size_t joints() const noexcept = 0;
  virtual double length() const noexcept = 0;
  /// `s` is clamped to [0, length()]. At a break the side after it.
  virtual void at(double s, const PathDerivatives& out) const noexcept = 0;
  /// Where the third derivative jumps, ascending, with 0 and length().
  virtual std::span<const double> breaks() const noexcept = 0;
};

}  // namespace polyarm::paths
