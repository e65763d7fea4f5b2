#pragma once
/// Geometry without time: joint values along a path. Timing never changes the geometry, so the path is the
/// same at every speed.
#include <cstddef>
#include <span>
#include <vector>

namespace polyarm::paths {

/// Values of all joints (rad or m) and their first three derivatives with respect to the path parameter.
/// Spans of joints() values; empty spans are not filled in.
struct PathDerivatives {
  std::span<double> q, first, second, third;
};

/// A path over the parameter s in [0, length()], continuous to the second derivative; the third may jump at
/// breaks(). The maker of the path chooses the unit of s: metres of the TCP, radians of a joint. Const after
/// construction: any thread, no allocation in at().
class Path {
 public:
  virtual ~Path() = default;
  virtual std::size_t joints() const noexcept = 0;
  virtual double length() const noexcept = 0;
  /// `s` is clamped to [0, length()]. At a break: the values after it.
  virtual void at(double s, const PathDerivatives& out) const noexcept = 0;
  /// The places where the third derivative jumps, in ascending order, including 0 and length().
  virtual std::span<const double> breaks() const noexcept = 0;
};

}  // namespace polyarm::paths
