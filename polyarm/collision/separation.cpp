#include "polyarm/collision/separation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace polyarm::collision {

namespace {

/// A point of the difference a - b, and the points of the bodies that make it.
struct Corner {
  Vec3 w, a, b;
};

/// The corners of a simplex with their weights; the weighted sum is its point nearest to the origin.
struct Simplex {
  std::array<Corner, 4> corner;
  std::array<double, 4> weight{};
  int size = 0;

  Vec3 nearest() const {
    Vec3 out;
    for (int i = 0; i < size; ++i) out = out + weight[at(i)] * corner[at(i)].w;
    return out;
  }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  void keep(std::initializer_list<int> which, std::initializer_list<double> weights) {
    Simplex out;
    for (const int i : which) out.corner[at(out.size++)] = corner[at(i)];
    std::copy(weights.begin(), weights.end(), out.weight.begin());
    *this = out;
  }
};

Simplex of_line(const Simplex& s) {
  Simplex out = s;
  const Vec3 a = s.corner[0].w, ab = s.corner[1].w - a;
  const double length = dot(ab, ab), t = -dot(a, ab);
  if (t <= 0 || length <= 0)
    out.keep({0}, {1});
  else if (t >= length)
    out.keep({1}, {1});
  else
    out.keep({0, 1}, {1 - t / length, t / length});
  return out;
}

/// Ericson 5.1.5, for the origin.
Simplex of_triangle(const Simplex& s) {
  Simplex out = s;
  const Vec3 a = s.corner[0].w, b = s.corner[1].w, c = s.corner[2].w, ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return out.keep({0}, {1}), out;
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return out.keep({1}, {1}), out;
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return out.keep({2}, {1}), out;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 - d3 > 0 ? d1 / (d1 - d3) : 0;
    return out.keep({0, 1}, {1 - t, t}), out;
  }
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 - d6 > 0 ? d2 / (d2 - d6) : 0;
    return out.keep({0, 2}, {1 - t, t}), out;
  }
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double sum = (d4 - d3) + (d5 - d6), t = sum > 0 ? (d4 - d3) / sum : 0;
    return out.keep({1, 2}, {1 - t, t}), out;
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return out.keep({0, 1}, {1, 0}), of_line(out);
  out.weight = {va / sum, vb / sum, vc / sum, 0};
  return out;
}

/// Returns a simplex of size 4 if the origin is inside.
Simplex of_tetrahedron(const Simplex& s) {
  static constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  Simplex best = s;
  double least = INFINITY;
  bool outside = false;
  for (const auto& face : kFaces) {
    const Vec3 a = s.corner[Simplex::at(face[0])].w, b = s.corner[Simplex::at(face[1])].w,
               c = s.corner[Simplex::at(face[2])].w, d = s.corner[Simplex::at(face[3])].w;
    const Vec3 n = cross(b - a, c - a);
    const double origin = -dot(a, n), fourth = dot(d - a, n);
    const bool flat = std::abs(fourth) <= 1e-14 * norm(n) * norm(d - a);
    if (!flat && origin * fourth >= 0) continue;  // the origin is on the inner side of this face
    outside = true;
    Simplex triangle = s;
    triangle.keep({face[0], face[1], face[2]}, {1, 0, 0});
    triangle = of_triangle(triangle);
    const Vec3 v = triangle.nearest();
    if (const double d2 = dot(v, v); d2 < least) least = d2, best = triangle;
  }
  if (!outside) best = s;
  return best;
}

Simplex reduced(const Simplex& s) {
  switch (s.size) {
    case 2:
      return of_line(s);
    case 3:
      return of_triangle(s);
    case 4:
      return of_tetrahedron(s);
    default:
      return s;
  }
}

struct Pair {
  const ConvexBody& a;
  const Pose& T_b_a;
  const ConvexBody& b;
  Quaternion back;  // from b's frame into a's

  Corner support(const Vec3& direction) const {
    Corner out;
    out.a = T_b_a * a.core_support(back * direction);
    out.b = b.core_support(-direction);
    out.w = out.a - out.b;
    return out;
  }
  /// How far `a` has to move along `direction` (unit) to be free of `b` there.
  double way_out(const Vec3& direction) const {
    return a.radius + b.radius - dot(support(-direction).w, direction);
  }
};

bool known(const Simplex& s, const Vec3& w) {
  for (int i = 0; i < s.size; ++i)
    if (s.corner[Simplex::at(i)].w == w) return true;
  return false;
}

}  // namespace

Separation separation(const ConvexBody& a, const Pose& T_b_a, const ConvexBody& b) noexcept {
  constexpr int kSteps = 100;
  constexpr double kTouch = 1e-10;
  const Pair pair{a, T_b_a, b, inverse(T_b_a.rotation)};
  const double radii = a.radius + b.radius;
  Simplex simplex;
  simplex.corner[0] = pair.support({1, 0, 0});
  simplex.weight[0] = 1;
  simplex.size = 1;
  double lower = 0, distance = 0;
  for (int step = 0; step < kSteps; ++step) {
    const Vec3 v = simplex.nearest();
    distance = norm(v);
    if (simplex.size == 4 || distance <= kTouch) return {-radii, -radii, {}, {}};
    const Corner next = pair.support(-v);
    lower = std::max(lower, dot(v, next.w) / distance);
    if (distance - lower <= 1e-9 * distance + 1e-12 || known(simplex, next.w)) break;
    Simplex grown = simplex;
    grown.corner[Simplex::at(grown.size++)] = next;
    grown = reduced(grown);
    if (grown.size == 4 && lower > kTouch) break;  // rounding: a plane is known that separates them
    const Vec3 u = grown.nearest();
    if (grown.size < 4 && !(dot(u, u) < distance * distance)) break;  // rounding: no progress
    simplex = grown;
  }
  Separation out{lower - radii, distance - radii, {}, {}};
  for (int i = 0; i < simplex.size; ++i) {
    out.on_a = out.on_a + simplex.weight[Simplex::at(i)] * simplex.corner[Simplex::at(i)].a;
    out.on_b = out.on_b + simplex.weight[Simplex::at(i)] * simplex.corner[Simplex::at(i)].b;
  }
  const Vec3 towards = (1 / distance) * (out.on_b - out.on_a);
  out.on_a = out.on_a + a.radius * towards;
  out.on_b = out.on_b - b.radius * towards;
  return out;
}

Depth overlap(const ConvexBody& a, const Pose& T_b_a, const ConvexBody& b) noexcept {
  if (separation(a, T_b_a, b).distance > 0) return {};
  const Pair pair{a, T_b_a, b, inverse(T_b_a.rotation)};
  constexpr int kDirections = 200, kMostTurns = 200;
  Depth best{INFINITY, {0, 0, 1}};
  const auto attempt = [&](const Vec3& direction) {
    const double depth = pair.way_out(direction);
    if (depth >= best.depth) return false;
    best = {depth, direction};
    return true;
  };
  for (int i = 0; i < kDirections; ++i) {  // evenly over the sphere (Fibonacci)
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    attempt({r * std::cos(angle), r * std::sin(angle), z});
  }
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    attempt(axis), attempt(-axis);
    attempt(T_b_a.rotation * axis), attempt(-(T_b_a.rotation * axis));
  }
  int turns = 0;
  for (double step = 0.15; step > 1e-5 && turns < kMostTurns;
       ++turns) {  // descent by turns of the best direction
    const Vec3 n = best.direction;
    const Vec3 u = normalized(cross(n, std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0})), v = cross(n, u);
    bool better = false;
    for (const Vec3& side : {u, -u, v, -v, u + v, u - v, v - u, -(u + v)})
      better = attempt(normalized(n + step * side)) || better;
    if (!better) step *= 0.5;
  }
  return best.depth > 0 ? best : Depth{};
}

}  // namespace polyarm::collision
