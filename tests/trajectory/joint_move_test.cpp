#include "polyarm/trajectory/joint_move.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "polyarm/trajectory/time_scale.hpp"

namespace polyarm::trajectory {
namespace {

struct Case {
  std::vector<double> from, to;
  std::vector<JointMotionLimits> limits;
};

Case random_case(std::mt19937& random) {
  const auto log_uniform = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
  };
  Case out;
  const int n = 1 + static_cast<int>(random() % 7);
  for (int j = 0; j < n; ++j) {
    out.from.push_back(std::uniform_real_distribution<double>(-3, 3)(random));
    out.to.push_back(out.from.back() + (random() % 5 == 0 ? 0 : log_uniform(1e-6, 6) * (random() % 2 ? 1 : -1)));
    const double v = log_uniform(0.05, 5);
    out.limits.push_back({v, v * log_uniform(1, 20), v * log_uniform(20, 2000)});
  }
  return out;
}

TEST(JointMove, KeepsEveryLimitAndArrivesExactly) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    const Case c = random_case(random);
    const std::size_t n = c.from.size();
    const Trajectory move = plan_joint_move(c.from, c.to, c.limits);
    std::vector<double> q(n), v(n), a(n), last_a(n, 0.0);
    std::size_t hint = 0;
    constexpr double dt = 1e-3;
    const int steps = static_cast<int>(std::min(move.duration() / dt + 2, 20000.0));
    for (int k = 0; k <= steps; ++k) {
      move.sample(k * dt, q, v, a, hint);
      for (std::size_t j = 0; j < n; ++j) {
        EXPECT_LE(std::abs(v[j]), c.limits[j].velocity * (1 + 1e-9));
        EXPECT_LE(std::abs(a[j]), c.limits[j].acceleration * (1 + 1e-9));
        EXPECT_LE(std::abs(a[j] - last_a[j]), c.limits[j].jerk * dt * (1 + 1e-6) + 1e-9);
      }
      last_a = a;
    }
    move.sample(move.duration() + 1, q, v, a, hint);
    EXPECT_EQ(q, c.to);
    for (const double x : v) EXPECT_EQ(x, 0);
  }
}

TEST(JointMove, IsAStraightLineOnWhichAllArriveTogether) {
  std::mt19937 random(2);
  for (int i = 0; i < 100; ++i) {
    const Case c = random_case(random);
    const Trajectory move = plan_joint_move(c.from, c.to, c.limits);
    std::vector<double> q(c.from.size());
    std::size_t hint = 0;
    for (double share = 0; share < 1; share += 0.05) {
      move.sample(share * move.duration(), q, {}, {}, hint);
      double s = -1;
      for (std::size_t j = 0; j < q.size(); ++j) {
        const double d = c.to[j] - c.from[j];
        if (std::abs(d) < 1e-3) continue;
        if (s < 0) s = (q[j] - c.from[j]) / d;
        EXPECT_NEAR((q[j] - c.from[j]) / d, s, 1e-9);
      }
    }
  }
}

TEST(JointMove, IsContinuousInPositionVelocityAndAcceleration) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random);
    const Trajectory move = plan_joint_move(c.from, c.to, c.limits);
    const std::size_t n = c.from.size();
    std::vector<double> q0(n), v0(n), a0(n), q1(n), v1(n), a1(n);
    for (std::size_t k = 0; k + 1 < move.segments(); ++k) {
      std::size_t before = k, after = k + 1;
      move.sample(move.end_of(k) * (1 - 1e-13), q0, v0, a0, before);
      move.sample(move.end_of(k) * (1 + 1e-13), q1, v1, a1, after);
      for (std::size_t j = 0; j < n; ++j) {
        EXPECT_NEAR(q0[j], q1[j], 1e-9);
        EXPECT_NEAR(v0[j], v1[j], 1e-8);
        EXPECT_NEAR(a0[j], a1[j], 1e-5 * c.limits[j].acceleration);
      }
    }
  }
}

TEST(JointMove, IsAsFastAsTheClosedFormsSay) {
  const std::vector<JointMotionLimits> limits{{1, 2, 10}};
  const auto duration = [&](double d) {
    return fastest_duration(std::vector{0.0}, std::vector{d}, limits);
  };
  EXPECT_NEAR(duration(0.01), 4 * std::cbrt(0.01 / 20), 1e-9);               // neither a nor v reached
  EXPECT_NEAR(duration(2.0), 2.0 / 1 + 1.0 / 2 + 2.0 / 10, 1e-9);            // both reached
  EXPECT_NEAR(duration(0.4), 0.2 + std::sqrt(0.04 + 4 * 0.4 / 2), 1e-9);     // a reached, v not
}

TEST(JointMove, StretchesToTheDurationAskedForAndNeverBelowTheFastest) {
  const std::vector<JointMotionLimits> limits{{1, 2, 10}, {2, 4, 20}};
  const std::vector<double> from{0, 0}, to{1, -0.5};
  JointMoveOptions options;
  options.duration = 7;
  EXPECT_NEAR(plan_joint_move(from, to, limits, options).duration(), 7, 1e-5);
  options.duration = 0.1;
  EXPECT_NEAR(plan_joint_move(from, to, limits, options).duration(), fastest_duration(from, to, limits), 1e-5);
}

TEST(JointMove, AMoveOfNoLengthStandsStill) {
  const std::vector<double> at{0.5, -1};
  const Trajectory move = plan_joint_move(at, at, std::vector<JointMotionLimits>(2));
  std::vector<double> q(2);
  std::size_t hint = 0;
  move.sample(0.0005, q, {}, {}, hint);
  EXPECT_EQ(q, at);
  EXPECT_LT(move.duration(), 0.01);
}

TEST(PlanStop, EndsAtRestWithinLimits) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const Case c = random_case(random);
    const std::size_t n = c.from.size();
    std::vector<double> v0, a0;
    for (const JointMotionLimits& limit : c.limits) {
      v0.push_back(share(random) * limit.velocity);
      a0.push_back(share(random) * limit.acceleration);
    }
    const Trajectory stop = plan_stop(c.from, v0, a0, c.limits);
    std::vector<double> q(n), v(n), a(n);
    std::size_t hint = 0;
    for (double t = 1e-9; t < stop.duration(); t += stop.duration() / 200) {
      stop.sample(t, q, v, a, hint);
      for (std::size_t j = 0; j < n; ++j) EXPECT_LE(std::abs(a[j]), c.limits[j].acceleration * (1 + 1e-6) + 1e-12);
    }
    stop.sample(stop.duration() * (1 - 1e-12), q, v, a, hint);
    for (std::size_t j = 0; j < n; ++j) EXPECT_NEAR(v[j], 0, 1e-6 * c.limits[j].velocity);
  }
}

TEST(TimeScale, StopsAndResumesSmoothly) {
  TimeScale scale(0.25);
  double last = 1;
  for (int i = 0; i < 250; ++i) {
    scale.advance(1e-3, 0);
    EXPECT_LE(std::abs(scale.value() - last), 1.5 / 0.25 * 1e-3 * (1 + 1e-9));
    EXPECT_LE(scale.value(), last);
    last = scale.value();
  }
  EXPECT_EQ(scale.value(), 0);
  EXPECT_EQ(scale.advance(1e-3, 0), 0);
  double passed = 0;
  for (int i = 0; i < 250; ++i) passed += scale.advance(1e-3, 1);
  EXPECT_EQ(scale.value(), 1);
  EXPECT_NEAR(passed, 0.125, 1e-6);
  EXPECT_EQ(scale.advance(1e-3, 1), 1e-3);
}

}  // namespace
}  // namespace polyarm::trajectory
