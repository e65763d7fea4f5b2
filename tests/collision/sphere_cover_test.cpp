#include "polyarm/collision/sphere_cover.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/collision/judge.hpp"

namespace polyarm::collision {
namespace {

bool inside(const SphereCover& cover, const Vec3& p) {
  return std::any_of(cover.spheres.begin(), cover.spheres.end(),
                     [&](const Ball& b) { return norm(p - b.center) <= b.radius; });
}

/// Points of a shape, most of them on its surface.
std::vector<Vec3> points_of(const Shape& shape, Random& random, int count) {
  std::vector<Vec3> out;
  for (std::size_t k = 0; k < (shape.kind == ShapeKind::mesh ? shape.pieces.size() : 1); ++k) {
    const Placed at{&shape, k, shape.pose};
    for (int i = 0; i < count; ++i) {
      const Vec3 a = farthest(at, random_vector(random, 1)), b = farthest(at, random_vector(random, 1)),
                 c = farthest(at, random_vector(random, 1));
      const double s = random.unit(), t = random.unit() * (1 - s);
      out.push_back(a + s * (b - a) + t * (c - a));
      out.push_back(a);
    }
  }
  return out;
}

TEST(SphereCover, ContainsEveryPointOfTheBodies) {
  Random random(11);
  for (int round = 0; round < 60; ++round) {
    std::vector<Shape> shapes;
    std::vector<ConvexBody> bodies;
    for (int i = 0; i < 1 + round % 3; ++i) {
      shapes.push_back(random_shape(random, 0.3));
      for (const ConvexBody& body : bodies_of(shapes.back())) bodies.push_back(body);
    }
    const SphereCover made = cover(bodies, {static_cast<std::size_t>(1 + round % 20), 0.002});
    EXPECT_LE(made.spheres.size(), std::max<std::size_t>(1 + round % 20, shapes.size() + 1));
    for (const Shape& shape : shapes)
      for (const Vec3& p : points_of(shape, random, 200)) EXPECT_TRUE(inside(made, p)) << round;
  }
}

TEST(SphereCover, FitsACapsuleClosely) {
  Shape shape;
  shape.kind = ShapeKind::capsule;
  shape.radius = 0.06, shape.length = 0.4;
  const SphereCover made = cover(bodies_of(shape));
  EXPECT_LE(made.largest_excess, 0.00601);
  EXPECT_LE(made.spheres.size(), 9u);
}

TEST(SphereCover, OfASphereIsThatSphere) {
  Shape shape;
  shape.kind = ShapeKind::sphere;
  shape.radius = 0.2;
  const SphereCover made = cover(bodies_of(shape));
  ASSERT_EQ(made.spheres.size(), 1u);
  EXPECT_NEAR(made.spheres[0].radius, 0.2, 1e-6);
}

}  // namespace
}  // namespace polyarm::collision
