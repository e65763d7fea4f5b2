#include "polyarm/trajectory/joint_move.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "polyarm/base/error.hpp"

namespace polyarm::trajectory::joint_move_test {
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
    out.to.push_back(out.from.back() +
                     (random() % 5 == 0 ? 0 : log_uniform(1e-6, 6) * (random() % 2 ? 1 : -1)));
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
  const auto duration = [&](double d) { return fastest_duration(std::vector{0.0}, std::vector{d}, limits); };
  EXPECT_NEAR(duration(0.01), 4 * std::cbrt(0.01 / 20), 1e-9);            // neither a nor v reached
  EXPECT_NEAR(duration(2.0), 2.0 / 1 + 1.0 / 2 + 2.0 / 10, 1e-9);         // both reached
  EXPECT_NEAR(duration(0.4), 0.2 + std::sqrt(0.04 + 4 * 0.4 / 2), 1e-9);  // a reached, v not
}

TEST(JointMove, StretchesToTheDurationAskedForAndNeverBelowTheFastest) {
  const std::vector<JointMotionLimits> limits{{1, 2, 10}, {2, 4, 20}};
  const std::vector<double> from{0, 0}, to{1, -0.5};
  JointMoveOptions options;
  options.duration = 7;
  EXPECT_NEAR(plan_joint_move(from, to, limits, options).duration(), 7, 1e-5);
  options.duration = 0.1;
  EXPECT_NEAR(plan_joint_move(from, to, limits, options).duration(), fastest_duration(from, to, limits),
              1e-5);
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
    std::vector<double> last_a = a0;
    const double dt = stop.duration() / 200;
    for (int k = 0; k < 200; ++k) {
      stop.sample(k * dt, q, v, a, hint);
      for (std::size_t j = 0; j < n; ++j) {
        EXPECT_LE(std::abs(a[j]), c.limits[j].acceleration * (1 + 1e-6) + 1e-12);
        EXPECT_LE(std::abs(a[j] - last_a[j]),
                  c.limits[j].jerk * dt * (1 + 1e-6) + 1e-6 * c.limits[j].acceleration);
        if (k == 0) {
          EXPECT_NEAR(v[j], v0[j], 1e-12);
        }
      }
      last_a = a;
    }
    stop.sample(stop.duration() * (1 - 1e-12), q, v, a, hint);
    for (std::size_t j = 0; j < n; ++j) EXPECT_NEAR(v[j], 0, 1e-6 * c.limits[j].velocity);
  }
}

TEST(PlanStop, IsAsFastAsTheClosedFormsSay) {
  const std::vector<JointMotionLimits> limits{{1, 2, 10}};
  const auto duration = [&](double v, double a) {
    return plan_stop(std::vector{0.0}, std::vector{v}, std::vector{a}, limits).duration();
  };
  EXPECT_NEAR(duration(1, 0), 1.0 / 2 + 2.0 / 10, 1e-9);          // with a plateau: v / a + a / j
  EXPECT_NEAR(duration(-0.1, 0), 2 * std::sqrt(0.1 / 10), 1e-9);  // without
  EXPECT_NEAR(duration(0.05, -1), 0.1, 1e-9);                     // on its way out already: a / j
  // An acceleration of twice the limit comes back within it first: 0.2 s, then a stop from what that leaves.
  EXPECT_NEAR(duration(-2, 4), 0.2 + (2 - 0.6 - 0.2) / 2 + 0.2, 1e-9);
}

TEST(JointMoves, RestOnEveryWaypointAndShareTheDuration) {
  const std::vector<JointMotionLimits> limits{{1, 2, 10}, {2, 4, 20}};
  const std::vector<double> from{0, 0};
  const std::vector<std::vector<double>> waypoints{{1, -0.5}, {1, -0.5}, {0.3, 0.7}};
  const double first = fastest_duration(from, waypoints[0], limits);
  const double second = fastest_duration(waypoints[1], waypoints[2], limits);
  JointMoveOptions options;
  options.duration = 3 * (first + second);
  const Trajectory moves = plan_joint_moves(from, waypoints, limits, options);
  EXPECT_NEAR(moves.duration(), options.duration, 1e-5);
  std::vector<double> q(2), v(2);
  std::size_t hint = 0;
  moves.sample(3 * first + 0.5e-6, q, v, {}, hint);
  EXPECT_NEAR(q[0], 1, 1e-12);
  EXPECT_NEAR(q[1], -0.5, 1e-12);
  EXPECT_NEAR(v[0], 0, 1e-9);
  moves.sample(100, q, v, {}, hint);
  EXPECT_EQ(q, waypoints.back());
}

TEST(JointMove, SpeedAndAccelerationScalesShrinkTheirLimits) {
  const std::vector<JointMotionLimits> limits{{1, 2, 10}};
  const std::vector<double> from{0}, to{3};
  JointMoveOptions options;
  options.speed_scale = 0.5;
  options.acceleration_scale = 0.25;
  const Trajectory move = plan_joint_move(from, to, limits, options);
  double most_v = 0, most_a = 0;
  std::vector<double> v(1), a(1);
  std::size_t hint = 0;
  for (double t = 0; t < move.duration(); t += 1e-3) {
    move.sample(t, {}, v, a, hint);
    most_v = std::max(most_v, std::abs(v[0]));
    most_a = std::max(most_a, std::abs(a[0]));
  }
  EXPECT_NEAR(most_v, 0.5, 1e-6);
  EXPECT_NEAR(most_a, 0.5, 1e-6);
}

TEST(JointMove, TheThesisRuleIsScaleTimesDistance) {
  EXPECT_DOUBLE_EQ(thesis_duration(std::vector{1.0, 1.0}, std::vector{4.0, -3.0}, 0.5), 2.5);
}

TEST(JointMove, RefusesWhatIsNoMove) {
  const std::vector<JointMotionLimits> limits(2);
  const std::vector<double> at{0, 0}, more{0, 0, 0}, hole{0, NAN}, far{INFINITY, 0};
  EXPECT_THROW(plan_joint_move(at, more, limits), Error);
  EXPECT_THROW(plan_joint_move(at, hole, limits), Error);
  EXPECT_THROW(plan_joint_move(far, at, limits), Error);
  EXPECT_THROW(plan_joint_move(at, at, std::vector<JointMotionLimits>(1)), Error);
  EXPECT_THROW(plan_stop(at, hole, at, limits), Error);
  for (const double bad : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    EXPECT_THROW(plan_joint_move(at, at, std::vector<JointMotionLimits>{{bad, 1, 1}, {}}), Error);
    EXPECT_THROW(plan_joint_move(at, at, std::vector<JointMotionLimits>{{1, 1, bad}, {}}), Error);
    JointMoveOptions options;
    options.speed_scale = bad;
    EXPECT_THROW(plan_joint_move(at, at, limits, options), Error);
  }
}

}  // namespace
}  // namespace polyarm::trajectory::joint_move_test
