#include "polyarm/controllers/speed_limiter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

SpeedLimiter limiter(const SpeedLimits& limits) {
  SpeedLimiter out;
  out.set(limits);
  return out;
}

TEST(SpeedLimiter, TakesJerkFirstThenAccelerationThenVelocity) {
  SpeedLimits limits;
  limits.max_velocity = limits.max_acceleration = limits.max_jerk = 1;
  limits.min_velocity = limits.max_acceleration_reverse = -0.5;
  SpeedLimiter all = limiter(limits);
  EXPECT_DOUBLE_EQ(all.next(10, 0.5), 0.25);  // jerk 1: 1 * 0.5 * 0.5
  limits.max_jerk = SpeedLimits::kFree;
  SpeedLimiter no_jerk = limiter(limits);
  EXPECT_DOUBLE_EQ(no_jerk.next(10, 0.5), 0.5);
  limits.max_acceleration = SpeedLimits::kFree;
  SpeedLimiter velocity = limiter(limits);
  EXPECT_DOUBLE_EQ(velocity.next(10, 0.5), 1);
  EXPECT_DOUBLE_EQ(velocity.next(-10, 0.5), -0.5);
}

TEST(SpeedLimiter, LimitsJerkWhileGettingFasterOnly) {
  SpeedLimits limits;
  limits.max_jerk = 1;
  SpeedLimiter free = limiter(limits);
  free.reset(1);
  EXPECT_DOUBLE_EQ(free.next(2, 0.5), 1.25);
  EXPECT_DOUBLE_EQ(free.next(1.4, 0.5), 1.4);  // still faster, but less so: not limited
}

TEST(SpeedLimiter, IsFreeWithoutNumbers) {
  SpeedLimiter free = limiter({});
  EXPECT_EQ(free.next(1e9, 1e-3), 1e9);
  EXPECT_EQ(free.next(-3, 1e-3), -3);
}

TEST(SpeedLimiter, TakesAnUnstatedMinimumAsTheNegativeOfTheMaximum) {
  SpeedLimits limits;
  limits.max_velocity = 2;
  limits.max_acceleration = 3;
  SpeedLimiter both = limiter(limits);
  EXPECT_DOUBLE_EQ(both.next(-9, 0.5), -1.5);
  EXPECT_DOUBLE_EQ(both.next(-9, 0.5), -2);
  EXPECT_DOUBLE_EQ(both.next(0, 0.1), -1.7);  // slows down as hard as it gets faster
}

TEST(SpeedLimiter, HasItsOwnLimitForEachOfTheFourWays) {
  SpeedLimits limits;
  limits.max_acceleration = 2;
  limits.max_deceleration = -4;
  limits.max_acceleration_reverse = -8;
  limits.max_deceleration_reverse = 10;
  SpeedLimiter four = limiter(limits);
  EXPECT_DOUBLE_EQ(four.next(1, 0.01), 0.02);
  four.reset(1);
  EXPECT_DOUBLE_EQ(four.next(0, 0.01), 0.96);
  four.reset(0);
  EXPECT_DOUBLE_EQ(four.next(-1, 0.01), -0.08);
  four.reset(-1);
  EXPECT_DOUBLE_EQ(four.next(0, 0.01), -0.9);
}

TEST(SpeedLimiter, ForgetsWhatIsNotANumber) {
  SpeedLimiter any = limiter({});
  any.next(0.3, 0.01);
  EXPECT_EQ(any.next(std::nan(""), 0.01), 0.3);
  EXPECT_EQ(any.next(1, 0), 0.3);
  EXPECT_EQ(any.next(0.4, 0.01), 0.4);
}

TEST(SpeedLimiter, NeverLeavesItsLimitsAndComesToRestExactly) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> wish(-3, 3), bound(0.1, 5);
  for (int round = 0; round < 200; ++round) {
    SpeedLimits limits;
    limits.max_velocity = bound(random);
    limits.min_velocity = -bound(random);
    limits.max_acceleration = bound(random);
    limits.max_deceleration = -bound(random);
    limits.max_jerk = round % 2 ? bound(random) : SpeedLimits::kFree;
    SpeedLimiter speed = limiter(limits);
    const double dt = 0.01, most = 5 * dt * (1 + 1e-12);
    for (int k = 0; k < 300; ++k) {
      const double before = speed.speed(), after = speed.next(wish(random), dt);
      ASSERT_LE(after, limits.max_velocity);
      ASSERT_GE(after, limits.min_velocity);
      ASSERT_LE(std::abs(after - before), most);
    }
    for (int k = 0; k < 10000 && speed.speed() != 0; ++k) speed.next(0, dt);
    EXPECT_EQ(speed.speed(), 0) << round;
  }
}

TEST(SpeedLimiter, RefusesLimitsOfTheWrongSign) {
  SpeedLimits limits;
  EXPECT_FALSE(check(limits));
  limits.max_deceleration = 0;
  ASSERT_TRUE(check(limits));
  EXPECT_NE(check(limits)->find("max_deceleration"), std::string::npos);
  limits = {};
  limits.max_velocity = -1;
  EXPECT_TRUE(check(limits));
  limits = {};
  limits.min_jerk = 1;
  EXPECT_TRUE(check(limits));
}

TEST(SpeedLimiter, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  SpeedLimiter speed = limiter({.max_velocity = 1, .max_acceleration = 1, .max_jerk = 1});
  test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) speed.next(k % 3, 0.01);
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::controllers
