#pragma once
/// Paths of a TCP: lines, arcs, circles and splines with rounded corners. Metres, radians, poses of the TCP
/// in one frame of the caller's choice. Building allocates and throws; what is built is const, for any
/// thread, and allocates nothing when asked.
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/pose.hpp"
#include "polyarm/paths/pose_piece.hpp"

namespace polyarm::paths {

/// A path over the parameter s in [0, length()]: position and angular velocity are continuous up to the
/// second and first derivative, so joints that follow it are continuous to the second.
///
/// s counts the TCP's metres, exactly on lines and arcs; on splines and in corners nearly so (in a corner the
/// derivative of the position by s is below 1, down to the cosine of half the turn). On a line that is
/// shorter than kTurning metres for each radian of its turn, s counts radians.
class CartesianPath {
 public:
  static constexpr double kTurning = 1e-3;  ///< m/rad

  explicit CartesianPath(const Pose& start) : start_(start) {}
  double length() const noexcept { return breaks_.back(); }
  /// `s` is clamped to [0, length()]. At a break the side after it.
  PoseDerivatives at(double s) const noexcept;
  /// Where pieces meet and the third derivative jumps, ascending, with 0 and length().
  std::span<const double> breaks() const noexcept { return breaks_; }
  std::size_t pieces() const noexcept { return parts_.size(); }
  /// On piece `i`, from breaks()[i] to breaks()[i + 1], and its ends, whatever joins there.
  PoseDerivatives on_piece(std::size_t i, double s) const noexcept;

  /// The part of `piece` from x = `offset` on, `length` > 0 long.
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

/// How the TCP turns on an arc. fixed: not at all. interpolated: at a constant rate, the shorter way.
/// tangent: with the arc, so that it sees the arc's tangent always from the same side.
enum class ArcOrientation { fixed, interpolated, tangent };

/// The end of a segment.
struct Corner {
  /// How far from the corner the path may leave its segments, m; 0: exactly through it, at rest there unless
  /// the next segment goes on with the same derivatives up to the second. Beside a segment where the TCP only
  /// turns, it counts the segment's radians too.
  double radius = 0;
  std::string name;  ///< for messages; empty: "waypoint 3", the start being 0
};

struct CartesianSections {
  std::vector<CartesianPath> sections;  ///< at least one; where the TCP has to stop, the next begins
  std::vector<Problem> warnings;        ///< "blend-shrunk", "waypoint-repeated"
};

/// Segments, one after the other, each from where the one before ends.
///
/// A corner is rounded between the points of both segments that are d away from it along the path, by
/// polynomials of fifth degree over a parameter 2 d long, which meet both segments with equal first and
/// second derivatives: of position, and of the rotation vector from the corner's orientation, on which both
/// neighbours that turn at a constant rate are straight lines. Between two lines this is the curve of
/// joint_lines(). d is the radius, shrunk with a warning: to half of the shorter neighbour, to the radius of
/// an arc, and until the hull of the curve's Bézier points lies within `radius` of the corner, which proves
/// that the curve does.
class CartesianPathBuilder {
 public:
  explicit CartesianPathBuilder(const Pose& start);
  /// A line with slerp between the orientations (the shorter way).
  CartesianPathBuilder& line(const Pose& to, const Corner& corner = {});
  /// Through `via`, up to a whole turn. fixed and tangent make no use of to.rotation.
  CartesianPathBuilder& arc(const Vec3& via, const Pose& to, ArcOrientation orientation,
                            const Corner& corner = {});
  /// About the axis through `center`, by any angle (rad, right-handed; more than a whole turn too).
  /// `end_rotation` is for interpolated; without it, as fixed.
  CartesianPathBuilder& arc_about(const Vec3& center, const Vec3& axis, double angle,
                                  ArcOrientation orientation, const Corner& corner = {},
                                  std::optional<Quaternion> end_rotation = {});
  /// The whole circle from here through both points, in their order.
  CartesianPathBuilder& circle(const Vec3& via, const Vec3& second, ArcOrientation orientation,
                               const Corner& corner = {});
  /// A curve through all poses, continuous to the second derivative of position and orientation: the natural
  /// cubic spline of positions; rotation vectors of fifth degree from pose to pose whose rates are those of
  /// the parabola through three neighbours, held back where neighbours turn at very different rates.
  CartesianPathBuilder& spline(std::span<const Pose> through, const Corner& corner = {});

  /// The parameter at the end of what was added so far; corners do not change it.
  double length() const noexcept;
  /// Throws Error with everything wrong in what was added: "bad-number", "bad-radius", "no-arc" (points on a
  /// line, or one point twice), "no-axis", "no-waypoints", "turn-too-large" (of a spline, above 3 rad).
  CartesianSections build() const;

 private:
  struct Segment {
    std::vector<PosePiece> pieces;
    std::vector<double> begins;
    double length = 0;
    double curve_radius;
    Corner corner;  ///< its end, named
    Pose end;
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
};

}  // namespace polyarm::paths
