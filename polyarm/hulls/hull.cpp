#include "polyarm/hulls/hull.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <unordered_map>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace polyarm::hulls {

namespace {

Plane plane_of(const Hull& hull, const std::array<std::uint32_t, 3>& face) {
  const Vec3 &a = hull.corners[face[0]], &b = hull.corners[face[1]], &c = hull.corners[face[2]];
  const Vec3 normal = cross(b - a, c - a);
  const double length = norm(normal);
  if (!(length > 0)) return {{0, 0, 0}, 0};  // a degenerate triangle bounds nothing
  return {(1 / length) * normal, dot((1 / length) * normal, a)};
}

std::vector<Plane> planes_of(const Hull& hull) {
  std::vector<Plane> out;
  for (const auto& face : hull.faces) out.push_back(plane_of(hull, face));
  return out;
}

Vec3 middle_of(const std::vector<Vec3>& points) {
  Vec3 sum;
  for (const Vec3& p : points) sum = sum + p;
  return (1.0 / static_cast<double>(points.size())) * sum;
}

double volume_of(const Hull& hull) {
  double out = 0;
  const Vec3 origin = hull.corners.front();
  for (const auto& [a, b, c] : hull.faces)
    out += dot(hull.corners[a] - origin, cross(hull.corners[b] - origin, hull.corners[c] - origin)) / 6;
  return out;
}

/// Qhull's state, and the file that swallows its messages.
class Qhull {
 public:
  Qhull() : quiet_(std::fopen("/dev/null", "w"), std::fclose) { qh_zero(&state_, quiet_.get()); }
  ~Qhull() {
    qh_freeqhull(&state_, !qh_ALL);
    int lost = 0, parts = 0;
    qh_memfreeshort(&state_, &lost, &parts);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  /// Returns false if Qhull finds no hull.
  bool run(std::vector<coordT>& coordinates) {
    if (!quiet_) return false;
    char command[] = "qhull Qt Pp";
    return qh_new_qhull(&state_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), False,
                        command, quiet_.get(), quiet_.get()) == 0;
  }

  Hull hull() {
    Hull out;
    std::unordered_map<unsigned, std::uint32_t> number;
    const auto corner = [&](const vertexT* v) {
      const auto [at, is_new] = number.try_emplace(v->id, static_cast<std::uint32_t>(out.corners.size()));
      if (is_new) out.corners.push_back({v->point[0], v->point[1], v->point[2]});
      return at->second;
    };
    qhT* qh = &state_;  // Qhull's loop macros need this name
    facetT* facet = nullptr;
    FORALLfacets {
      std::array<std::uint32_t, 3> face{};
      std::size_t count = 0;
      vertexT *vertex = nullptr, **vertexp = nullptr;
      FOREACHvertex_(facet->vertices) {
        if (count < 3) face[count] = corner(vertex);
        ++count;
      }
      if (count != 3) continue;  // the option Qt makes all facets triangles
      const Vec3 &a = out.corners[face[0]], &b = out.corners[face[1]], &c = out.corners[face[2]];
      const Vec3 outward{facet->normal[0], facet->normal[1], facet->normal[2]};
      if (dot(cross(b - a, c - a), outward) < 0) std::swap(face[1], face[2]);
      out.faces.push_back(face);
    }
    return out;
  }

 private:
  std::unique_ptr<FILE, int (*)(FILE*)> quiet_;
  qhT state_{};
};

Hull box_along(const Axes& axes) {
  Hull out;
  for (int i = 0; i < 8; ++i) {
    Vec3 at;
    for (std::size_t k = 0; k < 3; ++k)
      at = at + ((i >> k) & 1 ? axes.upper[k] : axes.lower[k]) * axes.direction[k];
    out.corners.push_back(at);
  }
  out.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
               {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  out.volume = std::abs(volume_of(out));
  return out;
}

/// Widens thin extents to kThinnest; returns the points that it adds.
std::vector<Vec3> thicken(std::span<const Vec3> points, Axes& axes) {
  std::vector<Vec3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    const double missing = kThinnest - (axes.upper[k] - axes.lower[k]);
    if (missing <= 0) continue;
    if (out.empty()) out.assign(points.begin(), points.end());
    const std::vector<Vec3> flat = out;
    out.clear();
    for (const Vec3& p : flat)
      for (const double side : {-0.5, 0.5}) out.push_back(p + side * missing * axes.direction[k]);
    axes.lower[k] -= missing / 2;
    axes.upper[k] += missing / 2;
  }
  return out;
}

/// The outermost points in the directions of the axes and of the diagonals between them.
std::vector<std::size_t> outermost(std::span<const Vec3> points, const Axes& axes) {
  std::vector<std::size_t> out;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3 to = x * axes.direction[0] + y * axes.direction[1] + z * axes.direction[2];
        std::size_t best = 0;
        for (std::size_t i = 1; i < points.size(); ++i)
          if (dot(points[i], to) > dot(points[best], to)) best = i;
        out.push_back(best);
      }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// The factor by which a hull must grow about its centre to contain the points, and the outermost point of
/// each face.
struct Shortfall {
  double scale = 1;
  std::vector<std::size_t> outside;
};

Shortfall shortfall(const Hull& hull, const Vec3& middle, std::span<const Vec3> points) {
  Shortfall out;
  for (const Plane& plane : planes_of(hull)) {
    std::size_t best = 0;
    double furthest = -1e300;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (const double d = dot(plane.normal, points[i]); d > furthest) {
        furthest = d;
        best = i;
      }
    const double to_face = plane.offset - dot(plane.normal, middle);
    if (!(to_face > 0) || furthest <= plane.offset) continue;
    out.scale = std::max(out.scale, (furthest - dot(plane.normal, middle)) / to_face);
    out.outside.push_back(best);
  }
  std::sort(out.outside.begin(), out.outside.end());
  out.outside.erase(std::unique(out.outside.begin(), out.outside.end()), out.outside.end());
  return out;
}

Hull grown(Hull hull, const Vec3& middle, double scale) {
  for (Vec3& corner : hull.corners) corner = middle + scale * (corner - middle);
  hull.volume *= scale * scale * scale;
  return hull;
}

}  // namespace

Axes principal_axes(std::span<const Vec3> points) {
  Vec3 middle;
  for (const Vec3& p : points) middle = middle + (1.0 / static_cast<double>(points.size())) * p;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) {
    const Eigen::Vector3d d(p.x - middle.x, p.y - middle.y, p.z - middle.z);
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  Axes out;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d v = solver.eigenvectors().col(2 - k);
    out.direction[static_cast<std::size_t>(k)] = {v.x(), v.y(), v.z()};
  }
  for (std::size_t k = 0; k < 3; ++k) {
    out.lower[k] = 1e300;
    out.upper[k] = -1e300;
    for (const Vec3& p : points) {
      out.lower[k] = std::min(out.lower[k], dot(p, out.direction[k]));
      out.upper[k] = std::max(out.upper[k], dot(p, out.direction[k]));
    }
  }
  return out;
}

Hull convex_hull(std::span<const Vec3> points) {
  Axes axes = principal_axes(points);
  const std::vector<Vec3> thick = thicken(points, axes);
  if (!thick.empty()) points = thick;
  std::vector<coordT> coordinates;
  coordinates.reserve(3 * points.size());
  for (const Vec3& p : points) coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  Qhull qhull;
  if (!qhull.run(coordinates)) return box_along(axes);
  Hull out = qhull.hull();
  if (out.corners.size() < 4) return box_along(axes);
  out.volume = volume_of(out);
  return out;
}

Hull enclosing_hull(std::span<const Vec3> points, std::size_t most, double growth) {
  const Hull exact = convex_hull(points);
  if (exact.corners.size() <= most) return exact;
  const std::span<const Vec3> all = exact.corners;
  std::vector<std::size_t> chosen = outermost(all, principal_axes(all));
  if (chosen.size() > most) chosen.resize(most);
  for (;;) {
    std::vector<Vec3> some;
    for (const std::size_t i : chosen) some.push_back(all[i]);
    const Hull hull = convex_hull(some);
    const Vec3 middle = middle_of(hull.corners);
    const Shortfall missing = shortfall(hull, middle, all);
    const std::size_t before = chosen.size();
    if (missing.scale > 1 + growth)
      for (const std::size_t i : missing.outside)
        if (chosen.size() < most && std::find(chosen.begin(), chosen.end(), i) == chosen.end())
          chosen.push_back(i);
    if (chosen.size() == before) return grown(hull, middle, missing.scale);
  }
}

double distance_outside(const Hull& hull, const Vec3& point) {
  double out = -1e300;
  for (const Plane& plane : planes_of(hull)) out = std::max(out, dot(plane.normal, point) - plane.offset);
  return out;
}

}  // namespace polyarm::hulls
