#include "polyarm/controllers/pid.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace polyarm::controllers {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> outputs(Pid& pid, const std::vector<double>& errors, double dt = 1) {
  std::vector<double> out;
  for (const double error : errors) out.push_back(pid.compute(error, dt));
  return out;
}

void expect_near(const std::vector<double>& got, const std::vector<double>& wanted) {
  ASSERT_EQ(got.size(), wanted.size());
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], wanted[i], 1e-12) << "at step " << i;
}

TEST(Pid, TheIntegralTakesTheErrorAfterTheOutput) {
  Pid pid({.i = 1});
  expect_near(outputs(pid, {-.5, -.5, 0, 0, 1, 0}), {0, -.5, -1, -1, -1, 0});
}

TEST(Pid, TheDerivativeIsTheDifferenceOfErrors) {
  Pid pid({.d = 1});
  EXPECT_NEAR(pid.compute(-.5, 1), -.5, 1e-12);
  EXPECT_NEAR(pid.compute(-.5, 1), 0, 1e-12);
  EXPECT_NEAR(pid.compute(-.5, .1), 0, 1e-12);
  EXPECT_NEAR(pid.compute(-1, 1), -.5, 1e-12);
  EXPECT_NEAR(pid.compute(-.5, 1), .5, 1e-12);
}

TEST(Pid, AllThreeAddUp) {
  Pid pid({.p = 1, .i = 1, .d = 1});
  expect_near(outputs(pid, {-.5, -.5, 0}), {-1, -1, -.5});
}

TEST(Pid, BackCalculationTakesTheExcessBack) {
  Pid pid({.i = 1,
           .u_min = -5,
           .u_max = 5,
           .antiwindup = AntiWindup::back_calculation,
           .tracking_time_constant = 1});
  const std::vector<double> errors{1, 2, 3, 1, 2, -1, 1}, commands{0, 1, 3, 5, 5, 5, 4},
      integrals{1, 3, 6, 6, 7, 4, 5};
  for (std::size_t k = 0; k < errors.size(); ++k) {
    EXPECT_NEAR(pid.compute(errors[k], 1), commands[k], 1e-12) << k;
    EXPECT_NEAR(pid.integral(), integrals[k], 1e-12) << k;
  }
}

TEST(Pid, ConditionalIntegrationPausesBeyondTheLimit) {
  Pid pid({.i = 1, .u_min = -5, .u_max = 5, .antiwindup = AntiWindup::conditional_integration});
  const std::vector<double> errors{1, 2, 3, 1, 2, -1, 0}, commands{0, 1, 3, 5, 5, 5, 5},
      integrals{1, 3, 6, 6, 6, 5, 5};
  for (std::size_t k = 0; k < errors.size(); ++k) {
    EXPECT_NEAR(pid.compute(errors[k], 1), commands[k], 1e-12) << k;
    EXPECT_NEAR(pid.integral(), integrals[k], 1e-12) << k;
  }
}

TEST(Pid, WithoutATimeTheTrackingTimeComesFromTheGains) {
  PidGains gains{.p = 2, .i = 0.5, .u_min = -1, .u_max = 1, .antiwindup = AntiWindup::back_calculation};
  Pid without_d(gains);  // p / i = 4 s
  without_d.compute(10, 1);
  EXPECT_NEAR(without_d.integral(), 0.5 * 10 - (20 - 1) / 4.0, 1e-12);
  gains.d = 8;  // sqrt(d / i) = 4 s
  Pid with_d(gains);
  with_d.compute(10, 0, 1);
  EXPECT_NEAR(with_d.integral(), 0.5 * 10 - (20 - 1) / 4.0, 1e-12);
}

TEST(Pid, StopsIntegratingInsideTheDeadband) {
  Pid pid({.i = 1, .error_deadband = 0.1});
  outputs(pid, {0.05, -0.1, 0.1});
  EXPECT_EQ(pid.integral(), 0);
  outputs(pid, {0.2});
  EXPECT_NEAR(pid.integral(), 0.2, 1e-12);
}

TEST(Pid, NoTimeGivesTheLastOutputAgain) {
  Pid pid({.p = 2, .i = 1});
  const double before = pid.compute(1, 1);
  EXPECT_EQ(pid.compute(55, 0), before);
  EXPECT_NEAR(pid.compute(1, 1), 3, 1e-12) << "nothing was integrated meanwhile";
}

TEST(Pid, WhatIsNoNumberComesOutAndLeavesTheStateAlone) {
  Pid pid({.p = 1, .i = 1, .d = 1});
  pid.compute(1, 1);
  const double integral = pid.integral();
  EXPECT_TRUE(std::isnan(pid.compute(std::numeric_limits<double>::quiet_NaN(), 1)));
  EXPECT_TRUE(std::isnan(pid.compute(kInfinity, 1)));
  EXPECT_TRUE(std::isnan(pid.compute(1, -1)));
  EXPECT_EQ(pid.integral(), integral);
  EXPECT_NEAR(pid.compute(1, 1), 2, 1e-12);
}

TEST(Pid, TheIntegralStaysWithinItsClamps) {
  Pid pid({.i = 1, .i_min = -2, .i_max = 1});
  outputs(pid, {5, 5});
  EXPECT_EQ(pid.integral(), 1);
  outputs(pid, {-9, -9});
  EXPECT_EQ(pid.integral(), -2);
}

TEST(Pid, TheOldFormClampsTheShareAndLetsTheIntegralGrow) {
  Pid pid({.i = 1, .i_min = -1, .i_max = 1, .clamp_output_only = true});
  outputs(pid, {3, 3});
  EXPECT_EQ(pid.integral(), 6);
  EXPECT_EQ(pid.compute(0, 1), 1);
}

TEST(Pid, OnMeasurementAStepOfTheSetPointMakesNoKick) {
  Pid kicks({.d = 1}), smooth({.d = 1});
  EXPECT_NEAR(kicks.compute(1 - 0, 0.1), 10, 1e-12);
  smooth.compute_on_measurement(0, 0, 0.1);
  EXPECT_EQ(smooth.compute_on_measurement(1, 0, 0.1), 0);
  EXPECT_NEAR(smooth.compute_on_measurement(1, 0.05, 0.1), -0.5, 1e-12);
}

TEST(Pid, AFilteredDerivativeGetsThereLater) {
  Pid pid({.d = 1, .derivative_filter = 0.9});
  EXPECT_NEAR(pid.compute(0, 1.0, 0.1), 0.1, 1e-12);
  for (int k = 0; k < 200; ++k) pid.compute(0, 1.0, 0.1);
  EXPECT_NEAR(pid.last_output(), 1, 1e-6);
}

TEST(Pid, ImpossibleGainsAreRefusedWithAReason) {
  EXPECT_FALSE(check({.p = 1}));
  EXPECT_TRUE(check({.i_min = 1}));
  EXPECT_TRUE(check({.i_max = -1}));
  EXPECT_TRUE(check({.u_min = 2, .u_max = 1}));
  EXPECT_TRUE(check({.p = kInfinity}));
  EXPECT_TRUE(check({.error_deadband = -1}));
}

TEST(Pid, KeepsTheIntegralOverAResetWhereAsked) {
  Pid pid({.i = 1});
  outputs(pid, {1, 1});
  pid.reset(true);
  EXPECT_EQ(pid.integral(), 2);
  pid.reset();
  EXPECT_EQ(pid.integral(), 0);
}

}  // namespace
}  // namespace polyarm::controllers
