#include "drivers/pca9685/motor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace polyarm::drivers {
namespace {

TEST(Motor, HalfSpeedIsHalfTheTicks) {
  const MotorOutput out = drive_at({}, 0.5);
  EXPECT_EQ(out.drive, (MotorDrive{2048, 4096, 0}));
  EXPECT_DOUBLE_EQ(out.velocity, 0.5);
  EXPECT_EQ(drive_at({}, -0.5).drive, (MotorDrive{2048, 0, 4096}));
}

TEST(Motor, DutiesAreRoundedToTheNextTick) {
  EXPECT_EQ(drive_at({}, 100.4 / 4096).drive.enable, 100);
  EXPECT_EQ(drive_at({}, 100.6 / 4096).drive.enable, 101);
  EXPECT_EQ(drive_at({}, 1).drive.enable, 4096) << "on all the time";
}

TEST(Motor, ScaleAndTrimMultiply) {
  MotorSettings m;
  m.speed_scale = 0.05;  // 20 rad/s at full duty
  EXPECT_EQ(drive_at(m, 10).drive.enable, 2048);
  m.trim = 0.9;
  EXPECT_EQ(drive_at(m, 10).drive.enable, 1843);
  EXPECT_NEAR(drive_at(m, 10).velocity, 10, 1e-12)
      << "trim makes motors alike, the wheel's speed is the same";
}

TEST(Motor, DirectionTurnsItRound) {
  MotorSettings m;
  m.direction = -1;
  EXPECT_EQ(drive_at(m, 0.5).drive, (MotorDrive{2048, 0, 4096}));
  EXPECT_DOUBLE_EQ(drive_at(m, 0.5).velocity, 0.5);
}

TEST(Motor, StandsInItsDeadBand) {
  MotorSettings m;
  m.dead_band = 0.05;
  EXPECT_EQ(drive_at(m, 0.049).drive, MotorDrive{});
  EXPECT_EQ(drive_at(m, -0.049).velocity, 0);
  EXPECT_NE(drive_at(m, 0.051).drive, MotorDrive{});
}

TEST(Motor, StopsByRollingOutOrByBraking) {
  MotorSettings m;
  EXPECT_EQ(drive_at(m, 0).drive, (MotorDrive{0, 0, 0}));
  m.brake = true;
  EXPECT_EQ(drive_at(m, 0).drive, (MotorDrive{4096, 4096, 4096}));
  EXPECT_EQ(release_now().drive, (MotorDrive{0, 0, 0})) << "without a command it rolls, whatever a stop is";
}

TEST(Motor, BeginsAtTheDutyThatTurnsIt) {
  MotorSettings m;
  m.least_duty = 0.25;
  EXPECT_EQ(drive_at(m, 0.5).drive.enable, static_cast<int>(4096 * (0.25 + 0.75 * 0.5)));
  EXPECT_GE(drive_at(m, 0.002).drive.enable, 1024);
}

TEST(Motor, NeverExceedsItsClamp) {
  MotorSettings m;
  m.most_duty = 0.3;
  EXPECT_EQ(drive_at(m, 5).drive.enable, 1228) << "rounded down";
  EXPECT_NEAR(drive_at(m, 5).velocity, 0.3, 1e-9);
  m.most_duty = 0;
  EXPECT_EQ(drive_at(m, 5).drive, MotorDrive{});
  EXPECT_EQ(drive_at(m, 5).velocity, 0);
}

TEST(Motor, LawsHoldForAnySettings) {
  std::mt19937 random(685);
  std::uniform_real_distribution<double> one(0, 1), any(-50, 50);
  for (int k = 0; k < 20'000; ++k) {
    MotorSettings m;
    m.speed_scale = 1e-3 + 3 * one(random);
    m.trim = 0.1 + 2 * one(random);
    m.dead_band = one(random);
    m.least_duty = 0.9 * one(random);
    m.most_duty = m.least_duty + (1 - m.least_duty) * one(random);
    m.direction = one(random) < 0.5 ? -1 : 1;
    m.brake = one(random) < 0.5;
    const double v = any(random);
    const MotorOutput out = drive_at(m, v);
    const bool stands = out.drive == MotorDrive{} || out.drive == MotorDrive{4096, 4096, 4096};
    ASSERT_GE(out.drive.enable, 0);
    ASSERT_LE(stands ? 0 : out.drive.enable, m.most_duty * 4096) << v;
    ASSERT_LE(std::abs(out.velocity), std::abs(v) + 1e-9) << "never faster than asked";
    ASSERT_EQ(out.velocity == 0, stands);
    if (stands) continue;
    ASSERT_GT(out.velocity * v, 0) << "never the other way";
    ASSERT_EQ(out.drive.positive == 4096, v * m.direction > 0);
    ASSERT_EQ(out.drive.positive + out.drive.negative, 4096);
  }
}

}  // namespace
}  // namespace polyarm::drivers
