#pragma once
/// Frames and tools from points that were touched.
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// The frame whose origin is `origin`, whose x axis goes through `on_x`, and whose xy plane holds `in_plane`
/// on the side of positive y. Throws Error("bad-points") where two are within 1 mm or the three nearly on a
/// line.
Pose frame_from_points(const Vec3& origin, const Vec3& on_x, const Vec3& in_plane);

struct TaughtTool {
  Vec3 tcp;                       ///< in tool0, m
  Vec3 tip;                       ///< where the poses say that the tip was, in their frame, m
  std::vector<double> residuals;  ///< of each pose: how far its tip is from there, m
  double rms = 0, largest = 0;    ///< of the residuals, m
};
/// The TCP of a tool whose tip touched one point with tool0 in four or more `poses` that differ in
/// orientation: R_i t + p_i = c for all i, least squares for t and c. Throws Error("bad-points") where they
/// do not say it.
TaughtTool tool_from_poses(std::span<const Pose> poses);
/// As data keep it: a pose in `tool0`, so that nobody takes it for a place in the world.
Point point_of(const TaughtTool& tool);

}  // namespace polyarm::data
