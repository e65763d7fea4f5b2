#include "polyarm/trajectory/limit_use.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/trajectory/splines.hpp"

namespace polyarm::trajectory::limit_use_test {
namespace {

const MotionLimits kLimits{2, 5, 50, -1, -4};

/// Random points with velocities and accelerations, at random times.
Trajectory random_trajectory(std::mt19937_64& engine, std::size_t joints, std::size_t points) {
  std::uniform_real_distribution<double> draw(-1, 1);
  std::vector<TrajectoryPoint> all(points);
  double time = 0;
  for (TrajectoryPoint& p : all) {
    for (auto* v : {&p.positions, &p.velocities, &p.accelerations})
      for (std::size_t j = 0; j < joints; ++j) v->push_back(draw(engine));
    p.time_from_start = time;
    time += 0.3 + std::abs(draw(engine));
  }
  SplineOptions options;
  options.allow_nonzero_velocity_at_end = true;
  return interpolate(all.front(), all, {}, options);
}

TEST(LimitUse, IsThatOfManySamplesAndNeverLess) {
  std::mt19937_64 engine(1);
  for (int k = 0; k < 20; ++k) {
    const Trajectory t = random_trajectory(engine, 2, 5);
    const std::vector<JointUse> uses = limit_use(t, std::vector<MotionLimits>(2, kLimits));
    std::vector<double> q(2), v(2), a(2), before(2);
    std::size_t hint = 0;
    const int samples = 20000;
    for (std::size_t j = 0; j < 2; ++j) {
      double low = 1e9, high = -1e9, speed = 0, acceleration = 0, jerk = 0;
      std::size_t segment = 0;
      for (int i = 0; i <= samples; ++i) {
        t.sample(std::min(t.duration() * i / samples, t.duration() * (1 - 1e-12)), q, v, a, hint);
        low = std::min(low, q[j]), high = std::max(high, q[j]);
        speed = std::max({speed, v[j] / 2, -v[j]});
        acceleration = std::max({acceleration, a[j] / 5, -a[j] / 4});
        if (i > 0 && hint == segment)
          jerk = std::max(jerk, std::abs(a[j] - before[j]) / (t.duration() / samples) / 50);
        before = a, segment = hint;
      }
      const JointUse& use = uses[j];
      EXPECT_NEAR(use.lowest.value, low, 1e-6);
      EXPECT_NEAR(use.highest.value, high, 1e-6);
      EXPECT_NEAR(use.velocity_use, speed, 1e-5 * speed);
      EXPECT_NEAR(use.acceleration_use, acceleration, 1e-3 * acceleration);
      EXPECT_NEAR(use.jerk_use, jerk, 1e-2 * jerk);
      EXPECT_GE(use.velocity_use, speed * (1 - 1e-12));
      EXPECT_GE(use.acceleration_use, acceleration * (1 - 1e-12));
      EXPECT_GE(use.jerk_use, jerk * (1 - 1e-6));
      EXPECT_EQ(use.velocity_steps, 2) << "starts and ends in motion";
      t.sample(use.velocity.time, q, v, a, hint);
      EXPECT_NEAR(v[j], use.velocity.value, 1e-9);
      t.sample(use.highest.time, q, v, a, hint);
      EXPECT_NEAR(q[j], use.highest.value, 1e-9);
    }
  }
}

TEST(LimitUse, FindsStepsAtThePointsThemselves) {
  TrajectoryPoint start{{0}, {}, {}, {}, 0}, middle{{1}, {}, {}, {}, 1}, end{{0}, {}, {}, {}, 3};
  const std::vector<TrajectoryPoint> points{start, middle, end};
  const auto uses = limit_use(interpolate(start, points), std::vector<MotionLimits>(1, kLimits));
  EXPECT_EQ(uses[0].velocity_steps, 3);
  EXPECT_DOUBLE_EQ(uses[0].velocity_step.value, -1.5);
  EXPECT_DOUBLE_EQ(uses[0].velocity_step.time, 1);
  EXPECT_NEAR(uses[0].acceleration_use, 0, 1e-9);
  EXPECT_DOUBLE_EQ(uses[0].velocity_use, 0.5);
}

TEST(LimitUse, SaysByHowMuchLongerItHasToTake) {
  JointUse a, b;
  a.velocity_use = 0.9, a.acceleration_use = 4, a.jerk_use = 1;
  b.jerk_use = 27;
  EXPECT_DOUBLE_EQ(stretch_needed(std::vector<JointUse>{a}), 2);
  EXPECT_DOUBLE_EQ(stretch_needed(std::vector<JointUse>{a, b}), 3);
  EXPECT_THROW(limit_use(Trajectory(2), std::vector<MotionLimits>(1)), Error);
}

}  // namespace
}  // namespace polyarm::trajectory::limit_use_test
