#pragma once
/// Frames and tools computed from touched points. Metres, radians. Any thread; no hidden state.
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// The frame with origin `origin`; its x axis goes through `on_x`, and its xy plane contains `in_plane` on
/// the side of positive y. Throws Error("bad-points") if two points are within 1 mm or the three are nearly
/// collinear.
Pose frame_from_points(const Vec3& origin, const Vec3& on_x, const Vec3& in_plane);

struct TaughtTool {
  Vec3 tcp;                       ///< in tool0, m
  Vec3 tip;                       ///< position of the tip according to the poses, in their frame, m
  std::vector<double> residuals;  ///< for each pose: the distance of its tip from `tip`, m
  double rms = 0, largest = 0;    ///< of the residuals, m
};
/// The TCP of a tool whose tip touched one point with tool0 in four or more `poses` of different orientation:
/// R_i t + p_i = c for all i, least squares for t and c. Throws Error("bad-points") if the poses do not
/// determine it.
TaughtTool tool_from_poses(std::span<const Pose> poses);
/// The tool as data files store it: a pose in the frame `tool0`, so that it cannot be mistaken for a place in
/// the world.
Point point_of(const TaughtTool& tool);

}  // namespace polyarm::data
