#include "polyarm/description/shape_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::description {

namespace {
Vec3 half_extents(const Shape& s, const Quaternion& q) {
  const Vec3 z = q * Vec3{0, 0, 1};
  switch (s.kind) {
    case ShapeKind::box: {
      const Vec3 a = 0.5 * s.size.x * (q * Vec3{1, 0, 0}), b = 0.5 * s.size.y * (q * Vec3{0, 1, 0}),
                 c = 0.5 * s.size.z * z;
      return {std::abs(a.x) + std::abs(b.x) + std::abs(c.x), std::abs(a.y) + std::abs(b.y) + std::abs(c.y),
              std::abs(a.z) + std::abs(b.z) + std::abs(c.z)};
    }
    case ShapeKind::cylinder: {
      const auto along = [&](double n) {
        return std::abs(n) * s.length / 2 + s.radius * std::sqrt(std::max(0.0, 1 - n * n));
      };
      return {along(z.x), along(z.y), along(z.z)};
    }
    case ShapeKind::capsule: {
      const auto along = [&](double n) { return std::abs(n) * s.length / 2 + s.radius; };
      return {along(z.x), along(z.y), along(z.z)};
    }
    default:
      return {s.radius, s.radius, s.radius};
  }
}
}  // namespace

bool Bounds::near(const Bounds& o, double m) const noexcept {
  return lower.x <= o.upper.x + m && o.lower.x <= upper.x + m && lower.y <= o.upper.y + m &&
         o.lower.y <= upper.y + m && lower.z <= o.upper.z + m && o.lower.z <= upper.z + m;
}

bool Bounds::contains(const Vec3& p) const noexcept {
  return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y && p.z >= lower.z &&
         p.z <= upper.z;
}

namespace {
Bounds bounds_of_pieces(const Shape& shape, const Pose& at) noexcept {
  Bounds out{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
  for (const auto& piece : shape.pieces)
    for (const Vec3& corner : piece) {
      const Vec3 p = at * corner;
      out.lower = {std::min(out.lower.x, p.x), std::min(out.lower.y, p.y), std::min(out.lower.z, p.z)};
      out.upper = {std::max(out.upper.x, p.x), std::max(out.upper.y, p.y), std::max(out.upper.z, p.z)};
    }
  return out;
}
}  // namespace

Bounds bounds_of(const Shape& shape, const Pose& pose) noexcept {
  const Pose at = pose * shape.pose;
  if (shape.kind == ShapeKind::mesh && !shape.pieces.empty()) return bounds_of_pieces(shape, at);
  const Vec3 half = half_extents(shape, at.rotation);
  return {at.position - half, at.position + half};
}

}  // namespace polyarm::description
