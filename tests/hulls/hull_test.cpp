#include "polyarm/hulls/hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace polyarm::hulls {
namespace {

std::vector<Vec3> corners_of_cube(double edge) {
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i) out.push_back({i & 1 ? edge : 0, i & 2 ? edge : 0, i & 4 ? edge : 0});
  return out;
}

std::vector<Vec3> on_a_sphere(std::size_t count, double radius) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Vec3> out;
  while (out.size() < count)
    out.push_back(radius * normalized(Vec3{normal(random), normal(random), normal(random)}));
  return out;
}

double furthest_out(const Hull& hull, const std::vector<Vec3>& points) {
  double out = -1;
  for (const Vec3& p : points) out = std::max(out, distance_outside(hull, p));
  return out;
}

/// Each edge belongs to two faces that pass it in opposite directions.
bool is_closed(const Hull& hull) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& face : hull.faces)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{face[k], face[(k + 1) % 3]}];
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    return edge.second == 1 && edges.contains({edge.first.second, edge.first.first});
  });
}

TEST(ConvexHull, OfACubeHasItsCornersAndItsVolume) {
  std::vector<Vec3> points = corners_of_cube(2);
  points.push_back({1, 1, 1});
  points.push_back({1, 0, 1});
  const Hull hull = convex_hull(points);
  EXPECT_EQ(hull.corners.size(), 8u);
  EXPECT_NEAR(hull.volume, 8, 1e-12);
  EXPECT_TRUE(is_closed(hull));
  EXPECT_NEAR(distance_outside(hull, {3, 1, 1}), 1, 1e-12);
  EXPECT_LT(distance_outside(hull, {1, 1, 1}), 0);
}

TEST(ConvexHull, OfPointsWithoutAVolumeGetsTheLeastThickness) {
  const std::vector<std::vector<Vec3>> flat = {
      {{1, 2, 3}},
      {{0, 0, 0}, {1, 1, 1}, {0.3, 0.3, 0.3}},
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.2, 0.7, 0}},
      {{5, 5, 5}, {5, 5, 5}, {5, 5, 5}, {5, 5, 5}},
  };
  for (const auto& points : flat) {
    const Hull hull = convex_hull(points);
    EXPECT_GT(hull.volume, 0.5 * kThinnest * kThinnest * kThinnest);
    EXPECT_LE(furthest_out(hull, points), 1e-9);
    EXPECT_TRUE(is_closed(hull));
  }
}

TEST(ConvexHull, ContainsAnyPoints) {
  std::mt19937 random(7);
  for (int round = 0; round < 100; ++round) {
    const double scale = std::pow(10.0, static_cast<double>(round % 7) - 3);
    std::uniform_real_distribution<double> uniform(-scale, scale);
    std::vector<Vec3> points;
    for (int i = 0; i < 4 + 3 * round; ++i)
      points.push_back({uniform(random), uniform(random), 1e-3 * uniform(random)});
    const Hull hull = convex_hull(points);
    EXPECT_LE(furthest_out(hull, points), 1e-9 * scale) << round;
    EXPECT_TRUE(is_closed(hull)) << round;
  }
}

TEST(EnclosingHull, OfManyPointsHasFewCornersAndLosesNone) {
  const std::vector<Vec3> points = on_a_sphere(20'000, 0.1);
  for (const std::size_t most : {std::size_t{16}, std::size_t{64}, std::size_t{128}}) {
    const Hull hull = enclosing_hull(points, most);
    EXPECT_LE(hull.corners.size(), most);
    EXPECT_LE(furthest_out(hull, points), 1e-9);
    EXPECT_GT(hull.volume, 4.0 / 3 * std::numbers::pi * 1e-3 * 0.999);
  }
  EXPECT_LT(enclosing_hull(points, 128).volume, 4.0 / 3 * std::numbers::pi * 1e-3 * 1.12);
}

TEST(EnclosingHull, OfFewPointsIsTheExactOne) {
  EXPECT_NEAR(enclosing_hull(corners_of_cube(1), 8).volume, 1, 1e-12);
}

}  // namespace
}  // namespace polyarm::hulls
