#pragma once
/// Paths of a TCP: lines, arcs, circles and splines with rounded corners. Metres, radians; poses of the TCP
/// in one frame of the caller's choice. Building allocates and throws. A finished path is const: any thread;
/// queries allocate nothing.
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/paths/path_warning.hpp"
#include "polyarm/paths/pose_piece.hpp"

namespace polyarm::paths {

/// A path over the parameter s in [0, length()]. Position is continuous up to the second derivative and
/// angular velocity up to the first, so joints that follow the path are continuous up to the second
/// derivative.
///
/// s is the TCP's way in metres, exactly on lines and arcs, nearly on splines and in corners (in a corner the
/// derivative of the position by s is below 1, down to the cosine of half the turn). On a line that is
/// shorter than kTurning metres for each radian of its rotation, s is in radians.
class CartesianPath {
 public:
  static constexpr double kTurning = 1e-3;  ///< m/rad

  explicit CartesianPath(const Pose& start) : start_(start) {}
  double length() const noexcept { return breaks_.back(); }
  /// `s` is clamped to [0, length()]. At a break: the values after it.
  PoseDerivatives at(double s) const noexcept;
  /// The ends of the pieces, where the third derivative jumps, in ascending order, including 0 and length().
  std::span<const double> breaks() const noexcept { return breaks_; }
  std::size_t pieces() const noexcept { return parts_.size(); }
  /// Values on piece `i`, from breaks()[i] to breaks()[i + 1], including both ends.
  PoseDerivatives on_piece(std::size_t i, double s) const noexcept;

  /// Appends the part of `piece` that begins at x = `offset` and has the length `length` > 0.
  void append(const PosePiece& piece, double offset, double length);

 private:
  struct Part {
    PosePiece piece;
    double offset;
  };
  Pose start_;
  std::vector<Part> parts_;
  std::vector<double> breaks_{0, 0};
};

/// The TCP's orientation on an arc. fixed: constant. interpolated: rotates at a constant rate, the shorter
/// way. tangent: rotates with the arc, so the tangent keeps its direction in the tool frame.
enum class ArcOrientation { fixed, interpolated, tangent };

/// The end of a segment.
struct Corner {
  /// The largest distance of the path from the corner, m. 0: the path passes exactly through the corner and
  /// stops there, unless the next segment continues with the same derivatives up to the second. Beside a
  /// segment on which the TCP only rotates, the segment's radians count as well.
  double radius = 0;
  std::string name;  ///< for messages; empty: "waypoint 3", where 0 is the start
};

struct CartesianSections {
  std::vector<CartesianPath> sections;  ///< at least one; the path stops between two sections
  std::vector<PathWarning> warnings;    ///< "blend-shrunk", "waypoint-repeated"
};

/// A sequence of segments; each begins where the previous one ends.
///
/// A corner is rounded between the points of both segments at distance d along the path, by polynomials of
/// fifth degree over a parameter range of 2 d. They meet both segments with equal first and second
/// derivatives of the position and of the rotation vector from the corner's orientation; in that vector a
/// neighbour that rotates at a constant rate is a straight line. Between two lines this is the curve of
/// joint_lines(). d is the radius, reduced with a warning to half of the shorter neighbour, to the radius of
/// an arc, and until the hull of the curve's Bézier points lies within `radius` of the corner, which bounds
/// the curve.
class CartesianPathBuilder {
 public:
  explicit CartesianPathBuilder(const Pose& start);
  /// A line with slerp between the orientations (the shorter way).
  CartesianPathBuilder& line(const Pose& to, const Corner& corner = {});
  /// Through `via`, at most one whole turn. fixed and tangent ignore to.rotation.
  CartesianPathBuilder& arc(const Vec3& via, const Pose& to, ArcOrientation orientation,
                            const Corner& corner = {});
  /// About the axis through `center` by any angle (rad, right-handed, more than a whole turn too).
  /// `end_rotation` applies to interpolated; without it, as fixed.
  CartesianPathBuilder& arc_about(const Vec3& center, const Vec3& axis, double angle,
                                  ArcOrientation orientation, const Corner& corner = {},
                                  std::optional<Quaternion> end_rotation = {});
  /// The whole circle from here through both points, in this order.
  CartesianPathBuilder& circle(const Vec3& via, const Vec3& second, ArcOrientation orientation,
                               const Corner& corner = {});
  /// A curve through all poses, continuous to the second derivative of position and orientation. Positions:
  /// the natural cubic spline. Orientations: rotation vectors of fifth degree from pose to pose with the
  /// rates of the parabola through three neighbours, reduced where neighbours rotate at very different rates.
  CartesianPathBuilder& spline(std::span<const Pose> through, const Corner& corner = {});

  /// The parameter at the end of the segments so far, which corners do not change.
  double length() const noexcept;
  /// Throws Error with all faults: "bad-number", "bad-radius", "no-arc" (points on a line, or a repeated
  /// point), "no-axis", "no-waypoints", "turn-too-large" (of a spline, above 3 rad).
  CartesianSections build() const;

 private:
  struct Segment {
    std::vector<PosePiece> pieces;
    std::vector<double> begins;
    double length = 0;
    double curve_radius;
    Corner corner;  ///< its end, named
    Pose end;
    std::size_t waypoint = 0;  ///< the number of its end
    PoseDerivatives at(double x) const noexcept;
  };
  class Assembly;

  std::string next_name(const Corner& corner) const;
  bool fine(const Pose& pose, const Corner& corner);
  void add(std::vector<PosePiece> pieces, double curve_radius, const Pose& end, const Corner& corner);
  void add_arc(const Vec3& center, const Vec3& axis, double angle, ArcOrientation orientation,
               const std::optional<Quaternion>& end, const std::optional<Vec3>& end_point,
               const Corner& corner);

  Pose start_, end_;
  std::size_t waypoints_ = 1;
  std::vector<Segment> segments_;
  Problems problems_;
  std::vector<PathWarning> repeated_;
};

}  // namespace polyarm::paths
