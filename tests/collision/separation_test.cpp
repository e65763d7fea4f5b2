#include "polyarm/collision/separation.hpp"

#include <gtest/gtest.h>

#include "tests/collision/judge.hpp"

namespace polyarm::collision {
namespace {

ConvexBody ball(const Vec3& center, double radius) {
  return {{center}, radius, 0, {0, 0, 1}};
}
ConvexBody box(const Vec3& size) {
  Shape shape;
  shape.size = size;
  return bodies_of(shape).front();
}

TEST(Separation, IsExactForSpheres) {
  const Separation s = separation(ball({0, 0, 0}, 0.1), {{1, 2, 2}, {}}, ball({0, 0, 0}, 0.3));
  EXPECT_NEAR(s.distance, 2.6, 1e-12);
  EXPECT_NEAR(norm(s.on_a - s.on_b), 2.6, 1e-12);
}

TEST(Separation, IsExactForBoxesCornerToCorner) {
  const Separation s = separation(box({2, 2, 2}), {{3, 4, 5}, {}}, box({2, 2, 2}));
  EXPECT_NEAR(s.distance, std::sqrt(1 + 4 + 9), 1e-9);
  EXPECT_LE(s.lower, s.distance);
}

TEST(Separation, AgreesWithASlowJudgeForAllShapes) {
  Random random(5);
  int apart = 0, together = 0;
  for (int i = 0; i < 3000; ++i) {
    const Shape a = random_shape(random, 0.4), b = random_shape(random, 0.6);
    const Pose T_b_a{random_vector(random, 0.7), random_turn(random)};
    const ConvexBody first = bodies_of(a).front(), second = bodies_of(b).front();
    const Separation s = separation(first, T_b_a, second);
    const Bracket judge = slow_distance({&a, 0, T_b_a * a.pose}, {&b, 0, b.pose});
    EXPECT_LE(s.lower, judge.upper + 1e-9);
    if (judge.lower > 1e-6) {
      ++apart;
      EXPECT_GT(s.lower, 0);
      EXPECT_GE(s.distance, judge.lower - 1e-9);
      EXPECT_NEAR(s.lower, s.distance, 1e-5);
      EXPECT_NEAR(norm(s.on_a - s.on_b), s.distance, 1e-6);
      EXPECT_EQ(overlap(first, T_b_a, second).depth, 0);
    } else if (judge.upper < 1e-7) {
      ++together;
      EXPECT_LE(s.lower, 0);
    }
  }
  EXPECT_GT(apart, 500);
  EXPECT_GT(together, 100);
}

/// The last simplex is flat here, and seems to contain the origin.
TEST(Separation, RoundingMakesNoContact) {
  ConvexBody capsule, cylinder;
  capsule.points = {{0, 0, -0.16046737782865153}, {0, 0, 0.16046737782865153}};
  capsule.radius = 0.034427931601439046;
  cylinder.points = {{0, 0, -0.095097273314123015}, {0, 0, 0.095097273314123015}};
  cylinder.disc = 0.18932548810037667;
  const double s = 0.57735026918962584;
  const Pose pose{{-0.18361351022695052, 0.039675301565099283, 0.14349100024907407}, {-s, -s, 0, s}};
  const Separation found = separation(capsule, pose, cylinder);
  EXPECT_NEAR(found.distance, 0.009735, 1e-6);
  EXPECT_NEAR(found.lower, found.distance, 1e-6);
  EXPECT_EQ(overlap(capsule, pose, cylinder).depth, 0);
}

TEST(Separation, OverlapOfBoxesIsTheShortestWayOut) {
  const Depth d = overlap(box({1, 1, 1}), {{0.8, 0.1, 0}, {}}, box({1, 1, 1}));
  EXPECT_NEAR(d.depth, 0.2, 1e-6);
  EXPECT_NEAR(d.direction.x, 1, 1e-6);
}

TEST(Separation, AfterMovingByTheOverlapBodiesAreFree) {
  Random random(6);
  for (int i = 0; i < 500; ++i) {
    const Shape a = random_shape(random, 0.4), b = random_shape(random, 0.6);
    Pose T_b_a{random_vector(random, 0.2), random_turn(random)};
    const ConvexBody first = bodies_of(a).front(), second = bodies_of(b).front();
    if (separation(first, T_b_a, second).distance > 0) continue;
    const Depth d = overlap(first, T_b_a, second);
    EXPECT_GE(d.depth, 0);
    T_b_a.position = T_b_a.position + (d.depth + 1e-5) * d.direction;
    EXPECT_GT(separation(first, T_b_a, second).lower, 0);
  }
}

TEST(ConvexBody, RefusesSizesThatAreNotNumbers) {
  Shape shape;
  shape.size = {1, NAN, 1};
  EXPECT_THROW(bodies_of(shape), Error);
  shape.size = {1, -1, 1};
  EXPECT_THROW(bodies_of(shape), Error);
}

}  // namespace
}  // namespace polyarm::collision
