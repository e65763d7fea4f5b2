/// Commands keep the controller's limits whatever the loop asks for.
#include "drivers/fanuc/limit_tables.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace polyarm::fanuc {
namespace {

constexpr double kPeriod = 0.008;

AxisLimits limits_of(double velocity, double acceleration, double jerk) {
  AxisLimits out;
  out.of[0].fill(velocity);
  out.of[1].fill(acceleration);
  out.of[2].fill(jerk);
  return out;
}

/// Differences of the commands, as the controller takes them.
class Watch {
 public:
  explicit Watch(const Six& at) : at_(at) {}
  void look(const Six& next, const AxisLimits& limits, double slack = 2e-6) {
    for (std::size_t i = 0; i < 6; ++i) {
      const double v = (next[i] - at_[i]) / kPeriod, a = (v - v_[i]) / kPeriod, j = (a - a_[i]) / kPeriod;
      EXPECT_LE(std::abs(v), limits.of[0][i] * (1 + slack)) << "velocity of axis " << i;
      EXPECT_LE(std::abs(a), limits.of[1][i] * (1 + slack)) << "acceleration of axis " << i;
      EXPECT_LE(std::abs(j), limits.of[2][i] * (1 + slack)) << "jerk of axis " << i;
      v_[i] = v;
      a_[i] = a;
    }
    at_ = next;
  }

 private:
  Six at_, v_{}, a_{};
};

TEST(FanucShaper, ATargetWithinTheLimitsIsPassedOnUnchanged) {
  const AxisLimits limits = limits_of(120, 400, 5000);
  Shaper shaper(kPeriod);
  shaper.begin({});
  for (int i = 1; i <= 500; ++i) {
    Six wanted{};
    wanted[1] = 10 * (1 - std::cos(2 * i * kPeriod));
    EXPECT_EQ(shaper.next(wanted, limits), wanted) << i;
  }
  EXPECT_EQ(shaper.shaped(), 0u);
}

TEST(FanucShaper, AStepIsTakenWithinTheLimitsAndReached) {
  const AxisLimits limits = limits_of(120, 400, 5000);
  Shaper shaper(kPeriod);
  Watch watch({});
  shaper.begin({});
  Six wanted{};
  wanted[0] = 5;
  wanted[3] = -0.02;
  for (int i = 0; i < 100; ++i) watch.look(shaper.next(wanted, limits), limits);
  EXPECT_NEAR(shaper.at()[0], 5, 1e-3);
  EXPECT_NEAR(shaper.at()[3], -0.02, 1e-3);
  EXPECT_LT(shaper.behind(), 1e-3);
  EXPECT_GT(shaper.shaped(), 5u);
}

/// Random targets, far and near, with pauses: no difference ever exceeds its limit.
TEST(FanucShaper, NoRandomTargetMakesItExceedALimit) {
  std::uint64_t seed = 5;
  const auto draw = [&] {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(seed >> 11) / 0x1p53;
  };
  for (int run = 0; run < 20; ++run) {
    const AxisLimits limits = limits_of(60 + 100 * draw(), 100 + 500 * draw(), 1000 + 8000 * draw());
    Shaper shaper(kPeriod);
    Watch watch({});
    shaper.begin({});
    Six wanted{};
    for (int i = 0; i < 2000 && !testing::Test::HasFailure(); ++i) {
      const double kind = draw();
      for (double& w : wanted)
        w += kind < 0.5    ? (draw() - 0.5) * 0.02
             : kind < 0.52 ? (draw() - 0.5) * 8
             : kind < 0.8  ? 0.3 * draw()
                           : 0;
      watch.look(kind > 0.97 ? shaper.brake(limits) : shaper.next(wanted, limits), limits, 0.02);
    }
  }
}

TEST(FanucShaper, BrakingEndsAtRestWithinTheLimits) {
  const AxisLimits limits = limits_of(120, 400, 5000);
  Shaper shaper(kPeriod);
  Watch watch({});
  shaper.begin({});
  Six wanted{};
  for (int i = 1; i <= 200; ++i) {
    const double t = i * kPeriod;
    wanted[2] = 40 * (t - std::sin(3 * t) / 3);
    watch.look(shaper.next(wanted, limits), limits);
  }
  EXPECT_GT(std::abs(shaper.velocity()[2]), 10);
  int steps = 0;
  for (; !shaper.still() && steps < 200; ++steps) watch.look(shaper.brake(limits), limits);
  EXPECT_LT(steps, 60);
  const Six at = shaper.at();
  for (int i = 0; i < 20; ++i) watch.look(shaper.brake(limits), limits);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(shaper.at()[i], at[i], 1e-6);
}

TEST(FanucLimitTables, LieBetweenTheirStepsAndTheirLoads) {
  LimitTables tables;
  EXPECT_FALSE(tables.complete());
  for (std::uint32_t axis = 1; axis <= 6; ++axis)
    for (const LimitKind kind : {LimitKind::velocity, LimitKind::acceleration, LimitKind::jerk}) {
      LimitTable table;
      table.axis = axis;
      table.kind = kind;
      table.max_speed = 1900;
      for (std::size_t k = 0; k < kLimitSteps; ++k) {
        table.empty[k] = static_cast<float>(1000 - 10 * static_cast<int>(k));
        table.loaded[k] = table.empty[k] / 2;
      }
      tables.set(table);
    }
  EXPECT_TRUE(tables.complete());
  EXPECT_NEAR(tables.at(0, 0).of[1][3], 1000, 1e-6);
  EXPECT_NEAR(tables.at(0, 1).of[1][3], 500, 1e-6);
  EXPECT_NEAR(tables.at(0, 0.5).of[2][5], 750, 1e-6);
  EXPECT_NEAR(tables.at(1000, 0).of[0][0], 1000 - 12 * 10, 1e-3) << "of 1.2 times the speed";
  EXPECT_NEAR(tables.at(1e9, 0).of[0][0], 1000 - 190, 1e-3);
  EXPECT_NEAR(tables.at(-1, -1).of[0][0], 1000, 1e-3);
}

TEST(FanucLimitTables, TheLowestStepNearTheSpeedCounts) {
  LimitTables tables;
  LimitTable table;
  table.max_speed = 1900;
  table.empty.fill(100);
  table.loaded.fill(100);
  table.empty[10] = 40;
  tables.set(table);
  EXPECT_NEAR(tables.at(1000, 0).of[0][0], 40, 1e-6);
  EXPECT_NEAR(tables.at(900, 0).of[0][0], 40, 1e-6);
  EXPECT_NEAR(tables.at(300, 0).of[0][0], 100, 1e-6);
}

}  // namespace
}  // namespace polyarm::fanuc
