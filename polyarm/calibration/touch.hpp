#pragma once
/// Frames and tools computed from touched places. Metres, radians. Any thread; no hidden state. All functions
/// throw Error("bad-points") with the reason if the samples do not determine the result.
#include <span>
#include <vector>

#include "polyarm/calibration/estimate.hpp"

namespace polyarm::calibration {

/// The frame with origin `origin`; its x axis goes through `on_x`, and its xy plane contains `in_plane` on
/// the side of positive y. Refuses points within 1 mm of each other, and three that are nearly collinear.
Pose frame_from_points(const Vec3& origin, const Vec3& on_x, const Vec3& in_plane);

struct MatchedFrame {
  PoseEstimate frame;  ///< in the frame of the measured places
  Residuals residuals;
};
/// The frame in which the places have the coordinates `known`, from where they were `measured` (three or
/// more; least squares, Kabsch 1976). With places that two robots touch: the base of the one that says
/// `known`, in the frame of the other. Three places have no redundancy to speak of; four or more let
/// residuals show errors.
MatchedFrame frame_from_matches(std::span<const Vec3> known, std::span<const Vec3> measured);

struct TouchedTool {
  Vec3 tcp;                            ///< in tool0, m
  Vec3 tip;                            ///< position of the tip according to the poses, in their frame, m
  std::array<double, 9> covariance{};  ///< of `tcp`, m^2, row-major
  double sigma = 0;                    ///< m: one standard deviation of `tcp` in the worst direction
  Residuals residuals;                 ///< distance of each pose's tip from `tip`
};
/// The TCP of a tool whose tip touched one place with tool0 in four or more `poses` of different orientation:
/// R_i t + p_i = c for all i, least squares for t and c.
TouchedTool tool_from_poses(std::span<const Pose> poses);

/// The orientation of the TCP in tool0, from two more poses of tool0: the fixed tip lies on the tool's
/// positive z axis in `on_z` and in its xz plane on the side of positive x in `on_x`. `tcp` and `tip` are
/// those of tool_from_poses().
Quaternion tool_rotation(const Vec3& tcp, const Vec3& tip, const Pose& on_z, const Pose& on_x);

struct FlatTool {
  Vec3 axis;         ///< unit, in tool0: normal of the tool's face, out of the tool
  Vec3 normal;       ///< unit, in the frame of the poses: the same axis where the face lies flat
  double sigma = 0;  ///< rad: one standard deviation of `axis`
  Residuals residuals;
};
/// The axis of a tool whose flat face lay on one plane in two or more `poses` of tool0, turned about the
/// plane's normal between them by 30 degrees or more. `outwards`: a rough direction of the axis in tool0.
FlatTool axis_from_flat_poses(std::span<const Pose> poses, const Vec3& outwards = {0, 0, 1});
/// The orientation of a TCP whose z is `axis` (in tool0) and whose x is nearest to that of tool0.
Quaternion rotation_with_z(const Vec3& axis);

}  // namespace polyarm::calibration
