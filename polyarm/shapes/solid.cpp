#include "polyarm/shapes/solid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace polyarm::shapes {

using meshes::Mesh;
using meshes::MeshPart;

namespace {

constexpr std::uint32_t kAround = 28;  // segments around an axis
constexpr std::uint32_t kCorner = 6;   // points on each corner of a section
constexpr std::uint32_t kEdge = 3;     // segments across a rounded edge
constexpr double kLeast = 1e-5;        // m; smaller features are not drawn
constexpr double kThinnest = 2e-10;    // m²; twice the area of the smallest triangle of a skin

std::array<float, 3> point(const Vec3& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

std::uint32_t add(MeshPart& part, const Vec3& p) {
  part.positions.push_back(point(p));
  return static_cast<std::uint32_t>(part.positions.size() - 1);
}

/// Drops triangles from `from` on that are too thin to have a normal.
void drop_slivers(MeshPart& part, std::size_t from) {
  const auto corner = [&](std::size_t i) {
    const auto& p = part.positions[part.triangles[i]];
    return Vec3{p[0], p[1], p[2]};
  };
  std::size_t to = from;
  for (std::size_t i = from; i + 2 < part.triangles.size(); i += 3) {
    if (norm(cross(corner(i + 1) - corner(i), corner(i + 2) - corner(i))) < kThinnest) continue;
    for (std::size_t k = 0; k < 3; ++k) part.triangles[to++] = part.triangles[i + k];
  }
  part.triangles.resize(to);
}

/// Connects two closed loops of `count` points each, which begin at `a` and `b`.
void band(MeshPart& part, std::uint32_t a, std::uint32_t b, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t j = (i + 1) % count;
    for (const std::uint32_t corner : {a + i, a + j, b + j, a + i, b + j, b + i})
      part.triangles.push_back(corner);
  }
}

/// Closes a loop with a fan. `up`: the loop is anticlockwise seen from outside.
void lid(MeshPart& part, std::uint32_t loop, std::uint32_t count, const Vec3& center, bool up) {
  const std::uint32_t middle = add(part, center);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t a = loop + i, b = loop + (i + 1) % count;
    for (const std::uint32_t corner : {middle, up ? a : b, up ? b : a}) part.triangles.push_back(corner);
  }
}

/// The corners of a section, anticlockwise about its z.
std::vector<Vec3> outline(const Section& section) {
  const double corner = std::clamp(section.corner, 0.0, std::min(section.half_x, section.half_y));
  std::vector<Vec3> out;
  for (std::uint32_t k = 0; k < 4 * kCorner; ++k) {
    const std::uint32_t quarter = k / kCorner;
    const double angle = std::numbers::pi / 2 * (quarter + static_cast<double>(k % kCorner) / (kCorner - 1));
    const double sx = quarter == 0 || quarter == 3 ? 1 : -1, sy = quarter < 2 ? 1 : -1;
    const Vec3 p{sx * (section.half_x - corner) + corner * std::cos(angle),
                 sy * (section.half_y - corner) + corner * std::sin(angle), 0};
    out.push_back(section.frame * p);
  }
  return out;
}

}  // namespace

MeshPart& Solid::part(const Paint& paint) {
  for (MeshPart& each : parts_)
    if (std::equal(paint.color.begin(), paint.color.end(), each.color.begin()) &&
        each.roughness == paint.roughness && each.metallic == paint.metallic)
      return each;
  MeshPart& out = parts_.emplace_back();
  std::copy(paint.color.begin(), paint.color.end(), out.color.begin());
  out.colored = true;
  out.roughness = paint.roughness;
  out.metallic = paint.metallic;
  return out;
}

void Solid::turn(const Pose& frame, std::span<const Ring> profile, const Paint& paint) {
  MeshPart& out = part(paint);
  std::uint32_t before = 0;
  for (std::size_t r = 0; r < profile.size(); ++r) {
    const auto begin = static_cast<std::uint32_t>(out.positions.size());
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      add(out, frame * Vec3{profile[r].radius * std::cos(angle), profile[r].radius * std::sin(angle),
                            profile[r].at});
    }
    if (r > 0) band(out, before, begin, kAround);
    before = begin;
  }
}

void Solid::drum(const Pose& frame, double from, double to, double radius, double edge_from, double edge_to,
                 const Paint& paint) {
  if (from > to) {
    std::swap(from, to);
    std::swap(edge_from, edge_to);
  }
  if (to - from < kLeast || radius < kLeast) return;
  const double most = std::min(0.98 * radius, 0.5 * (to - from));
  std::vector<Ring> rings{{0, from}};
  for (const bool top : {false, true}) {
    const double e = std::clamp(top ? edge_to : edge_from, 0.0, most);
    for (std::uint32_t k = 0; k <= kEdge; ++k) {
      const double angle = std::numbers::pi / 2 * (top ? kEdge - k : k) / kEdge;
      const double inset = e * (1 - std::cos(angle));
      rings.push_back({radius - e * (1 - std::sin(angle)), top ? to - inset : from + inset});
    }
  }
  rings.push_back({0, to});
  turn(frame, rings, paint);
}

void Solid::loft(std::span<const Section> sections, const Paint& paint) {
  std::vector<std::vector<Vec3>> loops;
  for (const Section& section : sections) loops.push_back(outline(section));
  skin(loops, paint);
}

void Solid::skin(std::span<const std::vector<Vec3>> loops, const Paint& paint) {
  if (loops.size() < 2 || loops[0].empty()) return;
  MeshPart& out = part(paint);
  const auto count = static_cast<std::uint32_t>(loops[0].size());
  const auto first = static_cast<std::uint32_t>(out.positions.size());
  const std::size_t triangles = out.triangles.size();
  for (const std::vector<Vec3>& loop : loops)
    for (const Vec3& p : loop) add(out, p);
  for (std::uint32_t i = 0; i + 1 < loops.size(); ++i)
    band(out, first + i * count, first + (i + 1) * count, count);
  const auto middle = [&](const std::vector<Vec3>& loop) {
    Vec3 sum;
    for (const Vec3& p : loop) sum = sum + p;
    return (1.0 / count) * sum;
  };
  lid(out, first, count, middle(loops.front()), false);
  lid(out, first + (static_cast<std::uint32_t>(loops.size()) - 1) * count, count, middle(loops.back()), true);
  drop_slivers(out, triangles);
}

void Solid::box(const Pose& frame, const Vec3& size, double edge, const Paint& paint) {
  const double smallest = std::min({size.x, size.y, size.z});
  if (smallest < kLeast) return;
  const double e = std::clamp(edge, 0.0, 0.49 * smallest);
  std::vector<Section> sections;
  for (const bool top : {false, true})
    for (std::uint32_t k = 0; k <= kEdge; ++k) {
      const double angle = std::numbers::pi / 2 * (top ? k : kEdge - k) / kEdge;
      const double in = e * (1 - std::cos(angle));
      const double z = (top ? 1 : -1) * (size.z / 2 - e * (1 - std::sin(angle)));
      sections.push_back({frame * Pose{{0, 0, z}, {}}, size.x / 2 - in, size.y / 2 - in, e});
    }
  loft(sections, paint);
}

Mesh Solid::take() {
  for (MeshPart& each : parts_) meshes::tidy(each);
  std::erase_if(parts_, [](const MeshPart& each) { return each.triangles.empty(); });
  return std::exchange(parts_, {});
}

Pose frame_along(const Vec3& at, const Vec3& z, const Vec3& x) {
  const Vec3 up = normalized(z);
  const Vec3 flat = x - dot(x, up) * up;
  if (norm(flat) < 1e-6 * std::max(1.0, norm(x))) return frame_along(at, z);
  const Quaternion turn = rotation_between({0, 0, 1}, up);
  const Vec3 have = turn * Vec3{1, 0, 0}, want = normalized(flat);
  const double angle = std::atan2(dot(cross(have, want), up), dot(have, want));
  return {at, from_axis_angle(up, angle) * turn};
}

Pose frame_along(const Vec3& at, const Vec3& z) {
  return {at, rotation_between({0, 0, 1}, normalized(z))};
}

}  // namespace polyarm::shapes
