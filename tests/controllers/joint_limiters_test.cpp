#include "polyarm/joint_control/joint_limiters.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace polyarm::controllers {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

LimiterSettings limits(double range, double velocity = kUnlimited) {
  LimiterSettings s;
  s.lower = -range;
  s.upper = range;
  s.velocity = velocity;
  return s;
}

/// Positions commanded one after the other; the joint itself does not move.
struct Positions {
  LimiterSettings s;
  double last = 0, before = 0, dt = 1;
  double ask(double asked) {
    const double given = allow_position(s, {last, 0}, asked, last, (last - before) / dt, dt).value;
    before = last;
    return last = given;
  }
};

TEST(SaturationLimits, APositionIsReachedAtTheSpeedOfTheLastCommands) {
  Positions joint{limits(kPi, 1)};
  EXPECT_NEAR(joint.ask(2), 1.0, 1e-12);
  EXPECT_NEAR(joint.ask(-3), 0.0, 1e-12);
  joint.last = 3;
  EXPECT_NEAR(joint.ask(9), kPi, 1e-12);
}

TEST(SaturationLimits, AVelocityEndsAtTheLimitOfThePosition) {
  const LimiterSettings s = limits(5, 1);
  EXPECT_NEAR(allow_velocity(s, {0, 0}, 5, 0, 1).value, 1, 1e-12);
  EXPECT_NEAR(allow_velocity(s, {4.8, 0}, 5, 0, 1).value, 0.2, 1e-12);
  EXPECT_NEAR(allow_velocity(s, {5.0, 0}, 5, 0, 1).value, 0, 1e-12);
  EXPECT_NEAR(allow_velocity(s, {5.001, 0}, 5, 0, 1).value, 0, 1e-12);
  EXPECT_NEAR(allow_velocity(s, {5.001, 0}, -5, 0, 1).value, -1, 1e-12) << "inwards it may move";
  EXPECT_NEAR(allow_velocity(s, {5.003, 0}, -5, 0, 1).value, 0, 1e-12) << "too far out it stands";
  EXPECT_EQ(allow_velocity(s, {5.003, 0}, -5, 0, 1).cause, Limit::out_of_range);
}

TEST(SaturationLimits, AVelocityChangesNoFasterThanTheAcceleration) {
  LimiterSettings s = limits(100, 1);
  s.acceleration = 0.5;
  double last = 0;
  for (const auto& [asked, given] : {std::pair{1.0, 0.5}, {1.0, 1.0}, {0.0, 0.5}, {0.0, 0.0}, {-0.2, -0.2}})
    EXPECT_NEAR(last = allow_velocity(s, {0, last}, asked, last, 1).value, given, 1e-12);
}

TEST(SaturationLimits, SlowingDownHasALimitOfItsOwn) {
  LimiterSettings s;
  s.acceleration = 0.5;
  s.deceleration = 2;
  EXPECT_NEAR(allow_acceleration(s, {0, 1}, 9, 0, 1).value, 0.5, 1e-12);
  EXPECT_NEAR(allow_acceleration(s, {0, 1}, -9, 0, 1).value, -2, 1e-12);
  EXPECT_NEAR(allow_acceleration(s, {0, -1}, -9, 0, 1).value, -0.5, 1e-12);
  EXPECT_EQ(allow_acceleration(s, {0, 1}, -9, 0, 1).cause, Limit::deceleration);
}

TEST(SaturationLimits, AnEffortPushesNoFurtherOut) {
  LimiterSettings s = limits(5, 1);
  s.effort = 200;
  EXPECT_EQ(allow_effort(s, {4, 0}, 400).value, 200);
  EXPECT_EQ(allow_effort(s, {4, 0}, -400).value, -200);
  EXPECT_EQ(allow_effort(s, {5, 0}, 20).value, 0);
  EXPECT_EQ(allow_effort(s, {5, 0}, -20).value, -20);
  EXPECT_EQ(allow_effort(s, {-5, -0.1}, -20).value, 0);
  EXPECT_EQ(allow_effort(s, {5, -0.1}, 20).value, 20) << "it comes back already";
  EXPECT_EQ(allow_effort(s, {0, 1.5}, 20).value, 0) << "too fast already";
  EXPECT_EQ(allow_effort(s, {0, 1.5}, -20).value, -20);
}

TEST(SaturationLimits, WhatIsNotLimitedIsNotTouched) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1e6, 1e6);
  const LimiterSettings none;
  for (int k = 0; k < 1000; ++k) {
    const double asked = any(random), last = any(random);
    EXPECT_EQ(allow_position(none, {last, 0}, asked, last, 0, 1e-3).value, asked);
    EXPECT_EQ(allow_velocity(none, {last, 0}, asked, last, 1e-3).value, asked);
    EXPECT_EQ(allow_acceleration(none, {last, 0}, asked, last, 1e-3).value, asked);
    EXPECT_EQ(allow_effort(none, {last, 0}, asked).value, asked);
  }
}

TEST(SaturationLimits, WhatIsNoNumberHoldsAndIsForgotten) {
  Positions joint{limits(5, 1)};
  joint.ask(0.5);
  EXPECT_EQ(joint.ask(kNone), 0.5);
  EXPECT_NEAR(joint.ask(0.7), 0.7, 1e-12);
  EXPECT_EQ(allow_velocity(limits(5), {0, 0}, kNone, 0.3, 1).value, 0);
  EXPECT_EQ(allow_effort(limits(5), {0, 0}, kUnlimited).value, 0);
}

TEST(SaturationLimits, AJointOutsideMayStayAndComeBack) {
  Positions joint{limits(1, 0.5)};
  joint.last = joint.before = 3;
  EXPECT_EQ(joint.ask(3), 3);
  EXPECT_EQ(joint.ask(4), 3);
  EXPECT_NEAR(joint.ask(0), 2.5, 1e-12);
}

TEST(SaturationLimits, ATrajectoryWithinThemIsUntouchedBitForBit) {
  LimiterSettings s = limits(2, 1);
  double last = 0;
  for (int k = 0; k < 5000; ++k) {
    const double asked = 0.9 * std::sin(0.001 * k);
    const Allowed given = allow_position(s, {last, 0}, asked, last, 0, 1e-3);
    ASSERT_EQ(given.value, asked);
    ASSERT_EQ(given.cause, Limit::none);
    last = asked;
  }
}

TEST(SaturationLimits, NoCommandWhateverItIsLeavesThem) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-10, 10);
  LimiterSettings s = limits(3, 2);
  s.acceleration = 30;
  Positions joint{s};
  joint.dt = 0.01;
  for (int k = 0; k < 20'000; ++k) {
    const double before = joint.last;
    joint.ask(any(random));
    ASSERT_LE(std::abs(joint.last), 3 + 1e-12);
    ASSERT_LE(std::abs(joint.last - before), 0.02 + 1e-12);
  }
}

TEST(SaturationLimits, AJointThatIsDrivenAtALimitStopsInTimeForIt) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> value(0.5, 40);
  for (int round = 0; round < 200; ++round) {
    LimiterSettings s = limits(3, 2);
    s.acceleration = value(random);
    s.deceleration = value(random);
    Positions joint{s};
    joint.dt = 0.01;
    double speed = 0;
    for (int k = 0; k < 2000; ++k) {
      const double before = joint.last;
      joint.ask(k < 1000 ? 10 : -10);
      ASSERT_LE(std::abs(joint.last), 3);
      const double faster = (joint.last - before) / joint.dt;
      const bool slows = std::abs(faster) < std::abs(speed);
      const double most = slows ? s.deceleration : std::max(s.acceleration, s.deceleration);
      ASSERT_LE(std::abs(faster - speed), most * joint.dt + 1e-9) << round << " at step " << k;
      speed = faster;
    }
    EXPECT_NEAR(joint.last, -3, 1e-9) << "and it gets there";
  }
}

TEST(SaturationLimits, ABrakingThatEndsAtALimitIsUntouched) {
  LimiterSettings s = limits(1, 2);
  s.acceleration = 4 * (1 + 1e-9);
  s.deceleration = 2 * (1 + 1e-9);
  const double dt = 1e-3;
  double last = 0, before = 0;
  for (int k = 1; k <= 1000; ++k) {  // to 1 with an acceleration of 0, then -2: rest after 1 s
    const double t = k * dt, asked = 2 * t - t * t;
    const double speed = k == 1 ? 2 : (last - before) / dt;
    ASSERT_EQ(allow_position(s, {last, 0}, asked, last, speed, dt).value, asked) << k;
    before = last;
    last = asked;
  }
}

TEST(SaturationLimits, ThroughRestAJointIsNoFasterThanItsAcceleration) {
  LimiterSettings s;
  s.acceleration = 1;
  s.deceleration = 10;
  const Allowed given = allow_velocity(s, {0, 0.5}, -9, 0.5, 0.1);  // at rest after 0.05 s
  EXPECT_NEAR(given.value, -0.05, 1e-12);
  EXPECT_EQ(given.cause, Limit::deceleration);
  EXPECT_NEAR(allow_velocity(s, {0, 0}, -9, 0, 0.1).value, -0.1, 1e-12);
  EXPECT_EQ(allow_velocity(s, {0, 0}, -9, 0, 0.1).cause, Limit::acceleration);
  EXPECT_NEAR(allow_velocity(s, {0, -2}, 9, -2, 0.1).value, -1, 1e-12);
}

TEST(SaturationLimits, FarOutsideIsAFault) {
  const LimiterSettings s = limits(5, 1);
  EXPECT_FALSE(allow_position(s, {5.008, 0}, 0, 5.008, 0, 1).fault);
  EXPECT_TRUE(allow_position(s, {5.009, 0}, 0, 5.009, 0, 1).fault);
  EXPECT_TRUE(allow_position(s, {-5.009, 0}, 0, -5.009, 0, 1).fault);
  EXPECT_LT(allow_position(s, {5.009, 0}, 9, 5.009, 0, 1).value, 5.01) << "no further out";
  EXPECT_TRUE(allow_velocity(s, {5.009, 0}, -1, 0, 1).fault);
  EXPECT_EQ(allow_velocity(s, {5.009, 0}, -1, 0, 1).value, 0);
  EXPECT_FALSE(allow_position(s, {kNone, 0}, 0, 0, 0, 1).fault);
  EXPECT_FALSE(allow_position({}, {1e300, 0}, 0, 0, 0, 1).fault);
}

TEST(SaturationLimits, WithoutTimeNothingIsTouched) {
  LimiterSettings s = limits(5, 1);
  s.acceleration = s.jerk = 1;
  for (const double dt : {0.0, -1.0, kNone}) {
    EXPECT_EQ(allow_position(s, {0, 0}, 77, 0, 0, dt).value, 77);
    EXPECT_EQ(allow_position(s, {0, 0}, 77, 0, 0, dt).cause, Limit::none);
    EXPECT_EQ(allow_velocity(s, {5, 0}, 77, 0, dt).value, 77);
    EXPECT_EQ(allow_acceleration(s, {0, 0}, 0.7, 0, dt).value, 0.7);
  }
}

TEST(SaturationLimits, NoLimitsAndMeasurementsWhateverTheyAreGiveWhatIsNoNumber) {
  std::mt19937 random(8);
  const double values[] = {0, -0.0, 1, -1, 1e-300, 1e308, -1e308, kUnlimited, -kUnlimited, kNone};
  std::uniform_int_distribution<std::size_t> any(0, std::size(values) - 1), limit(0, 7);
  const auto value = [&] { return values[any(random)]; };
  for (int k = 0; k < 300'000; ++k) {
    LimiterSettings s;
    s.lower = -std::abs(values[limit(random)]), s.upper = std::abs(values[limit(random)]);
    for (double* field : {&s.velocity, &s.acceleration, &s.deceleration, &s.jerk, &s.effort})
      *field = std::abs(values[limit(random)]);
    s.soft = k % 2;
    s.soft_limits = {-std::abs(values[limit(random)]), std::abs(values[limit(random)]),
                     std::abs(values[limit(random)]), std::abs(values[limit(random)])};
    const JointNow now{value(), value()};
    const double asked = value(), last = values[limit(random)], speed = value();
    const double dt = std::abs(values[limit(random)]);
    ASSERT_FALSE(std::isnan(allow_position(s, now, asked, last, speed, dt).value)) << k;
    ASSERT_FALSE(std::isnan(allow_velocity(s, now, asked, speed, dt).value)) << k;
    ASSERT_FALSE(std::isnan(allow_acceleration(s, now, asked, speed, dt).value)) << k;
    ASSERT_FALSE(std::isnan(allow_effort(s, now, asked).value)) << k;
  }
}

// --- soft limits ------------------------------------------------------------------------------------------

LimiterSettings soft(double lower, double upper, double k) {
  LimiterSettings s = limits(5, 1);
  s.soft = true;
  s.soft_limits = {lower, upper, k, 0};
  return s;
}

TEST(SoftLimits, SlowDownOnTheWayToTheEdge) {
  const LimiterSettings s = soft(-2, 4, 1);
  EXPECT_NEAR(allow_velocity(s, {0, 0}, 5, 0, 1).value, 1, 1e-12);
  EXPECT_NEAR(allow_velocity(s, {3.8, 0}, 5, 0, 1).value, 0.2, 1e-12);
  EXPECT_NEAR(allow_velocity(s, {4.0, 0}, 5, 0, 1).value, 0, 1e-12);
  EXPECT_EQ(allow_velocity(s, {3.8, 0}, 5, 0, 1).cause, Limit::soft_position);
  EXPECT_NEAR(allow_velocity(s, {3.8, 0}, -5, 0, 1).value, -1, 1e-12);
}

TEST(SoftLimits, BeyondThemAJointComesBackWhateverIsAsked) {
  const LimiterSettings s = soft(-2, 4, 1);
  for (const double asked : {5.0, 0.0, -5.0})
    EXPECT_NEAR(allow_velocity(s, {4.8, 0}, asked, 0, 1).value, -kPi / 180, 1e-12) << asked;
  for (const double asked : {5.0, 0.0, -5.0})
    EXPECT_NEAR(allow_velocity(s, {-2.5, 0}, asked, 0, 1).value, kPi / 180, 1e-12) << asked;
}

TEST(SoftLimits, APositionConvergesGeometricallyToTheEdge) {
  Positions joint{soft(-1.5, 1.5, 0.5)};
  joint.s.velocity = 10;
  double left = 1.5;
  for (int k = 0; k < 20; ++k) {
    joint.ask(3);
    left /= 2;
    EXPECT_NEAR(joint.last, 1.5 - left, 1e-12);
  }
}

TEST(SoftLimits, WhereNothingReachableIsSoftTheNearestOfItIsTaken) {
  Positions joint{soft(2, 4, 1)};
  joint.last = joint.before = 0;
  const double given = joint.ask(-3);
  EXPECT_GE(given, 0);
  EXPECT_LE(given, 1) << "no faster than its velocity";
}

TEST(SoftLimits, WithoutAGainTheyAreEdgesAndFreezeNothing) {
  const LimiterSettings s = soft(-2, 4, 0);
  EXPECT_EQ(allow_velocity(s, {0, 0}, 0.7, 0, 0.01).value, 0.7);
  EXPECT_NEAR(allow_velocity(s, {3.999, 0}, 0.7, 0, 0.01).value, 0.1, 1e-9);
  EXPECT_EQ(allow_velocity(s, {4.0, 0}, 0.7, 0, 0.01).value, 0);
  EXPECT_NEAR(allow_velocity(s, {4.8, 0}, 0.7, 0, 0.01).value, -kPi / 180, 1e-12);
  Positions joint{s};
  joint.last = joint.before = 3;
  EXPECT_EQ(joint.ask(3.5), 3.5);
  EXPECT_EQ(joint.ask(9), 4);
  EXPECT_EQ(joint.ask(3.2), 3.2);
}

TEST(SoftLimits, AnEffortBrakesWhatIsFasterThanTheEdgeAllows) {
  LimiterSettings s = soft(-2, 4, 1);
  s.effort = 200;
  s.soft_limits.k_velocity = 100;
  EXPECT_NEAR(allow_effort(s, {3.8, 0.5}, 50).value, -30, 1e-9) << "0.3 too fast, times k_velocity";
  EXPECT_NEAR(allow_effort(s, {0, 0}, 50).value, 50, 1e-9);
}

TEST(TrajectoryPoints, KeepTheAccelerationOnTheWay) {
  LimiterSettings s = limits(5, 2);
  s.acceleration = 5;
  s.deceleration = 7.5;
  const LimitedPoint faster = limit_point(s, .1, .1, .5, .05);
  EXPECT_NEAR(faster.position, .11125, 1e-12);
  EXPECT_NEAR(faster.velocity, .35, 1e-12);
  EXPECT_NEAR(faster.acceleration, 5, 1e-12);
  const LimitedPoint slower = limit_point(s, .3, .5, .1, .05);
  EXPECT_NEAR(slower.position, .315625, 1e-12);
  EXPECT_NEAR(slower.velocity, .125, 1e-12);
  EXPECT_NEAR(slower.acceleration, -7.5, 1e-12);
}

LimiterSettings of_points() {
  LimiterSettings s = limits(5, 2);
  s.acceleration = 5;
  s.deceleration = 7.5;
  return s;
}

TEST(TrajectoryPoints, TellWhichLimitTookHold) {
  const LimiterSettings s = of_points();
  const LimitedPoint faster = limit_point(s, .1, .1, RequestedPoint{.125, .5}, .05);
  EXPECT_NEAR(faster.position, .11125, 1e-12);
  EXPECT_NEAR(faster.velocity, .35, 1e-12);
  EXPECT_NEAR(faster.acceleration, 5, 1e-12);
  EXPECT_EQ(faster.cause, Limit::acceleration);
  EXPECT_EQ(limit_point(s, .3, .5, .1, .05).cause, Limit::deceleration);
  EXPECT_EQ(limit_point(s, 0, 1.95, 3, .05).cause, Limit::velocity);
  EXPECT_NEAR(limit_point(s, 0, 1.95, 3, .05).velocity, 2, 1e-12);
  EXPECT_EQ(limit_point(s, 0, 0, kNone, .05).cause, Limit::not_a_number);
  EXPECT_EQ(limit_point(s, 0, 0, RequestedPoint{0.004, .16}, .05).cause, Limit::none);
  EXPECT_EQ(limit_point(s, 0, 0, RequestedPoint{0.004, .16}, .05).position, 0.004);
}

TEST(TrajectoryPoints, TakeTheVelocityThatLeadsToThePosition) {
  const LimitedPoint point = limit_point(of_points(), 1, 1, RequestedPoint{1.055, kNone}, .05);
  EXPECT_NEAR(point.velocity, 1.1, 1e-12);
  EXPECT_EQ(point.position, 1.055);
  LimiterSettings fast = of_points();
  fast.acceleration = fast.deceleration = kUnlimited;
  const LimitedPoint jump = limit_point(fast, 0, 0, RequestedPoint{3, .1}, .05);
  EXPECT_NEAR(jump.position, 0.1, 1e-12) << "a velocity that belies its position makes no jump";
  EXPECT_EQ(jump.cause, Limit::velocity);
}

TEST(TrajectoryPoints, StopBeforeTheLimitsWhateverIsAsked) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-20, 20);
  const LimiterSettings s = of_points();
  for (int round = 0; round < 50; ++round) {
    LimitedPoint now{0, 0, 0};
    const RequestedPoint always{any(random), any(random)};
    for (int k = 0; k < 500; ++k) {
      const RequestedPoint asked = round % 2 ? always : RequestedPoint{any(random), any(random)};
      const LimitedPoint next = limit_point(s, now.position, now.velocity, asked, .05);
      ASSERT_LE(std::abs(next.position), 5 + 1e-12);
      ASSERT_LE(std::abs(next.velocity), 2 + 1e-12);
      ASSERT_LE(std::abs(next.velocity - now.velocity), 7.5 * .05 + 1e-9);
      const double to_rest = next.velocity * std::abs(next.velocity) / (2 * 7.5);
      ASSERT_LE(std::abs(next.position + to_rest), 5 + 1e-9) << "too fast to stop in time";
      now = next;
    }
  }
}

TEST(TrajectoryPoints, WithoutTimeStayWhereTheyAre) {
  const LimitedPoint point = limit_point(of_points(), 1, 2, RequestedPoint{4, 4}, 0);
  EXPECT_EQ(point.position, 1);
  EXPECT_EQ(point.velocity, 2);
}

}  // namespace
}  // namespace polyarm::controllers
