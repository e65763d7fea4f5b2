#include "polyarm/closed_form/subproblems.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/closed_form/conic.hpp"
#include "tests/closed_form/sample_families.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace polyarm::kinematics {
namespace {

constexpr int kDraws = 2000;
const Lane kSides{1, -1, 1, -1, 1, -1, 1, -1};
const LaneAngle kOffered{splat(std::sin(0.7)), splat(std::cos(0.7))};

double angle(const LaneAngle& a, std::size_t lane) {
  return std::atan2(a.s[lane], a.c[lane]);
}
Vec3 turn(const Vec3& k, double by, const Vec3& v) {
  return rotation_about(k, by) * v;
}
/// How far a result is from being an angle.
double off_circle(const LaneAngle& a) {
  return std::abs(a.s[0] * a.s[0] + a.c[0] * a.c[0] - 1) + std::abs(a.s[1] * a.s[1] + a.c[1] * a.c[1] - 1);
}

TEST(Subproblem1, TurnsOnePointOntoTheOther) {
  Random random(2);
  for (int i = 0; i < kDraws; ++i) {
    const Vec3 k = test::random_direction(random), p = test::random_vector(random, 1);
    const double by = random.between(-3, 3);
    LaneMask free{};
    const LaneAngle found = subproblem_1(splat(p), splat(turn(k, by, p)), k, 1e-12, kOffered, free);
    EXPECT_NEAR(angle(found, 0), by, 1e-9);
    EXPECT_FALSE(free[0]);
  }
}

TEST(Subproblem1, ComesAsNearAsCanBeAndTakesTheOfferOnTheAxis) {
  Random random(3);
  for (int i = 0; i < kDraws; ++i) {
    const Vec3 k = test::random_direction(random), p = test::random_vector(random, 1);
    const Vec3 q = test::random_vector(random, 1);
    LaneMask free{};
    const double found = angle(subproblem_1(splat(p), splat(q), k, 1e-12, kOffered, free), 0);
    const double there = norm(turn(k, found, p) - q);
    for (const double aside : {-0.3, -0.01, 0.01, 0.3}) EXPECT_LE(there, norm(turn(k, found + aside, p) - q));
    LaneMask on_axis{};
    EXPECT_NEAR(angle(subproblem_1(splat(0.4 * k), splat(q), k, 1e-12, kOffered, on_axis), 5), 0.7, 1e-12);
    EXPECT_TRUE(on_axis[5]);
  }
}

TEST(Subproblem2, BringsTwoPointsTogetherInBothWays) {
  Random random(4);
  for (int i = 0; i < kDraws; ++i) {
    const Vec3 a = test::random_direction(random), b = test::random_direction(random);
    const Vec3 p = test::random_vector(random, 1);
    const double first = random.between(-3, 3), second = random.between(-3, 3);
    const Vec3 q = turn(b, -second, turn(a, first, p));
    LaneMask free{};
    LaneAngle t1, t2;
    subproblem_2(splat(p), splat(q), a, b, kSides, {}, 1e-12, kOffered, kOffered, t1, t2, free);
    double nearest = 10;
    for (const std::size_t lane : {0u, 1u}) {
      EXPECT_LT(norm(turn(a, angle(t1, lane), p) - turn(b, angle(t2, lane), q)), 1e-6);
      nearest = std::min(nearest, std::abs(angle(t1, lane) - first) + std::abs(angle(t2, lane) - second));
    }
    EXPECT_LT(nearest, 1e-5);
  }
}

TEST(Subproblem3, FindsBothPlacesAtADistance) {
  Random random(5);
  for (int i = 0; i < kDraws; ++i) {
    const Vec3 k = test::random_direction(random), p = test::random_vector(random, 1);
    const Vec3 q = test::random_vector(random, 1);
    const double by = random.between(-3, 3), d = norm(turn(k, by, p) - q);
    LaneMask free{};
    const LaneAngle found =
        subproblem_3(splat(p), splat(q), k, splat(d * d), kSides, {}, 1e-12, kOffered, free);
    EXPECT_NEAR(norm(turn(k, angle(found, 0), p) - q), d, 1e-9);
    EXPECT_NEAR(norm(turn(k, angle(found, 1), p) - q), d, 1e-9);
    EXPECT_LT(std::min(std::abs(angle(found, 0) - by), std::abs(angle(found, 1) - by)), 1e-5);
    EXPECT_LT(off_circle(found), 1e-9);
  }
}

TEST(Subproblem4, OutOfReachItGivesTheNearestAndIsContinuousThere) {
  Random random(6);
  for (int i = 0; i < kDraws; ++i) {
    const Vec3 k = test::random_direction(random), p = test::random_vector(random, 1);
    const Vec3 h = test::random_direction(random);
    const Vec3 across = cross(k, p);
    const double most = dot(h, dot(k, p) * k) + std::hypot(dot(h, across), dot(h, cross(k, across)));
    LaneMask free{};
    const LaneAngle beyond =
        subproblem_4(splat(h), splat(p), k, splat(most + 0.3), kSides, {}, 1e-12, kOffered, free);
    EXPECT_NEAR(dot(h, turn(k, angle(beyond, 0), p)), most, 1e-9);
    EXPECT_NEAR(angle(beyond, 0), angle(beyond, 1), 1e-12);
    const LaneAngle below =
        subproblem_4(splat(h), splat(p), k, splat(most - 1e-12), kSides, {}, 1e-12, kOffered, free);
    EXPECT_LT(std::abs(std::remainder(angle(below, 0) - angle(beyond, 0), 2 * std::numbers::pi)), 1e-3);
  }
}

TEST(WristBend, KeepsItsDigitsWhereAWristIsSingular) {
  Random random(7);
  for (const double bend : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const Vec3 a = test::random_direction(random), b = normalized(cross(a, test::random_direction(random)));
    const Vec3 u = turn(a, 1.1, turn(b, bend, a));
    LaneMask free{};
    const LaneAngle found = wrist_bend(a, b, a, splat(u), kSides, {}, free);
    EXPECT_NEAR(angle(found, 0), bend, 1e-15 + 1e-12 * bend);
    EXPECT_NEAR(angle(found, 1), -bend, 1e-15 + 1e-12 * bend);
  }
}

/// What is left of a conic's equation at a point of the circle.
double left_over(const LaneConic& q, double c, double s) {
  return q.cc[0] * c * c + q.cs[0] * c * s + q.ss[0] * s * s + q.c1[0] * c + q.s1[0] * s + q.one[0];
}
/// The nearest of the four points to an angle.
double nearest_point_to(const LaneConic& q, double at) {
  const LaneLines lines = lines_of(q, 1e-12);
  double nearest = 10;
  for (std::size_t line = 0; line < 2; ++line)
    for (const double side : {1.0, -1.0}) {
      LaneMask free{};
      const LaneAngle p = point_on(lines.normal[line], lines.reach[line], splat(side), {}, free);
      EXPECT_LT(off_circle(p), 1e-12);
      nearest = std::min(nearest, std::abs(std::remainder(angle(p, 0) - at, 2 * std::numbers::pi)));
    }
  return nearest;
}

TEST(Conic, MeetsTheCircleWhereItWasDrawnThrough) {
  Random random(8);
  for (int i = 0; i < kDraws; ++i) {
    const double at = random.between(-3, 3), c = std::cos(at), s = std::sin(at);
    LaneConic q;
    for (Lane* k : {&q.cc, &q.cs, &q.ss, &q.c1, &q.s1}) *k = splat(random.between(-1, 1));
    q.one = splat(-left_over(q, c, s));
    const double slope =
        (q.ss[0] - q.cc[0]) * std::sin(2 * at) + q.cs[0] * std::cos(2 * at) - q.c1[0] * s + q.s1[0] * c;
    EXPECT_LT(nearest_point_to(q, at), 1e-13 / std::max(1e-7, std::abs(slope)) + 1e-12);
  }
}

/// Two lines that cross on the circle, or touch it: the roots fall together and are kept.
TEST(Conic, KeepsRootsThatFallTogether) {
  Random random(9);
  for (int i = 0; i < kDraws; ++i) {
    const double at = random.between(-3, 3), c = std::cos(at), s = std::sin(at);
    const double other = i % 2 ? at : random.between(-3, 3);
    LaneConic q;
    // (n . x - n . p)(m . x - m . p) with n the tangent's normal: touches at p.
    const double m0 = std::cos(other), m1 = std::sin(other), reach = m0 * c + m1 * s;
    q.cc = splat(c * m0);
    q.cs = splat(c * m1 + s * m0);
    q.ss = splat(s * m1);
    q.c1 = splat(-c * reach - m0);
    q.s1 = splat(-s * reach - m1);
    q.one = splat(reach);
    EXPECT_LT(nearest_point_to(q, at), 1e-3);
  }
}

}  // namespace
}  // namespace polyarm::kinematics
