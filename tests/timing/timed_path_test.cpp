#include "polyarm/timing/timed_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "polyarm/timing/timing.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/test_paths.hpp"

namespace polyarm::timing::path_trajectory_test {
namespace {

TimedPath some(std::uint64_t seed) {
  return timed(test::random_spline(6, 6, seed),
               std::vector<trajectory::MotionLimits>(6, trajectory::MotionLimits::symmetric(2, 8, 100)));
}

TEST(PathTrajectory, DerivativesAreThoseOfThePositions) {
  const TimedPath path = some(1);
  std::vector<double> before(6), after(6), q(6), v(6), a(6), j(6), va(6), vb(6), aa(6), ab(6);
  std::size_t hint = 0;
  const double step = 1e-5;
  for (double t = 0.01; t < path.duration() - 0.01; t += 0.0173) {
    path.sample(t - step, before, vb, ab, {}, hint), path.sample(t + step, after, va, aa, {}, hint);
    path.sample(t, q, v, a, j, hint);
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(v[i], (after[i] - before[i]) / (2 * step), 1e-6);
      EXPECT_NEAR(a[i], (va[i] - vb[i]) / (2 * step), 2e-3);
      EXPECT_NEAR((aa[i] - ab[i]) / (2 * step), j[i], 210);
    }
  }
}

TEST(PathTrajectory, FindsTheTimeOfAPlace) {
  const TimedPath path = some(2);
  std::size_t hint = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double s = path.path().length() * i / 1000;
    EXPECT_NEAR(path.profile().at(path.profile().time_at(s), hint).s, s, 1e-12 * path.path().length());
  }
}

TEST(PathTrajectory, QuinticsFollowItWithinTheToleranceAndSmoothly) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const TimedPath path = some(seed);
    const trajectory::Trajectory trajectory = to_trajectory(path);
    EXPECT_NEAR(trajectory.duration(), path.duration(), 1e-9);
    std::vector<double> q(6), v(6), a(6), p(6), pv(6), pa(6);
    std::size_t hint = 0, other = 0;
    for (int i = 0; i < 20000; ++i) {
      const double t = path.duration() * i / 20000;
      path.sample(t, q, v, a, {}, hint), trajectory.sample(t, p, pv, pa, other);
      for (std::size_t k = 0; k < 6; ++k) {
        ASSERT_NEAR(p[k], q[k], 1e-8);
        ASSERT_NEAR(pv[k], v[k], 1e-5);
      }
    }
    for (std::size_t i = 0; i + 1 < trajectory.segments(); ++i) {
      const double t = trajectory.end_of(i);
      std::size_t zero = 0;
      trajectory.sample(t - 1e-9, q, v, a, zero), trajectory.sample(t + 1e-9, p, pv, pa, zero);
      for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(a[k], pa[k], 1e-4);
    }
  }
}

TEST(PathTrajectory, SamplingAllocatesNothing) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP();
  const TimedPath path = some(3);
  std::vector<double> q(6), v(6), a(6), j(6);
  std::size_t hint = 0;
  test::RealtimeGuard guard;
  for (int i = 0; i < 10000; ++i) path.sample(path.duration() * (i % 997) / 997, q, v, a, j, hint);
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::timing::path_trajectory_test
