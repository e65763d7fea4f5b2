/// Ways of a car: they end where they should, and no first step makes the rest shorter than it should be.
#include "polyarm/surroundings/car_ways.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "polyarm/kinematics/random.hpp"
#include "polyarm/surroundings/base_ground.hpp"

namespace polyarm::surroundings {
namespace {

constexpr double kHalfTurn = std::numbers::pi, kCarRadius = 1.7;

BasePlace random_place(kinematics::Random& random, double far) {
  return {random.between(-far, far), random.between(-far, far), random.between(-kHalfTurn, kHalfTurn)};
}

TEST(CarWays, KnownOnesHaveTheirLengths) {
  const auto length = [](double x, double y, double heading) {
    return shortest_car_way({}, {x, y, heading}, 1);
  };
  EXPECT_NEAR(length(3, 0, 0), 3, 1e-9);
  EXPECT_NEAR(length(-2, 0, 0), 2, 1e-9);
  EXPECT_NEAR(length(1, 1, kHalfTurn / 2), kHalfTurn / 2, 1e-9);
  EXPECT_NEAR(length(0, 2, kHalfTurn), kHalfTurn, 1e-9);
  EXPECT_NEAR(length(0, 0, kHalfTurn), kHalfTurn, 1e-9) << "round in three arcs of a sixth";
}

TEST(CarWays, EachEndsAtItsGoalWithArcsOfTheRadius) {
  kinematics::Random random(3);
  for (int k = 0; k < 500; ++k) {
    const BasePlace from = random_place(random, 4), to = random_place(random, 4);
    const std::vector<CarWay> ways = car_ways(from, to, kCarRadius);
    ASSERT_FALSE(ways.empty());
    double shortest = 1e9;
    for (const CarWay& way : ways) {
      BasePlace at = from;
      for (std::size_t p = 0; p < way.count; ++p) {
        const CarPiece& piece = way.pieces[p];
        EXPECT_TRUE(piece.curvature == 0 || std::abs(std::abs(piece.curvature) - 1 / kCarRadius) < 1e-12);
        at = along(at, piece.curvature, piece.length);
      }
      EXPECT_NEAR(at.x, to.x, 1e-5);
      EXPECT_NEAR(at.y, to.y, 1e-5);
      EXPECT_NEAR(std::remainder(at.heading - to.heading, 2 * kHalfTurn), 0, 1e-5);
      shortest = std::min(shortest, way.length());
    }
    EXPECT_NEAR(shortest, shortest_car_way(from, to, kCarRadius), 1e-6);
  }
}

/// A length that is 0 at the goal and never falls by more than what was driven is at most that of any way:
/// with the test before, it is the shortest.
TEST(CarWays, NoStepMakesTheRestShorterByMoreThanItsLength) {
  kinematics::Random random(5);
  for (int k = 0; k < 600; ++k) {
    const BasePlace from, to = random_place(random, k % 2 ? 8 : 2.5);
    const double whole = shortest_car_way(from, to, kCarRadius);
    for (const double side : {-1.0, 0.0, 0.4, 1.0})
      for (const double step : {-0.5, 0.5})
        EXPECT_LE(whole, std::abs(step) +
                             shortest_car_way(along(from, side / kCarRadius, step), to, kCarRadius) + 1e-9);
  }
}

}  // namespace
}  // namespace polyarm::surroundings
