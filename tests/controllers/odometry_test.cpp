#include "polyarm/wheels/odometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

Odometry unit() {
  Odometry out;
  out.configure(1, 1, 1, 10);
  return out;
}

TEST(Odometry, GoesStraightWhenBothWheelsTurnAlike) {
  Odometry odometry = unit();
  EXPECT_TRUE(odometry.update_from_positions(1, 1, 1));
  EXPECT_DOUBLE_EQ(odometry.x(), 1);
  EXPECT_DOUBLE_EQ(odometry.y(), 0);
  EXPECT_DOUBLE_EQ(odometry.heading(), 0);
  EXPECT_DOUBLE_EQ(odometry.linear(), 1);
}

TEST(Odometry, TurnsOnTheSpotWhenTheyTurnAgainstEachOther) {
  Odometry odometry = unit();
  EXPECT_TRUE(odometry.update_from_velocities(-1, 1, 1));
  EXPECT_DOUBLE_EQ(odometry.heading(), 2);
  EXPECT_NEAR(odometry.x(), 0, 1e-15);
  EXPECT_NEAR(odometry.y(), 0, 1e-15);
  EXPECT_DOUBLE_EQ(odometry.angular(), 2);
}

TEST(Odometry, FollowsAnArcExactly) {
  for (const bool positions : {true, false}) {
    Odometry odometry = unit();
    EXPECT_TRUE(positions ? odometry.update_from_positions(1, 2, 1)
                          : odometry.update_from_velocities(1, 2, 1));
    EXPECT_NEAR(odometry.x(), 1.5 * std::sin(1), 1e-14);
    EXPECT_NEAR(odometry.y(), -1.5 * (std::cos(1) - 1), 1e-14);
    EXPECT_DOUBLE_EQ(odometry.heading(), 1);
  }
}

TEST(Odometry, RefusesLessThanAMicrosecondAndWhatIsNotFinite) {
  Odometry odometry = unit();
  EXPECT_FALSE(odometry.update_from_positions(1, 1, 0.9e-6));
  EXPECT_FALSE(odometry.update_from_velocities(1, 1, 0));
  EXPECT_FALSE(odometry.update_open_loop(1, 1, -1));
  EXPECT_FALSE(odometry.update_from_velocities(std::nan(""), 1, 1));
  EXPECT_FALSE(odometry.update_from_positions(std::numeric_limits<double>::infinity(), 1, 1));
  EXPECT_FALSE(odometry.update_open_loop(1, 1, std::nan("")));
  EXPECT_EQ(odometry.x(), 0);
  EXPECT_EQ(odometry.heading(), 0);
  EXPECT_TRUE(odometry.update_from_positions(1, 1, 1));  // nothing of that is left
  EXPECT_DOUBLE_EQ(odometry.x(), 1);
  EXPECT_DOUBLE_EQ(odometry.linear(), 1);
}

TEST(Odometry, CountsFromWhereTheWheelsStandAtTheStart) {
  Odometry odometry = unit();
  odometry.start(100, 50);
  odometry.update_from_positions(101, 51, 1);
  EXPECT_DOUBLE_EQ(odometry.x(), 1);
}

TEST(Odometry, TellsTheMeanOverItsWindow) {
  Odometry odometry;
  odometry.configure(1, 1, 1, 3);
  for (const double v : {1.0, 2.0, 3.0, 4.0}) odometry.update_from_velocities(v, v, 0.1);
  EXPECT_DOUBLE_EQ(odometry.linear(), 3);
  odometry.set_pose(5, 6, 7);
  EXPECT_EQ(odometry.x(), 5);
  EXPECT_EQ(odometry.heading(), 7);
  odometry.update_from_velocities(8, 8, 0.1);
  EXPECT_DOUBLE_EQ(odometry.linear(), 8);
}

TEST(Odometry, IsTheSameInOneStepOrInMany) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> speed(-2, 2);
  for (int round = 0; round < 100; ++round) {
    const double left = speed(random), right = speed(random);
    Odometry once = unit(), often = unit();
    once.update_from_velocities(left, right, 2);
    for (int k = 0; k < 1000; ++k) often.update_from_velocities(left, right, 0.002);
    EXPECT_NEAR(once.x(), often.x(), 1e-11);
    EXPECT_NEAR(once.y(), often.y(), 1e-11);
    EXPECT_NEAR(once.heading(), often.heading(), 1e-11);
  }
}

TEST(RollingMean, DoesNotDriftOverMillionsOfValues) {
  RollingMean mean(7);
  for (int k = 0; k < 1000000; ++k) mean.add(k % 2 ? 1e9 : 0.1);
  for (int k = 0; k < 7; ++k) mean.add(0.5);
  EXPECT_NEAR(mean.mean(), 0.5, 1e-6);
  for (int k = 0; k < 7; ++k) mean.add(0.5);
  EXPECT_DOUBLE_EQ(mean.mean(), 0.5);
}

TEST(Odometry, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Odometry odometry = unit();
  test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) odometry.update_from_positions(k * 0.1, k * 0.11, 0.01);
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::controllers
