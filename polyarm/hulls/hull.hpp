#pragma once
/// Convex hulls of points in space. Lengths in metres, in the frame of the points. Any thread.
/// Source of the hull: Barber, Dobkin, Huhdanpaa 1996, by the library Qhull.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"

namespace polyarm::hulls {

/// Three axes at right angles, each of length 1, from the longest extent of the points to the shortest.
struct Axes {
  std::array<Vec3, 3> direction;
  std::array<double, 3> lower{}, upper{};  ///< extents along them, m
};
/// The principal axes of the points. Needs one point at least.
Axes principal_axes(std::span<const Vec3> points);

/// A convex polyhedron.
struct Hull {
  std::vector<Vec3> corners;
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< corners, anticlockwise seen from outside
  double volume = 0;                                ///< m³
};

/// Points p with dot(normal, p) < offset are below it.
struct Plane {
  Vec3 normal;
  double offset = 0;
};

/// The thinnest hull that is made, m: flat points get this thickness. Physics needs a volume.
inline constexpr double kThinnest = 5e-4;

/// The hull of finite points, at least one. Points in a plane, on a line or in one place get a thickness of
/// kThinnest. Where Qhull finds no hull, the box along the principal axes is the answer.
Hull convex_hull(std::span<const Vec3> points);

/// A polyhedron that contains all points and has at most `most` corners (at least 8): the exact hull, or the
/// hull of some points that is grown about its middle. Adds corners until it grows by less than `growth`.
Hull enclosing_hull(std::span<const Vec3> points, std::size_t most, double growth = 0.005);

/// How far a point is outside, m: the largest distance to the plane of a face; negative inside.
double distance_outside(const Hull& hull, const Vec3& point);

}  // namespace polyarm::hulls
