#include "polyarm/timing/timing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/support/test_paths.hpp"

namespace polyarm::timing::timing_test {
namespace {

using test::blended_lines;
using test::cubic_spline;
using test::random_sines;
using test::random_spline;
using test::straight_line;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double even(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  double logarithmic(double low, double high) { return std::exp(even(std::log(low), std::log(high))); }
  std::size_t count(std::size_t low, std::size_t high) {
    return std::uniform_int_distribution<std::size_t>(low, high)(engine_);
  }

 private:
  std::mt19937_64 engine_;
};

std::vector<trajectory::MotionLimits> random_limits(std::size_t joints, Draw& draw, bool lopsided,
                                                    double spread = 4) {
  std::vector<trajectory::MotionLimits> out;
  for (std::size_t j = 0; j < joints; ++j) {
    trajectory::MotionLimits l = trajectory::MotionLimits::symmetric(
        draw.logarithmic(2 / spread, 2 * spread), draw.logarithmic(8 / spread, 8 * spread),
        draw.logarithmic(80 / spread, 80 * spread));
    if (lopsided) l.min_velocity *= draw.even(0.5, 1.5), l.min_acceleration *= draw.even(0.5, 1.5);
    out.push_back(l);
  }
  return out;
}

/// Highest value over limit of any joint at one place of the motion.
double use(const paths::Path& path, const PathMotion& m, std::span<const trajectory::MotionLimits> limits) {
  const std::size_t n = path.joints();
  std::vector<double> q(n), v(n), a(n), j(n);
  joints_on_path(path, m, q, v, a, j);
  double most = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const trajectory::MotionLimits& l = limits[i];
    most = std::max({most, v[i] / l.max_velocity, v[i] / l.min_velocity, a[i] / l.max_acceleration,
                     a[i] / l.min_acceleration, std::abs(j[i]) / l.max_jerk});
  }
  return most;
}

/// Highest use of a limit over the whole profile: `per_piece` times in each piece, and both sides of every
/// change of jerk; around the highest of each piece again, finer.
double most_used(const paths::Path& path, const SpeedProfile& profile,
                 std::span<const trajectory::MotionLimits> limits, int per_piece = 30) {
  double most = 0;
  const auto pieces = profile.pieces();
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const double begin = pieces[i].begin;
    const double length = (i + 1 < pieces.size() ? pieces[i + 1].begin : profile.duration()) - begin;
    const auto at = [&](double part) {
      const double x = part * length;
      const PathMotion& m = pieces[i].motion;
      return use(path,
                 {m.s + x * (m.speed + x * (m.acceleration / 2 + x * m.jerk / 6)),
                  m.speed + x * (m.acceleration + x * m.jerk / 2), m.acceleration + x * m.jerk, m.jerk},
                 limits);
    };
    double best = 0, where = 0;
    for (int k = 0; k <= per_piece; ++k) {
      const double part = double(k) / per_piece, here = at(part);
      if (here > best) best = here, where = part;
    }
    if (best > 0.999)
      for (int k = -8; k <= 8; ++k)
        best = std::max(best, at(std::clamp(where + k / (8.0 * per_piece), 0.0, 1.0)));
    most = std::max(most, best);
  }
  return most;
}

void expect_smooth(const SpeedProfile& profile, double length) {
  const auto pieces = profile.pieces();
  ASSERT_FALSE(pieces.empty());
  EXPECT_EQ(pieces.front().motion.s, 0);
  EXPECT_NEAR(profile.length(), length, 1e-12 * length);
  double top = 0, most = 0;
  for (const auto& p : pieces) {
    top = std::max(top, p.motion.speed), most = std::max(most, std::abs(p.motion.acceleration));
    EXPECT_GE(p.motion.speed, -1e-12 * (1 + top));
  }
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    const PathMotion& m = pieces[i - 1].motion;
    const double t = pieces[i].begin - pieces[i - 1].begin;
    EXPECT_NEAR(pieces[i].motion.s, m.s + t * (m.speed + t * (m.acceleration / 2 + t * m.jerk / 6)),
                1e-12 * length);
    EXPECT_NEAR(pieces[i].motion.speed, m.speed + t * (m.acceleration + t * m.jerk / 2), 1e-10 * top);
    EXPECT_NEAR(pieces[i].motion.acceleration, m.acceleration + t * m.jerk, 1e-10 * most);
  }
}

TEST(Timing, KeepsEveryLimitEverywhereOnSplines) {
  Draw draw(1);
  for (int c = 0; c < 60; ++c) {
    const std::size_t joints = draw.count(1, 7);
    const auto path = random_spline(joints, draw.count(3, 20), std::uint64_t(c));
    const auto limits = random_limits(joints, draw, c % 2);
    const Timing timing = time_path(*path, limits);
    expect_smooth(timing.profile, path->length());
    EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6) << c;
    EXPECT_LE(timing.excess, 1e-6);
  }
}

TEST(Timing, KeepsEveryLimitEverywhereOnSinesAndBlendedCorners) {
  Draw draw(2);
  for (int c = 0; c < 60; ++c) {
    const std::size_t joints = draw.count(1, 7);
    std::shared_ptr<const paths::Path> path;
    if (c % 2) {
      path = random_sines(joints, draw.logarithmic(0.01, 1000), std::uint64_t(c));
    } else {
      std::vector<std::vector<double>> points(draw.count(3, 8), std::vector<double>(joints + 1));
      for (auto& p : points)
        for (double& x : p) x = draw.even(-1, 1);
      path = blended_lines(points, draw.logarithmic(1e-4, 0.02));
    }
    const auto limits = random_limits(path->joints(), draw, c % 3 == 0);
    const Timing timing = time_path(*path, limits);
    expect_smooth(timing.profile, path->length());
    EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6) << c;
  }
}

TEST(Timing, KeepsLimitsThatLieFarApart) {
  Draw draw(3);
  for (int c = 0; c < 60; ++c) {
    const auto path = random_spline(6, draw.count(3, 10), std::uint64_t(c), draw.logarithmic(1e-6, 1e3));
    const auto limits = random_limits(6, draw, true, 100);
    const Timing timing = time_path(*path, limits);
    expect_smooth(timing.profile, path->length());
    EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6) << c;
  }
}

TEST(Timing, IsNoSlowerThanAFineGridByFivePercent) {
  Draw draw(4);
  for (int c = 0; c < 12; ++c) {
    const std::size_t joints = 6;
    std::vector<std::vector<double>> points(4, std::vector<double>(joints));
    for (auto& p : points)
      for (double& x : p) x = draw.even(-1, 1);
    const auto path = c % 3 == 0   ? random_spline(joints, 8, std::uint64_t(c))
                      : c % 3 == 1 ? random_sines(joints, 3, std::uint64_t(c))
                                   : blended_lines(points, draw.logarithmic(3e-3, 0.1));
    const auto limits = random_limits(joints, draw, c % 2);
    const double ours = time_path(*path, limits).profile.duration();
    double best = ours;
    for (const double fineness : {2.0, 4.0, 8.0}) {
      TimingOptions fine;
      fine.fineness = fineness;
      best = std::min(best, time_path(*path, limits, fine).profile.duration());
    }
    EXPECT_LE(ours, 1.05 * best) << c << " " << ours << " " << best;
  }
}

TEST(Timing, GivesALineTheMotionOfOneAxis) {
  Draw draw(5);
  for (int c = 0; c < 50; ++c) {
    std::vector<double> from(6), to(6);
    for (double& x : from) x = draw.even(-2, 2);
    for (double& x : to) x = draw.even(-2, 2);
    const auto limits = random_limits(6, draw, c % 2);
    const auto path = straight_line(from, to, draw.logarithmic(1e-3, 1e3));
    const Timing timing = time_path(*path, limits);
    trajectory::StateToState plan;
    std::vector<trajectory::MotionState> start(6), end(6);
    for (std::size_t j = 0; j < 6; ++j) start[j].position = from[j], end[j].position = to[j];
    ASSERT_EQ(plan.plan(start, end, limits, {.synchronization = trajectory::Synchronization::phase}),
              trajectory::MotionStatus::ok);
    ASSERT_TRUE(plan.straight());
    EXPECT_NEAR(timing.profile.duration(), plan.duration(), 1e-6 * plan.duration());
    EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6);
    expect_smooth(timing.profile, path->length());
  }
}

/// A line as a general path sees it: bent by too little to count, but not nothing.
TEST(Timing, ComesNearTheMotionOfOneAxisOnAnAlmostStraightPath) {
  const test::SinePath::Wave bent{1e-7, 3, 0.3, 0.8};
  for (const double length : {0.05, 0.5, 5.0}) {
    const test::SinePath path(length, std::vector<test::SinePath::Wave>(2, bent));
    const std::vector<trajectory::MotionLimits> limits(2, trajectory::MotionLimits::symmetric(1, 5, 50));
    trajectory::StateToState plan;
    const trajectory::MotionState from{}, to{0.8 * length, 0, 0};
    ASSERT_EQ(plan.plan({&from, 1}, {&to, 1}, {limits.data(), 1}), trajectory::MotionStatus::ok);
    const double ours = time_path(path, limits).profile.duration();
    EXPECT_LE(ours, 1.03 * plan.duration()) << length;
    EXPECT_GE(ours, (1 - 1e-5) * plan.duration());
  }
}

TEST(Timing, StartsAndEndsAtTheSpeedsGiven) {
  const auto path = random_spline(6, 8, 3);
  const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(2, 8, 100));
  TimingOptions options;
  options.start_speed = 0.3, options.end_speed = 0.2;
  const Timing timing = time_path(*path, limits, options);
  std::size_t hint = 0;
  EXPECT_NEAR(timing.profile.at(0, hint).speed, 0.3, 1e-9);
  EXPECT_NEAR(timing.profile.at(timing.profile.duration(), hint).speed, 0.2, 1e-9);
  EXPECT_NEAR(timing.profile.at(timing.profile.duration(), hint).acceleration, 0, 1e-9);
  EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6);
  EXPECT_LT(timing.profile.duration(), time_path(*path, limits).profile.duration());
}

TEST(Timing, SaysWhichLimitAnImpossibleStartSpeedBreaks) {
  const auto path = random_spline(6, 8, 3);
  const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(2, 8, 100));
  TimingOptions options;
  options.start_speed = 50;
  try {
    time_path(*path, limits, options);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "path-too-fast");
    EXPECT_NE(std::string(e.what()).find("joint"), std::string::npos) << e.what();
  }
}

/// The tool on a circle-like way beside one joint: x, y of radius r over s.
TEST(Timing, KeepsBoundsOnNorms) {
  Draw draw(6);
  for (int c = 0; c < 20; ++c) {
    const auto path = random_spline(6, 6, std::uint64_t(c));
    const auto tool = std::make_shared<test::SinePath>(
        path->length(),
        std::vector<test::SinePath::Wave>{{0.3, 2, 0, 0}, {0.3, 2, 1.57, 0}, {0.2, 1, 0, 0.1}});
    const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(3, 20, 300));
    const NormLimit norm{tool.get(), 0.25, draw.logarithmic(0.5, 5), draw.logarithmic(5, 100), "tool speed"};
    TimingOptions options;
    options.norms = {&norm, 1};
    const Timing timing = time_path(*path, limits, options);
    EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6);
    double most = 0;
    std::size_t hint = 0;
    std::vector<double> q(3), v(3), a(3), j(3);
    const int samples = int(timing.grid.size()) * 20;
    for (int i = 0; i <= samples; ++i) {
      joints_on_path(*tool, timing.profile.at(timing.profile.duration() * i / samples, hint), q, v, a, j);
      most = std::max({most, std::hypot(v[0], v[1], v[2]) / norm.max_velocity,
                       std::hypot(a[0], a[1], a[2]) / norm.max_acceleration,
                       std::hypot(j[0], j[1], j[2]) / norm.max_jerk});
    }
    EXPECT_LE(most, 1 + 1e-6) << c;
    EXPECT_GE(most, 0.98);
    EXPECT_TRUE(std::any_of(timing.active.begin(), timing.active.end(),
                            [](const ActiveLimit& l) { return l.row == 6; }));
  }
}

/// The highest and the lowest path speed between two places.
struct Speeds {
  double low = std::numeric_limits<double>::infinity(), high = 0;
};
Speeds speeds_between(const SpeedProfile& profile, double from, double to) {
  Speeds out;
  std::size_t hint = 0;
  for (int i = 0; i <= 20000; ++i) {
    const PathMotion m = profile.at(profile.duration() * i / 20000, hint);
    if (m.s < from || m.s > to) continue;
    out.low = std::min(out.low, m.speed), out.high = std::max(out.high, m.speed);
  }
  return out;
}

/// The way on a path as a row of its own, `factor` times as long before a place as behind it.
class WayOf final : public paths::Path {
 public:
  WayOf(const paths::Path& path, double place, double factor) : path_(path), place_(place), factor_(factor) {
    breaks_ = {0, place, path.length()};
  }
  std::size_t joints() const noexcept override { return 1; }
  double length() const noexcept override { return path_.length(); }
  std::span<const double> breaks() const noexcept override { return breaks_; }
  void at(double s, const paths::PathDerivatives& out) const noexcept override {
    if (!out.first.empty()) out.first[0] = s < place_ ? factor_ : 1;
    for (const auto& list : {out.second, out.third})
      if (!list.empty()) list[0] = 0;
  }

 private:
  const paths::Path& path_;
  double place_, factor_;
  std::vector<double> breaks_;
};

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(Timing, HoldsAStatedSpeedToATenthOfAPerMille) {
  Draw draw(7);
  for (int c = 0; c < 10; ++c) {
    std::vector<std::vector<double>> points(6, std::vector<double>(3));
    for (auto& p : points)
      for (double& x : p) x = draw.even(-1, 1);
    const auto path = blended_lines(points, 0.02);
    const std::vector<trajectory::MotionLimits> limits(3, trajectory::MotionLimits::symmetric(3, 12, 120));
    const WayOf way(*path, 0, 1);
    const NormLimit norm{&way, 0.1, kInfinite, kInfinite, "tool speed"};
    TimingOptions options;
    options.norms = {&norm, 1};
    const Timing timing = time_path(*path, limits, options);
    const Speeds speed = speeds_between(timing.profile, 0.05, path->length() - 0.05);
    EXPECT_LE(speed.high, 0.1 * (1 + 1e-6));
    EXPECT_GE(speeds_between(timing.profile, 0.05, path->breaks()[1] - 0.05).high, 0.1 * (1 - 1e-4)) << c;
    EXPECT_LE(timing.profile.duration(), path->length() / 0.1 * 1.01) << c;
  }
}

TEST(Timing, ReachesBothSpeedsWhereABoundJumps) {
  const auto path = blended_lines({{0, 0, 0}, {1, 0.2, 0}, {1, 1, 0.5}, {0, 1, 1}}, 0.02);
  const double place = path->breaks()[3];
  const std::vector<trajectory::MotionLimits> limits(3, trajectory::MotionLimits::symmetric(3, 12, 120));
  for (const bool slow_first : {true, false}) {
    const WayOf way(*path, place, slow_first ? 8.0 : 1.0 / 8);
    const NormLimit norm{&way, slow_first ? 0.4 : 0.05, kInfinite, kInfinite, "tool speed"};
    TimingOptions options;
    options.norms = {&norm, 1};
    const Timing timing = time_path(*path, limits, options);
    const Speeds before = speeds_between(timing.profile, 0.1, place - 0.1),
                 behind = speeds_between(timing.profile, place + 0.1, path->length() - 0.1);
    const Speeds &slow = slow_first ? before : behind, &fast = slow_first ? behind : before;
    EXPECT_LE(slow.high, 0.05 * (1 + 1e-6));
    EXPECT_GE(slow.low, 0.05 * (1 - 2e-3));
    EXPECT_LE(fast.high, 0.4 * (1 + 1e-6));
    EXPECT_GE(fast.high, 0.4 * (1 - 1e-3));
  }
}

/// Corners of a zigzag at which blends are wide; in the middle one may be tight.
std::shared_ptr<const paths::Path> zigzag(double tight) {
  std::vector<std::vector<double>> points;
  for (int i = 0; i <= 8; ++i) points.push_back({0.25 * i, i % 2 ? 0.5 : 0.0, 0.05 * i * i});
  if (tight <= 0) return blended_lines(points, 0.05);
  // The tight corner is a small jog in the middle of the fifth line.
  std::vector<double> middle(3), aside(3);
  for (std::size_t j = 0; j < 3; ++j) middle[j] = (points[4][j] + points[5][j]) / 2;
  aside = middle, aside[2] += tight;
  points.insert(points.begin() + 5, aside);
  return blended_lines(points, 0.05);
}

TEST(Timing, OneTightPlaceDoesNotSlowTheOthers) {
  const std::vector<trajectory::MotionLimits> limits(3, trajectory::MotionLimits::symmetric(3, 12, 120));
  const auto plain = zigzag(0), tight = zigzag(0.12);
  const Timing without = time_path(*plain, limits), with = time_path(*tight, limits);
  // The first three corners are the same on both paths, up to the middle of the line behind them.
  const double to = (plain->breaks()[6] + plain->breaks()[7]) / 2;
  ASSERT_DOUBLE_EQ(plain->breaks()[6], tight->breaks()[6]);
  EXPECT_NEAR(with.profile.time_at(to), without.profile.time_at(to), 2e-3 * without.profile.time_at(to));
  EXPECT_LE(most_used(*tight, with.profile, limits), 1 + 1e-6);
}

TEST(Timing, NodesDoNotMultiplyWithTightCorners) {
  Draw draw(8);
  for (const std::size_t corners : {10, 30}) {
    std::vector<std::vector<double>> points(corners + 2, std::vector<double>(6));
    for (auto& p : points)
      for (double& x : p) x = draw.even(-1, 1);
    const auto path = blended_lines(points, 2e-3);
    const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(3, 12, 120));
    const Timing timing = time_path(*path, limits);
    EXPECT_LE(timing.grid.size(), 50 * corners);
    EXPECT_LE(timing.iterations, 150);
    EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6);
  }
}

/// From rest to rest along straight lines.
double stop_and_go(const std::vector<std::vector<double>>& points,
                   std::span<const trajectory::MotionLimits> limits) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    sum += time_path(*straight_line(points[i], points[i + 1], 1), limits).profile.duration();
  return sum;
}

/// Within a ten-thousandth of a line speed falls by hundreds; a first guess may be far from what is possible.
TEST(Timing, PassesTinyBlendsNoSlowerThanWithAStopAtEachCorner) {
  for (const std::uint64_t seed : {3, 5, 7, 18, 32, 50, 53, 98, 213, 237}) {
    Draw draw(seed);
    const std::size_t joints = draw.count(2, 8);
    std::vector<std::vector<double>> points(draw.count(4, 8), std::vector<double>(joints));
    for (auto& p : points)
      for (double& x : p) x = draw.even(-1, 1);
    const auto path = blended_lines(points, draw.logarithmic(1e-5, 3e-4));
    const auto limits = random_limits(joints, draw, false);
    const Timing timing = time_path(*path, limits);
    EXPECT_LE(timing.profile.duration(), 1.04 * stop_and_go(points, limits)) << seed;
    EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6) << seed;
  }
}

/// Forth and nearly the same way back: in the middle of such a corner the path hardly moves.
TEST(Timing, PassesNearlyReversedBlendsWithoutManyNodes) {
  const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(3, 12, 120));
  for (const double aside : {1e-2, 1e-3, 1e-5}) {
    const std::vector<std::vector<double>> points{{0, 0, 0, 0, 0, 0},
                                                  {1, 0.5, -0.3, 0.2, 0.8, -1},
                                                  {0, aside, 0, -aside, 0, 0},
                                                  {0.3, 0.1, 1, 0, 0, 0.1}};
    for (const double cut : {1e-1, 1e-2, 1e-3}) {
      const auto path = blended_lines(points, cut);
      const Timing timing = time_path(*path, limits);
      EXPECT_LE(timing.grid.size(), 200u) << aside << " " << cut;
      EXPECT_LE(timing.profile.duration(), 1.02 * stop_and_go(points, limits)) << aside << " " << cut;
      EXPECT_LE(most_used(*path, timing.profile, limits), 1 + 1e-6) << aside << " " << cut;
    }
  }
}

TEST(Timing, NamesTheActiveLimitsAlongTheWholePath) {
  const auto path = random_spline(6, 10, 8);
  std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(2, 8, 100));
  limits[3] = trajectory::MotionLimits::symmetric(0.1, 50, 5000);
  const Timing timing = time_path(*path, limits);
  double at = 0, slow = 0;
  for (const ActiveLimit& l : timing.active) {
    EXPECT_EQ(l.from, at);
    EXPECT_GE(l.to, l.from);
    if (l.row == 3 && l.kind == LimitKind::velocity) slow += l.to - l.from;
    at = l.to;
  }
  EXPECT_EQ(at, path->length());
  EXPECT_GT(slow, 0.5 * path->length());
}

TEST(Timing, IsTheSameEveryTime) {
  const auto path = random_spline(6, 10, 8);
  const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(2, 8, 100));
  const Timing one = time_path(*path, limits), two = time_path(*path, limits);
  ASSERT_EQ(one.profile.pieces().size(), two.profile.pieces().size());
  EXPECT_EQ(one.profile.duration(), two.profile.duration());
  for (std::size_t i = 0; i < one.profile.pieces().size(); ++i)
    EXPECT_EQ(one.profile.pieces()[i].motion.jerk, two.profile.pieces()[i].motion.jerk);
}

TEST(Timing, RefusesWhatItCannotPlan) {
  const auto code = [](auto call) {
    try {
      call();
    } catch (const Error& e) {
      return e.problems().front().code;
    }
    return std::string("none");
  };
  const auto path = random_spline(2, 4, 1);
  std::vector<trajectory::MotionLimits> limits(2, trajectory::MotionLimits::symmetric(1, 1, 1));
  EXPECT_EQ(code([&] { time_path(*path, {limits.data(), 1}); }), "wrong-size");
  limits[1].max_jerk = 0;
  EXPECT_EQ(code([&] { time_path(*path, limits); }), "bad-limit");
  limits[1].max_jerk = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code([&] { time_path(*path, limits); }), "bad-limit");
  const test::SinePath bad(1, {{1, std::numeric_limits<double>::quiet_NaN(), 0, 0}, {1, 1, 0, 0}});
  EXPECT_EQ(code([&] { time_path(bad, std::vector<trajectory::MotionLimits>(2)); }), "bad-path");
}

}  // namespace
}  // namespace polyarm::timing::timing_test
