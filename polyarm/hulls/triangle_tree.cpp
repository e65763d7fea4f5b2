#include "polyarm/hulls/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::hulls {

namespace {

constexpr std::uint32_t kLeaf = 6;  // largest number of triangles in a leaf
constexpr std::size_t kDeepest = 64;

double part(const Vec3& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
Vec3 smaller(const Vec3& a, const Vec3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3 larger(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

double squared_distance_to_box(const Vec3& lower, const Vec3& upper, const Vec3& p) {
  double out = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = std::max({part(lower, k) - part(p, k), 0.0, part(p, k) - part(upper, k)});
    out += d * d;
  }
  return out;
}

bool meets_box(const Vec3& lower, const Vec3& upper, const Vec3& p, const Vec3& inverse_direction) {
  double from = 0, to = 1e300;
  for (int k = 0; k < 3; ++k) {
    const double inverse = part(inverse_direction, k);
    double a = (part(lower, k) - part(p, k)) * inverse, b = (part(upper, k) - part(p, k)) * inverse;
    if (a > b) std::swap(a, b);
    from = std::max(from, a);
    to = std::min(to, b);
  }
  return from <= to;
}

/// Source: Möller, Trumbore 1997.
bool meets_triangle(const Triangle& t, const Vec3& p, const Vec3& direction) {
  const Vec3 e1 = t[1] - t[0], e2 = t[2] - t[0], h = cross(direction, e2);
  const double determinant = dot(e1, h);
  if (std::abs(determinant) < 1e-300) return false;
  const Vec3 s = p - t[0];
  const double u = dot(s, h) / determinant;
  if (u < 0 || u > 1) return false;
  const Vec3 q = cross(s, e1);
  const double v = dot(direction, q) / determinant;
  return v >= 0 && u + v <= 1 && dot(e2, q) / determinant > 0;
}

}  // namespace

Vec3 nearest_point(const Triangle& triangle, const Vec3& p) {
  const auto& [a, b, c] = triangle;
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
  const double sum = va + vb + vc;
  if (!(sum > 0)) return a;  // a triangle without area
  return a + (vb / sum) * ab + (vc / sum) * ac;
}

TriangleTree::TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  nodes_.reserve(triangles_.size() / 2 + 1);
  build(0, static_cast<std::uint32_t>(triangles_.size()));
}

std::uint32_t TriangleTree::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node{triangles_[begin][0], triangles_[begin][0], begin, end, 0};
  for (std::uint32_t i = begin; i < end; ++i)
    for (const Vec3& corner : triangles_[i]) {
      node.lower = smaller(node.lower, corner);
      node.upper = larger(node.upper, corner);
    }
  nodes_.push_back(node);
  if (end - begin <= kLeaf) return index;
  const Vec3 size = node.upper - node.lower;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t half = begin + (end - begin) / 2;  // equal halves keep the depth logarithmic
  const auto key = [&](const Triangle& t) { return part(t[0], axis) + part(t[1], axis) + part(t[2], axis); };
  std::nth_element(triangles_.begin() + begin, triangles_.begin() + half, triangles_.begin() + end,
                   [&](const Triangle& a, const Triangle& b) { return key(a) < key(b); });
  build(begin, half);
  const std::uint32_t right = build(half, end);
  nodes_[index].right = right;
  return index;
}

double TriangleTree::distance(const Vec3& point) const {
  std::array<std::uint32_t, kDeepest> open{};
  std::size_t count = 1;
  double best = 1e300;
  while (count > 0) {
    const std::uint32_t index = open[--count];
    const Node& node = nodes_[index];
    if (squared_distance_to_box(node.lower, node.upper, point) >= best) continue;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const Vec3 d = nearest_point(triangles_[i], point) - point;
        best = std::min(best, dot(d, d));
      }
      continue;
    }
    const Node &left = nodes_[index + 1], &right = nodes_[node.right];
    const bool left_first = squared_distance_to_box(left.lower, left.upper, point) <=
                            squared_distance_to_box(right.lower, right.upper, point);
    open[count++] = left_first ? node.right : index + 1;
    open[count++] = left_first ? index + 1 : node.right;  // visited next
  }
  return std::sqrt(best);
}

bool TriangleTree::escapes(const Vec3& point, const Vec3& direction) const {
  const Vec3 inverse{1 / direction.x, 1 / direction.y, 1 / direction.z};
  std::array<std::uint32_t, kDeepest> open{};
  std::size_t count = 1;
  while (count > 0) {
    const std::uint32_t index = open[--count];
    const Node& node = nodes_[index];
    if (!meets_box(node.lower, node.upper, point, inverse)) continue;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        if (meets_triangle(triangles_[i], point, direction)) return false;
      continue;
    }
    open[count++] = node.right;
    open[count++] = index + 1;
  }
  return true;
}

std::vector<Triangle> surface_of(const meshes::Mesh& mesh, const Vec3& scale) {
  std::vector<Triangle> out;
  for (const meshes::MeshPart& part : mesh)
    for (std::size_t i = 0; i + 2 < part.triangles.size(); i += 3) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& p = part.positions[part.triangles[i + k]];
        triangle[k] = {scale.x * p[0], scale.y * p[1], scale.z * p[2]};
      }
      out.push_back(triangle);
    }
  return out;
}

}  // namespace polyarm::hulls
