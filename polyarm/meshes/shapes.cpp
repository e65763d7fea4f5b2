#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "polyarm/meshes/mesh.hpp"

namespace polyarm::meshes {

using description::Shape;
using description::ShapeKind;

namespace {

constexpr std::uint32_t kAround = 32, kRings = 8;  // segments around z, and from an end to the equator of a
                                                   // sphere

MeshPart box(const Vec3& size) {
  MeshPart out;
  for (int i = 0; i < 8; ++i)
    out.positions.push_back({static_cast<float>((i & 1 ? 0.5 : -0.5) * size.x),
                             static_cast<float>((i & 2 ? 0.5 : -0.5) * size.y),
                             static_cast<float>((i & 4 ? 0.5 : -0.5) * size.z)});
  out.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return out;
}

/// A body of revolution about z: radius and height of its rings from bottom to top; the end rings have no
/// radius.
MeshPart turned(const std::vector<std::array<double, 2>>& rings) {
  MeshPart out;
  for (const auto& [radius, height] : rings)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      out.positions.push_back({static_cast<float>(radius * std::cos(angle)),
                               static_cast<float>(radius * std::sin(angle)), static_cast<float>(height)});
    }
  for (std::uint32_t ring = 0; ring + 1 < rings.size(); ++ring)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t a = ring * kAround + i, b = ring * kAround + (i + 1) % kAround;
      for (const std::uint32_t corner : {a, b, b + kAround, a, b + kAround, a + kAround})
        out.triangles.push_back(corner);
    }
  return out;
}

MeshPart cylinder(double radius, double length) {
  return turned({{0, -length / 2}, {radius, -length / 2}, {radius, length / 2}, {0, length / 2}});
}

/// A sphere, stretched in the middle by `length`.
MeshPart capsule(double radius, double length) {
  std::vector<std::array<double, 2>> rings;
  for (const int side : {-1, 1})
    for (std::uint32_t k = 0; k <= kRings; ++k) {
      const double angle = std::numbers::pi / 2 * (side < 0 ? kRings - k : k) / kRings;
      rings.push_back({radius * std::cos(angle), side * (radius * std::sin(angle) + length / 2)});
    }
  rings.front()[0] = rings.back()[0] = 0;
  return turned(rings);
}

}  // namespace

Mesh mesh_of_shape(const Shape& shape) {
  if (shape.kind == ShapeKind::mesh) return {};
  MeshPart part = shape.kind == ShapeKind::box ? box(shape.size)
                  : shape.kind == ShapeKind::cylinder
                      ? cylinder(shape.radius, shape.length)
                      : capsule(shape.radius, shape.kind == ShapeKind::sphere ? 0 : shape.length);
  tidy(part);
  return {std::move(part)};
}

}  // namespace polyarm::meshes
