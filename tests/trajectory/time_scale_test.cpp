#include "polyarm/trajectory/time_scale.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "polyarm/trajectory/joint_move.hpp"

namespace polyarm::trajectory::time_scale_test {
namespace {

constexpr double kPeriod = 1e-3;

TEST(TimeScale, GoesFromFullSpeedToAHoldInOneRampAndBack) {
  TimeScale scale(0.25);
  int steps = 0;
  while (scale.value() > 0 && steps < 1000) scale.advance(kPeriod, 0), ++steps;
  EXPECT_NEAR(steps * kPeriod, 0.25, 3 * kPeriod);
  EXPECT_EQ(scale.value(), 0);
  EXPECT_EQ(scale.advance(kPeriod, 0), 0);
  double passed = 0;
  for (int i = 0; i < 253; ++i) passed += scale.advance(kPeriod, 1);
  EXPECT_EQ(scale.value(), 1);
  EXPECT_NEAR(passed, 0.125 + 0.003, 0.003);
  EXPECT_EQ(scale.advance(kPeriod, 1), kPeriod);
}

TEST(TimeScale, KeepsRateAndChangeOfRateBoundedWhateverIsAsked) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const double ramp : {0.1, 0.25, 2.0}) {
    TimeScale scale(ramp);
    double target = 1, last_rate = 0, last = 1;
    for (int i = 0; i < 20000; ++i) {
      if (random() % 100 == 0) target = unit(random) < 0.3 ? std::round(unit(random)) : unit(random);
      const double passed = scale.advance(kPeriod, target);
      const double rate = (scale.value() - last) / kPeriod;
      EXPECT_LE(std::abs(rate), 1.5 / ramp * (1 + 1e-9));
      EXPECT_LE(std::abs(rate - last_rate), 2 * 4.5 / (ramp * ramp) * kPeriod * (1 + 1e-6));
      EXPECT_GE(scale.value(), 0);
      EXPECT_LE(scale.value(), 1);
      EXPECT_NEAR(passed, kPeriod * (last + scale.value()) / 2, 1e-15);
      last_rate = rate;
      last = scale.value();
    }
  }
}

TEST(TimeScale, ReachesATargetThatStandsStillWithoutPassingIt) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 200; ++i) {
    const double target = unit(random), dt = 1e-4 * std::pow(1000, unit(random));
    TimeScale scale(0.25, unit(random));
    const bool up = target > scale.value();
    for (double t = 0; t < 0.25 + 3 * dt; t += dt) {
      scale.advance(dt, target);
      EXPECT_LE(up ? scale.value() - target : target - scale.value(), 1e-12);
    }
    EXPECT_EQ(scale.value(), target);
  }
}

TEST(TimeScale, SurvivesTargetsAndTimesThatAreNone) {
  TimeScale scale(0.25);
  EXPECT_EQ(scale.advance(0, 0.5), 0);
  EXPECT_EQ(scale.advance(-1, 0.5), 0);
  EXPECT_EQ(scale.advance(NAN, 0.5), 0);
  for (int i = 0; i < 300; ++i) scale.advance(kPeriod, NAN);
  EXPECT_EQ(scale.value(), 0);
  for (int i = 0; i < 300; ++i) scale.advance(kPeriod, 7);
  EXPECT_EQ(scale.value(), 1);
  TimeScale abrupt(0);
  abrupt.advance(kPeriod, 0);
  EXPECT_EQ(abrupt.value(), 0);
}

/// Whenever the hold comes, with the rates that the limits leave, the joint's real acceleration stays by the
/// limit, and it stands as soon as that allows.
TEST(TimeScale, AHoldAtAnyMomentKeepsTheAccelerationByItsLimit) {
  const std::vector<JointMotionLimits> limits{{1, 4, 40}};
  const Trajectory move = plan_joint_move(std::vector{0.0}, std::vector{2.0}, limits);
  for (double hold_at = 0; hold_at < move.duration(); hold_at += 0.05) {
    TimeScale scale;
    double time = 0, stopped = 0;
    std::vector<double> v(1), a(1);
    std::size_t hint = 0;
    for (double clock = 0; clock < 3; clock += kPeriod) {
      ScaleRates rates = ScaleRates::of_ramp(0.05);
      move.sample(time, {}, v, a, hint);
      rates.narrow(v[0], a[0], scale.value(), {4, 4, 40});
      time += scale.advance(kPeriod, clock < hold_at ? 1 : 0, rates);
      move.sample(time, {}, v, a, hint);
      const double s = scale.value();
      EXPECT_LE(std::abs(a[0] * s * s + v[0] * scale.rate()), 4 * 1.02) << hold_at << " " << clock;
      if (v[0] * s > 0) stopped = clock;
    }
    EXPECT_LE(stopped - hold_at, 1.0 / 4 + 4.0 / 40 + 0.02) << hold_at;
  }
}

TEST(TimeScale, RatesLeaveWhatTheJointsAllow) {
  ScaleRates rates = ScaleRates::of_ramp(0.05);
  const ScaleRates wide = rates;
  rates.narrow(0, 3, 1, {4, 4, 40});
  EXPECT_EQ(rates.down, wide.down) << "what stands bounds nothing";
  rates.narrow(-2, 0, 1, {8, 4, 80});
  EXPECT_DOUBLE_EQ(rates.down, 2) << "its deceleration, not its acceleration";
  EXPECT_DOUBLE_EQ(rates.up, 4);
  EXPECT_DOUBLE_EQ(rates.change, 40);
  rates.narrow(2, -3, 1, {8, 4, 80});
  EXPECT_DOUBLE_EQ(rates.down, 0.5) << "the plan brakes already";
  rates.narrow(2, -5, 1, {8, 4, 80});
  EXPECT_DOUBLE_EQ(rates.down, 0) << "the plan brakes harder than it may: no rate is negative";
}

TEST(TimeScale, JumpsWhenNothingMoves) {
  TimeScale scale;
  scale.advance(kPeriod, 0);
  scale.jump(0);
  EXPECT_EQ(scale.value(), 0);
  EXPECT_EQ(scale.rate(), 0);
  scale.jump(NAN);
  EXPECT_EQ(scale.value(), 0);
}

}  // namespace
}  // namespace polyarm::trajectory::time_scale_test
