#include "polyarm/collision/convex_body.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/base/error.hpp"

namespace polyarm::collision {

using description::Shape;
using description::ShapeKind;

namespace {

constexpr int kRimCorners = 16;

bool good(double v) {
  return std::isfinite(v) && v >= 0;
}
bool finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void require_good(const Shape& shape) {
  const Quaternion& r = shape.pose.rotation;
  bool ok = good(shape.size.x) && good(shape.size.y) && good(shape.size.z) && good(shape.radius) &&
            good(shape.length) && finite(shape.pose.position) && finite({r.x, r.y, r.z}) &&
            std::isfinite(r.w);
  for (const auto& piece : shape.pieces)
    for (const Vec3& p : piece) ok = ok && finite(p);
  if (!ok)
    throw Error("bad-shape", "a shape has a size, radius, length or pose that is negative, NaN or infinite",
                "correct the shape in its file");
}

ConvexBody box(const Vec3& size) {
  ConvexBody out;
  for (int corner = 0; corner < 8; ++corner)
    out.points.push_back({(corner & 1 ? 0.5 : -0.5) * size.x, (corner & 2 ? 0.5 : -0.5) * size.y,
                          (corner & 4 ? 0.5 : -0.5) * size.z});
  return out;
}

/// Moves a centre towards the farthest point again and again (Badoiu and Clarkson 2003).
template <class Each>
Ball ball_of(Vec3 center, const Each& each) {
  constexpr int kSteps = 400;
  Ball best;
  best.radius = INFINITY;
  for (int i = 0; i < kSteps; ++i) {
    double far = -1;
    Vec3 there = center;
    each([&](const Vec3& p, double radius) {
      const double d = norm(p - center) + radius;
      if (d > far) far = d, there = p;
    });
    if (far < best.radius) best = {center, far};
    center = center + (1.0 / (i + 2)) * (there - center);
  }
  return best;
}

/// Points of the body, each with a radius; together they have the same bounding ball, or a slightly larger
/// one.
template <class Take>
void each_point(const ConvexBody& body, const Take& take) {
  for (const Vec3& p : body.points) take(p, body.radius);
}

}  // namespace

Vec3 ConvexBody::core_support(const Vec3& direction) const noexcept {
  const Vec3* best = &points.front();
  double most = dot(*best, direction);
  for (const Vec3& p : points)
    if (const double along = dot(p, direction); along > most) most = along, best = &p;
  if (disc <= 0) return *best;
  const Vec3 across = direction - dot(direction, axis) * axis;
  const double length = norm(across);
  return length > 1e-12 * norm(direction) ? *best + (disc / length) * across : *best;
}

ConvexBody moved(const Pose& T_to_from, const ConvexBody& body) {
  ConvexBody out = body;
  for (Vec3& p : out.points) p = T_to_from * p;
  out.axis = T_to_from.rotation * body.axis;
  return out;
}

ConvexBody without_discs(const ConvexBody& body) {
  if (body.disc <= 0) return body;
  ConvexBody out;
  out.radius = body.radius;
  const Vec3 some = std::abs(body.axis.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalized(cross(body.axis, some)), v = cross(body.axis, u);
  const double radius = body.disc / std::cos(std::numbers::pi / kRimCorners);
  for (const Vec3& p : body.points)
    for (int i = 0; i < kRimCorners; ++i) {
      const double a = 2 * std::numbers::pi * i / kRimCorners;
      out.points.push_back(p + (radius * std::cos(a)) * u + (radius * std::sin(a)) * v);
    }
  return out;
}

Ball bounding_ball(const ConvexBody& body) {
  return bounding_ball(std::vector<ConvexBody>{body});
}

Ball bounding_ball(const std::vector<ConvexBody>& bodies) {
  std::vector<ConvexBody> plain;
  Vec3 sum;
  double count = 0;
  for (const ConvexBody& body : bodies) {
    plain.push_back(without_discs(body));
    for (const Vec3& p : plain.back().points) sum = sum + p, ++count;
  }
  if (count == 0) return {};
  if (count == 1) return {sum, plain.front().radius};
  return ball_of((1 / count) * sum, [&](const auto& take) {
    for (const ConvexBody& body : plain) each_point(body, take);
  });
}

std::vector<ConvexBody> bodies_of(const Shape& shape) {
  require_good(shape);
  std::vector<ConvexBody> out;
  switch (shape.kind) {
    case ShapeKind::box:
      out.push_back(box(shape.size));
      break;
    case ShapeKind::sphere:
      out.push_back({{{}}, shape.radius, 0, {0, 0, 1}});
      break;
    case ShapeKind::capsule:
      out.push_back({{{0, 0, -shape.length / 2}, {0, 0, shape.length / 2}}, shape.radius, 0, {0, 0, 1}});
      break;
    case ShapeKind::cylinder:
      out.push_back({{{0, 0, -shape.length / 2}, {0, 0, shape.length / 2}}, 0, shape.radius, {0, 0, 1}});
      break;
    case ShapeKind::mesh:
      for (const std::vector<Vec3>& piece : shape.pieces)
        if (!piece.empty()) out.push_back({piece, 0, 0, {0, 0, 1}});
  }
  for (ConvexBody& body : out) body = moved(shape.pose, body);
  return out;
}

}  // namespace polyarm::collision
