#pragma once
/// One piece of a Cartesian path: a line, an arc, or a polynomial between two others. Metres, radians, in the
/// frame of its poses. Any thread; no allocation.
#include <array>

#include "polyarm/base/pose.hpp"
#include "polyarm/paths/rotation.hpp"

namespace polyarm::paths {

/// A pose on a path and its first three derivatives with respect to the path parameter. `angular` begins with
/// the angular velocity. All in the axes of the pose's reference frame.
struct PoseDerivatives {
  Pose pose;
  std::array<Vec3, 3> linear, angular;
};

struct PosePiece {
  enum class Kind { line, arc, polynomial };
  Kind kind = Kind::line;
  double length = 0;
  /// Line: point + x across. Arc: point + radius (cos(x / radius) across + sin(x / radius) along).
  Vec3 point, across, along;
  double radius = 0;
  /// Line and arc: rotation exp(x turn), which is slerp. Polynomial: the reference of the rotation vector.
  Quaternion rotation;
  Vec3 turn;
  /// Polynomial: coefficients of powers of x / length, for position and rotation vector.
  std::array<Vec3, 6> position, vector;

  /// At x in [0, length].
  PoseDerivatives at(double x) const noexcept;
};

/// From one pose to the other at constant rates; `length` is the length of the parameter range.
PosePiece line_piece(const Pose& from, const Pose& to, double length) noexcept;
/// Around `center`, in the plane of from.position - center and `axis` x that, which are perpendicular to each
/// other. `turn`: rotation of the orientation in its own axes, rad per metre.
PosePiece arc_piece(const Pose& from, const Vec3& center, const Vec3& axis, double angle,
                    const Vec3& turn) noexcept;
/// Polynomials of fifth degree through both ends with their first and second derivatives: for the position,
/// and for the rotation vector from `middle`, which must be less than pi away from both ends.
PosePiece joining_piece(const PoseDerivatives& from, const PoseDerivatives& to, const Quaternion& middle,
                        double length) noexcept;
/// The Bézier points of the polynomial; the curve stays within their hull.
std::array<Vec3, 6> hull(const std::array<Vec3, 6>& coefficients) noexcept;

}  // namespace polyarm::paths
