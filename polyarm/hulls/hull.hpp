#pragma once
/// Convex hulls of points in space. Lengths in metres, in the frame of the points. Any thread. Source:
/// Barber, Dobkin, Huhdanpaa 1996, implemented by the library Qhull.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "polyarm/base/pose.hpp"

namespace polyarm::hulls {

/// Three perpendicular unit axes, from the longest extent of the points to the shortest.
struct Axes {
  std::array<Vec3, 3> direction;
  std::array<double, 3> lower{}, upper{};  ///< extents along them, m
};
/// The principal axes of at least one point.
Axes principal_axes(std::span<const Vec3> points);

/// A convex polyhedron.
struct Hull {
  std::vector<Vec3> corners;
  std::vector<std::array<std::uint32_t, 3>> faces;  ///< corners, anticlockwise seen from outside
  double volume = 0;                                ///< m³
};

/// A plane. Points p with dot(normal, p) < offset are below it.
struct Plane {
  Vec3 normal;
  double offset = 0;
};

/// The smallest thickness of a hull, m. Flat points get this thickness, because physics needs a volume.
inline constexpr double kThinnest = 5e-4;

/// The hull of at least one finite point. Points in a plane, on a line or in one place get a thickness of
/// kThinnest. If Qhull finds no hull, the result is the box along the principal axes.
Hull convex_hull(std::span<const Vec3> points);

/// A polyhedron that contains all points and has at most `most` corners (at least 8): the exact hull, or the
/// hull of some of the points, grown about its centre. Adds corners until the growth is below `growth`.
Hull enclosing_hull(std::span<const Vec3> points, std::size_t most, double growth = 0.005);

/// The distance of a point from the hull, m: the largest distance from the plane of a face; negative inside.
double distance_outside(const Hull& hull, const Vec3& point);

}  // namespace polyarm::hulls
