#include "polyarm/controllers/pid.hpp"

#include <gtest/gtest.h>

#include <random>
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

TEST(Pid, AJointWithoutIntegralGainNeverGrowsOneByBackCalculation) {
  Pid pid({.p = 10,
           .u_min = -1,
           .u_max = 1,
           .antiwindup = AntiWindup::back_calculation,
           .tracking_time_constant = 0.1});
  for (int k = 0; k < 100; ++k) EXPECT_EQ(pid.compute(5, 0.01), 1);
  EXPECT_EQ(pid.integral(), 0);
  EXPECT_EQ(pid.compute(0, 0.01), 0);
}

TEST(Pid, AnIntegralThatIsKeptWhileItsGainIsZeroIsNotTakenBack) {
  PidGains gains{.p = 10,
                 .i = 1,
                 .u_min = -20,
                 .u_max = 20,
                 .antiwindup = AntiWindup::back_calculation,
                 .tracking_time_constant = 0.1};
  Pid pid(gains);
  pid.compute(1, 1);
  ASSERT_EQ(pid.integral(), 1);
  gains.i = 0;
  pid.set_gains(gains);
  for (const double error : {5.0, -5.0, 0.0}) pid.compute(error, 0.01);
  EXPECT_EQ(pid.integral(), 1) << "what is beyond the limits has nothing to do with it";
}

TEST(Pid, ReverseActingGainsTakeTheExcessBackToo) {
  PidGains gains{.p = 2, .i = 0.5, .u_min = -1, .u_max = 1, .antiwindup = AntiWindup::back_calculation};
  Pid direct(gains);
  gains.p = -2, gains.i = -0.5;
  Pid reverse(gains);
  for (const double error : {10.0, 3.0, -1.0}) {
    EXPECT_EQ(direct.compute(error, 1), -reverse.compute(error, 1));
    EXPECT_EQ(direct.integral(), -reverse.integral());
  }
}

TEST(Pid, ItsTermsAddUpToTheOutput) {
  Pid pid({.p = 2, .i = 3, .d = 0.5});
  pid.compute(1, 0.1);
  EXPECT_NEAR(pid.compute(2, 0.1), 4 + 0.3 + 5, 1e-12);
  EXPECT_NEAR(pid.terms().p, 4, 1e-12);
  EXPECT_NEAR(pid.terms().i, 0.3, 1e-12);
  EXPECT_NEAR(pid.terms().d, 5, 1e-12);
}

TEST(Pid, FollowsOnTheErrorOrOnTheMeasurementAsTheGainsSay) {
  Pid on_error({.d = 1}), on_measurement({.d = 1, .derivative_on_measurement = true});
  for (Pid* pid : {&on_error, &on_measurement}) pid->follow(0, 0, 0.1);
  EXPECT_NEAR(on_error.follow(1, 0, 0.1), 10, 1e-12);
  EXPECT_EQ(on_measurement.follow(1, 0, 0.1), 0);
}

TEST(Pid, ASumBeyondAllNumbersIsNoneAndIsForgotten) {
  Pid pid({.p = 10, .i = 10, .d = 1});
  pid.compute(1, 1);
  const double before = pid.integral(), huge = std::numeric_limits<double>::max();
  EXPECT_TRUE(std::isnan(pid.compute(huge, 1)));
  EXPECT_EQ(pid.integral(), before);
  EXPECT_NEAR(pid.compute(1, 1), 20, 1e-12) << "the derivative does not remember it either";
  Pid limited({.i = 10, .u_min = -1, .u_max = 1});
  limited.compute(huge, 1);
  EXPECT_EQ(limited.compute(0, 1), 0) << "an integral beyond all numbers would never come back";
}

TEST(Pid, ImpossibleGainsDoNotReplaceTheOldOnes) {
  Pid pid({.p = 1});
  EXPECT_FALSE(pid.set_gains({.p = 5, .i_min = 1}));
  EXPECT_EQ(pid.gains().p, 1);
  EXPECT_TRUE(pid.set_gains({.p = 5}));
  EXPECT_EQ(pid.gains().p, 5);
  EXPECT_EQ(Pid({.p = kInfinity}).compute(1, 1), 0);
}

TEST(Pid, TheYesOrNoAgreesWithTheReason) {
  std::mt19937 random(11);
  const double values[] = {0, -0.0, 1, -1, 1e308, kInfinity, -kInfinity, std::nan("")};
  std::uniform_int_distribution<std::size_t> any(0, std::size(values) - 1), strategy(0, 2);
  int impossible = 0;
  for (int k = 0; k < 200'000; ++k) {
    PidGains g;
    double* fields[] = {&g.p,
                        &g.i,
                        &g.d,
                        &g.u_min,
                        &g.u_max,
                        &g.i_min,
                        &g.i_max,
                        &g.tracking_time_constant,
                        &g.error_deadband,
                        &g.derivative_filter};
    for (double* field : fields)
      if (any(random) < 2) *field = values[any(random)];
    g.antiwindup = static_cast<AntiWindup>(strategy(random));
    g.integrate_first = any(random) == 0;
    ASSERT_EQ(possible(g), !check(g).has_value()) << check(g).value_or("");
    impossible += possible(g) ? 0 : 1;
  }
  EXPECT_GT(impossible, 1000);
  EXPECT_LT(impossible, 199'000);
}

TEST(Pid, NoOutputWhateverTheErrorsLeavesItsLimits) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> error(-100, 100), gain(-20, 20), dt(1e-4, 0.1), limit(0, 5);
  for (int round = 0; round < 300; ++round) {
    const PidGains gains{.p = gain(random),
                         .i = gain(random),
                         .d = gain(random),
                         .u_min = -limit(random),
                         .u_max = limit(random),
                         .i_min = -limit(random),
                         .i_max = limit(random),
                         .antiwindup = static_cast<AntiWindup>(round % 3),
                         .error_deadband = limit(random)};
    Pid pid(gains);
    for (int k = 0; k < 200; ++k) {
      const double out = pid.compute(error(random), dt(random));
      ASSERT_GE(out, gains.u_min);
      ASSERT_LE(out, gains.u_max);
      ASSERT_GE(pid.integral(), gains.i_min);
      ASSERT_LE(pid.integral(), gains.i_max);
    }
  }
}

/// A mass of 1 kg on a slide under gravity along it, driven by a limited force.
double settled(Pid pid, double set_point) {
  double x = 0, v = 0;
  for (int k = 0; k < 20'000; ++k) {
    v += (pid.follow(set_point, x, 1e-3) - 2.0) * 1e-3;
    x += v * 1e-3;
  }
  return x;
}

TEST(Pid, EveryWayAgainstWindUpBringsAMassToItsPlace) {
  PidGains gains{.p = 40, .i = 30, .d = 12, .u_min = -5, .u_max = 5, .derivative_filter = 0.002};
  for (const bool measured : {false, true})
    for (const auto way :
         {AntiWindup::none, AntiWindup::back_calculation, AntiWindup::conditional_integration}) {
      gains.antiwindup = way;
      gains.derivative_on_measurement = measured;
      EXPECT_NEAR(settled(Pid(gains), 1.0), 1.0, 1e-3);
    }
}

// --- the form of ros_control ------------------------------------------------------------------------------

TEST(RosControlPid, ThePresentErrorIsInTheOutput) {
  Pid pid(gains_of({.i = 1, .i_clamp = 10}));
  expect_near(outputs(pid, {-.5, -.5, 0, 0, 1, 0}), {-.5, -1, -1, -1, 0, 0});
}

TEST(RosControlPid, WithoutAntiWindupTheIntegralGrowsBehindItsClamp) {
  Pid pid(gains_of({.i = 1, .i_clamp = 1}));
  expect_near(outputs(pid, {3, 3, -3, -3, -3}), {1, 1, 1, 0, -1});
  EXPECT_EQ(pid.integral(), -3);
}

TEST(RosControlPid, WithAntiWindupTheIntegralItselfIsClamped) {
  Pid pid(gains_of({.i = 1, .i_clamp = 1, .antiwindup = true}));
  expect_near(outputs(pid, {3, 3, -1.5, -3}), {1, 1, -.5, -1});
}

TEST(RosControlPid, ClampsOfEachSideReplaceTheCommonOneWhateverTheirSign) {
  const PidGains gains = gains_of({.i_clamp = -3, .i_clamp_max = -2});
  EXPECT_EQ(gains.i_min, -3);
  EXPECT_EQ(gains.i_max, 2);
  EXPECT_EQ(gains_of({.i_clamp = 3, .i_clamp_min = 1}).i_min, -1);
}

TEST(RosControlPid, WithoutAClampTheIntegralHasNoShareAndThatIsSaid) {
  const PidGains gains = gains_of({.p = 1, .i = 5});
  Pid pid(gains);
  outputs(pid, {1, 1, 1});
  EXPECT_EQ(pid.last_output(), 1);
  ASSERT_TRUE(without_effect(gains));
  EXPECT_NE(without_effect(gains)->find("i_clamp"), std::string::npos);
  EXPECT_FALSE(without_effect(gains_of({.i = 5, .i_clamp = 1})));
  EXPECT_FALSE(without_effect(gains_of({.p = 5})));
}

}  // namespace
}  // namespace polyarm::controllers
