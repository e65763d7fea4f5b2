#include "polyarm/timing/planned_rows.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "polyarm/timing/timing.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/test_paths.hpp"

namespace polyarm::timing::planned_rows_test {
namespace {

const std::vector<trajectory::MotionLimits> kLimits(6, trajectory::MotionLimits::symmetric(2, 8, 100));

struct Made {
  std::size_t nodes;
  int allocations;
};

Made make(int points) {
  const TimedPath path = timed(test::random_spline(6, points, 3), kLimits);
  const test::RealtimeGuard guard;
  const PlannedRows rows(path, kLimits, 0.01);
  const std::string done = guard.violations();
  const auto at = done.find("malloc x");
  return {rows.nodes(), at == std::string::npos ? 0 : std::atoi(done.c_str() + at + 8)};
}

TEST(PlannedRows, AreMadeWithFarFewerAllocationsThanTheyHaveNodes) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "the guard watches nothing under sanitizers";
  for (const int points : {5, 40}) {
    const Made made = make(points);
    EXPECT_GT(made.nodes, 100u);
    EXPECT_GT(made.allocations, 0);
    EXPECT_LT(made.allocations, static_cast<int>(made.nodes) / 5) << points << " points";
  }
}

TEST(PlannedRows, AreWhatThePathSaysAtTheirNodes) {
  const TimedPath path = timed(test::random_spline(6, 6, 4), kLimits);
  const PlannedRows rows(path, kLimits, 0.01);
  std::vector<double> q(6), v(6), a(6), j(6);
  std::size_t hint = 0;
  for (std::size_t k = 0; k < rows.nodes(); ++k) {
    path.sample(rows.time(k), q, v, a, j, hint);
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(rows.at(k)->velocity[i], v[i], 1e-6);
      EXPECT_NEAR(rows.at(k)->acceleration[i], a[i], 1e-5);
    }
  }
}

}  // namespace
}  // namespace polyarm::timing::planned_rows_test
