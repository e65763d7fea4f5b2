// Durations against optimisers of their own, which are slow and share nothing with what they judge.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "polyarm/timing/timing.hpp"
#include "tests/support/slow_state_to_state.hpp"
#include "tests/support/slow_timing.hpp"
#include "tests/support/test_paths.hpp"

namespace polyarm::timing::shortest_test {
namespace {

/// Velocities of 1.5 to 4.5 rad/s, reached within 1/8 to 1/2 s, accelerations within 1/30 to 1/5 s.
std::vector<trajectory::MotionLimits> arm_limits(std::mt19937_64& engine, std::size_t joints) {
  std::uniform_real_distribution<double> draw(0, 1);
  std::vector<trajectory::MotionLimits> out;
  for (std::size_t j = 0; j < joints; ++j) {
    const double v = 1.5 + 3 * draw(engine), a = v * (2 + 6 * draw(engine));
    out.push_back(trajectory::MotionLimits::symmetric(v, a, a * (5 + 25 * draw(engine))));
  }
  return out;
}

double ratio(const paths::Path& path, const std::vector<trajectory::MotionLimits>& limits,
             std::size_t intervals) {
  test::SlowOptions options;
  options.intervals = intervals;
  options.rounds = 2;
  const double slow = test::SlowTiming(path, limits, options).duration();
  const Timing timing = time_path(path, limits);
  EXPECT_LE(timing.excess, 1e-6);
  return timing.profile.duration() / slow;
}

TEST(ShortestTime, IsWithinFivePercentOfASlowOptimiser) {
  std::mt19937_64 engine(11);
  for (int k = 0; k < 6; ++k) {
    const auto path = test::random_spline(6, 10, 900 + std::uint64_t(k));
    const double r = ratio(*path, arm_limits(engine, 6), 400);
    EXPECT_LE(r, 1.05) << k;
    EXPECT_GE(r, 0.98) << "the slow optimiser is none, case " << k;
  }
  const auto longer = test::random_spline(6, 50, 950);
  const double r = ratio(*longer, arm_limits(engine, 6), 1200);
  EXPECT_LE(r, 1.05);
  EXPECT_GE(r, 0.98);
}

TEST(ShortestTime, IsWithinFivePercentOnBlendedLines) {
  std::mt19937_64 engine(12);
  std::uniform_real_distribution<double> draw(-1.5, 1.5);
  for (int k = 0; k < 3; ++k) {
    std::vector<std::vector<double>> points(6, std::vector<double>(6));
    for (auto& p : points)
      for (double& x : p) x = draw(engine);
    EXPECT_LE(ratio(*test::blended_lines(points, 0.2), arm_limits(engine, 6), 500), 1.05) << k;
  }
}

/// A line has a known optimum: the slow optimiser has to come near it from above.
TEST(ShortestTime, TheSlowOptimiserFindsTheSevenPhasesOfALine) {
  const auto line = test::straight_line({0, 0, 0}, {1, -2, 0.5}, 1);
  std::vector<trajectory::MotionLimits> limits(3, trajectory::MotionLimits::symmetric(2, 6, 40));
  const double slow = test::SlowTiming(*line, limits, {800, 1e-5, 2}).duration();
  const double exact = 2.0 / 2 + 2.0 / 6 + 6.0 / 40;
  EXPECT_GE(slow, exact * (1 - 1e-9));
  EXPECT_LE(slow, exact * 1.01);
  EXPECT_NEAR(time_path(*line, limits).profile.duration(), exact, 1e-6);
}

struct AxisCase {
  trajectory::MotionState from, to;
  trajectory::MotionLimits limits;
};
/// Starts and ends that can be left and reached within asymmetric limits.
AxisCase axis_case(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> draw(-1, 1);
  const auto size = [&] { return std::pow(10, draw(engine)); };
  for (;;) {
    AxisCase c;
    c.limits = {size(), size(), 3 * size(), -size(), -size()};
    const auto state = [&](double at) {
      const double v = draw(engine), a = draw(engine);
      return trajectory::MotionState{at, v < 0 ? -v * c.limits.min_velocity : v * c.limits.max_velocity,
                                     a < 0 ? -a * c.limits.min_acceleration : a * c.limits.max_acceleration};
    };
    c.from = state(0), c.to = state(3 * size() * draw(engine));
    const auto stays = [&](double v, double a) {
      const double later = v + a * std::abs(a) / (2 * c.limits.max_jerk);
      return later < c.limits.max_velocity && later > c.limits.min_velocity;
    };
    if (stays(c.from.velocity, c.from.acceleration) && stays(c.to.velocity, -c.to.acceleration)) return c;
  }
}

TEST(ShortestTime, FromStateToStateIsNeverLongerThanWhatIsFoundByTrying) {
  std::mt19937_64 engine(13);
  int found = 0, equal = 0;
  for (int k = 0; k < 300; ++k) {
    const AxisCase c = axis_case(engine);
    const double slow = test::SlowAxis(c.from, c.to, c.limits).shortest();
    trajectory::StateToState plan;
    ASSERT_EQ(plan.plan({&c.from, 1}, {&c.to, 1}, {&c.limits, 1}), trajectory::MotionStatus::ok);
    EXPECT_LE(plan.duration(), slow * (1 + 1e-8)) << k;
    found += std::isfinite(slow), equal += std::abs(plan.duration() - slow) < 1e-6 * slow;
  }
  EXPECT_GT(found, 285) << "of 300";
  EXPECT_GT(equal, 270) << "the slow optimiser is none";
}

TEST(ShortestTime, OfAxesThatArriveTogetherIsNeverLongerThanWhatIsFoundByTrying) {
  std::mt19937_64 engine(14);
  int found = 0;
  for (int k = 0; k < 40; ++k) {
    std::vector<trajectory::MotionState> from, to;
    std::vector<trajectory::MotionLimits> limits;
    for (int i = 0; i < 3; ++i) {
      const AxisCase c = axis_case(engine);
      from.push_back(c.from), to.push_back(c.to), limits.push_back(c.limits);
    }
    const double slow = test::slow_synchronised(from, to, limits);
    trajectory::StateToState plan;
    ASSERT_EQ(plan.plan(from, to, limits), trajectory::MotionStatus::ok);
    EXPECT_LE(plan.duration(), slow * (1 + 1e-8)) << k;
    found += std::isfinite(slow);
  }
  EXPECT_GT(found, 35) << "of 40";
}

}  // namespace
}  // namespace polyarm::timing::shortest_test
