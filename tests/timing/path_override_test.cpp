#include "polyarm/timing/path_override.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "polyarm/timing/timing.hpp"
#include "tests/support/realtime_guard.hpp"
#include "tests/support/slow_stop.hpp"
#include "tests/support/stop_moments.hpp"
#include "tests/support/test_paths.hpp"

namespace polyarm::timing::path_override_test {
namespace {

constexpr double kPeriod = 1e-3;
const std::vector<trajectory::MotionLimits> kLimits(6, trajectory::MotionLimits::symmetric(2, 8, 100));

TimedPath some(std::uint64_t seed) {
  return timed(test::random_spline(6, 8, seed), kLimits);
}

/// Highest use of a limit during a cycle that began at time, factor and rate and had this bend: sampled ten
/// times.
double most_used(const TimedPath& path, double time, double factor, double rate, double bend) {
  std::vector<double> q(6), v(6), a(6), j(6);
  std::size_t hint = 0;
  double most = 0;
  for (int k = 0; k <= 10; ++k) {
    const double t = kPeriod * k / 10;
    const double at = time + t * (factor + t * (rate / 2 + t * bend / 6));
    if (at < 0 || at > path.duration()) continue;
    const double f = factor + t * (rate + t * bend / 2), g = rate + t * bend;
    path.sample(at, q, v, a, j, hint);
    for (std::size_t i = 0; i < 6; ++i) {
      const trajectory::MotionLimits& l = kLimits[i];
      most = std::max({most, std::abs(v[i] * f) / l.max_velocity,
                       std::abs(a[i] * f * f + v[i] * g) / l.max_acceleration,
                       std::abs(j[i] * f * f * f + 3 * a[i] * f * g + v[i] * bend) / l.max_jerk});
    }
  }
  return most;
}

struct Seen {
  double most = 0;
  int cycles = 0;
};
/// Advances until it stands or moves steadily at `target`, at most `cycles`.
Seen drive(PathOverride& o, const TimedPath& path, double target, int cycles) {
  Seen out;
  for (; out.cycles < cycles && (o.factor() != target || o.rate() != 0); ++out.cycles) {
    const double time = o.time(), factor = o.factor(), rate = o.rate();
    o.advance(target);
    if (o.finished()) break;
    out.most = std::max(out.most, most_used(path, time, factor, rate, o.bend()));
  }
  return out;
}

/// No joint can come to rest sooner, whatever the path.
double soonest(const TimedPath& path, double time) {
  std::vector<double> q(6), v(6), a(6);
  std::size_t hint = 0;
  path.sample(time, q, v, a, {}, hint);
  double most = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    trajectory::StateToState plan;
    const trajectory::MotionState from{0, v[i], a[i]}, to{};
    trajectory::MotionOptions options;
    options.target = trajectory::TargetKind::velocity;
    EXPECT_EQ(plan.plan({&from, 1}, {&to, 1}, {&kLimits[i], 1}, options), trajectory::MotionStatus::ok);
    most = std::max(most, plan.duration());
  }
  return most;
}

TEST(PathOverride, StopsAndResumesAnywhereWithinEveryLimit) {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const TimedPath path = some(seed);
    for (double part = 0.03; part < 0.9; part += 0.09) {
      PathOverride o(path, kLimits, kPeriod);
      o.begin(part * path.duration(), 1);
      const Seen stop = drive(o, path, 0, 3000);
      EXPECT_TRUE(o.stands()) << seed << " " << part;
      EXPECT_LE(stop.most, 1 + 1e-6) << seed << " " << part;
      ratios.push_back(stop.cycles * kPeriod / soonest(path, part * path.duration()));
      const Seen resume = drive(o, path, 1, 20000);
      EXPECT_TRUE(o.factor() == 1 || o.finished()) << seed << " " << part << " " << o.factor();
      EXPECT_LE(resume.most, 1 + 1e-6) << seed << " " << part;
    }
  }
  std::sort(ratios.begin(), ratios.end());
  std::printf("stop over the soonest of any joint alone: p50 %.3f p90 %.3f max %.3f\n",
              ratios[ratios.size() / 2], ratios[ratios.size() * 9 / 10], ratios.back());
  EXPECT_LE(ratios[ratios.size() / 2], 1.05);
  EXPECT_LE(ratios[ratios.size() * 9 / 10], 1.3) << "what holds for one joint alone cannot always be had";
}

/// Moments at which a plan leaves little to brake with: joints at their limits of acceleration or jerk, or
/// soon there.
TEST(PathOverride, StopsNearlyAsSoonAsASearchFinds) {
  struct Case {
    std::uint64_t seed;
    double time, factor;
  };
  for (const Case& c : {Case{109, 1.641, 1}, Case{112, 6.782, 1}, Case{100, 6.030, 0.18}}) {
    const TimedPath path = some(c.seed);
    PathOverride o(path, kLimits, kPeriod);
    o.begin(c.time, c.factor);
    const Seen stop = drive(o, path, 0, 3000);
    const double shortest = test::SlowStop(path, kLimits, 8e-3).search(c.time, c.factor);
    EXPECT_LE(stop.cycles * kPeriod, 1.1 * shortest) << c.seed;
    EXPECT_LE(stop.most, 1 + 1e-6);
  }
}

TEST(PathOverride, StopsNearlyAsSoonAsASearchFindsWhereJointsAreUnequal) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const test::StopMoment m = test::random_moment(seed);
    PathOverride o(m.path, m.limits, kPeriod);
    o.begin(m.time, m.factor);
    const double took = o.stopping().time;
    EXPECT_LE(took, 1.1 * test::SlowStop(m.path, m.limits, 12e-3).search(m.time, m.factor)) << seed;
  }
}

TEST(PathOverride, ChangesASteadyOverrideAsSoonAsItStopsAndStarts) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const TimedPath path = some(seed);
    for (double part = 0.1; part < 0.8; part += 0.2) {
      PathOverride o(path, kLimits, kPeriod);
      o.begin(part * path.duration(), 0.5);
      const double shortest = soonest(path, part * path.duration());  // from full speed to rest
      for (const double target : {0.8, 0.6, 0.3, 0.5}) {
        const Seen change = drive(o, path, target, 3000);
        EXPECT_EQ(o.factor(), o.finished() ? o.factor() : target);
        EXPECT_LE(change.cycles * kPeriod, 1.1 * shortest + 0.1);
        EXPECT_LE(change.most, 1 + 1e-6);
      }
    }
  }
}

TEST(PathOverride, AnImmediateStopKeepsItsHarderLimitsAndGoesOnUntilItStands) {
  const TimedPath path = some(4);
  PathOverride soft(path, kLimits, kPeriod), hard(path, kLimits, kPeriod);
  double most = 0;
  int cycles = 0;
  for (auto* o : {&soft, &hard}) o->begin(0.4 * path.duration(), 1);
  const Seen stop = drive(soft, path, 0, 3000);
  for (; cycles < 3000 && !hard.stands(); ++cycles) {
    const double time = hard.time(), factor = hard.factor(), rate = hard.rate();
    hard.advance(cycles < 10 ? 0 : 1, cycles < 10);
    most = std::max(most, most_used(path, time, factor, rate, hard.bend()));
  }
  EXPECT_LT(cycles, 0.6 * stop.cycles);
  EXPECT_GT(most, 1.5) << "of the limits of ordinary stops";
  EXPECT_LE(most, PathOverride::kHarder * PathOverride::kHarder * (1 + 1e-6));
  const Seen again = drive(hard, path, 1, 3000);
  EXPECT_LE(again.most, 1 + 1e-6) << "what follows keeps the limits";
}

TEST(PathOverride, FollowsRandomRequestsOnThePathWithinEveryLimit) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> draw(-0.3, 1.2);
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const TimedPath path = some(seed);
    PathOverride o(path, kLimits, kPeriod);
    double most = 0, target = 1;
    std::vector<double> q(6), v(6), a(6), before(6), exact(6);
    std::size_t hint = 0;
    for (int cycle = 0; cycle < 6000 && !o.finished(); ++cycle) {
      if (cycle % 237 == 0) target = std::min(draw(engine), 1.0);
      const double time = o.time(), factor = o.factor(), rate = o.rate();
      o.advance(target);
      if (o.time() > 0) most = std::max(most, most_used(path, time, factor, rate, o.bend()));
      o.sample(q, v, a);
      path.sample(o.time(), exact, {}, {}, {}, hint);
      EXPECT_EQ(q, exact);
    }
    EXPECT_LE(most, 1 + 1e-6) << seed;
  }
}

TEST(PathOverride, ActsInTheNextCycleWhereJointsAllow) {
  const TimedPath path = some(1);
  PathOverride o(path, kLimits, kPeriod);
  o.begin(0.4 * path.duration(), 0.5);
  o.advance(0);
  EXPECT_LT(o.factor(), 0.5);
}

TEST(PathOverride, SaysHowLongAndFarAStopTakes) {
  const TimedPath path = some(2);
  PathOverride o(path, kLimits, kPeriod);
  o.begin(0.5 * path.duration(), 0.8);
  const StoppingWay told = o.stopping();
  ASSERT_TRUE(told.known);
  std::size_t hint = 0;
  const double from = path.profile().at(o.time(), hint).s;
  EXPECT_EQ(o.factor(), 0.8) << "asking moves nothing";
  const Seen stop = drive(o, path, 0, 3000);
  EXPECT_EQ(stop.cycles * kPeriod, told.time);
  EXPECT_DOUBLE_EQ(path.profile().at(o.time(), hint).s - from, told.way);
}

TEST(PathOverride, GoesBackToTheStart) {
  const TimedPath path = some(2);
  PathOverride o(path, kLimits, kPeriod);
  o.begin(0.2 * path.duration(), 0);
  for (int i = 0; i < 20000 && o.time() > 0; ++i) o.advance(-0.5);
  EXPECT_EQ(o.time(), 0);
  EXPECT_TRUE(o.stands());
  o.advance(-0.5);
  EXPECT_TRUE(o.stands());
}

TEST(PathOverride, AllocatesNothing) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP();
  const TimedPath path = some(3);
  PathOverride o(path, kLimits, kPeriod);
  std::vector<double> q(6), v(6), a(6);
  test::RealtimeGuard guard;
  for (int cycle = 0; cycle < 5000; ++cycle) {
    o.advance(cycle / 700 % 2 ? 0.0 : 1.0);
    o.sample(q, v, a);
  }
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::timing::path_override_test
