#include "polyarm/paths/joint_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "polyarm/paths/hermite.hpp"
#include "polyarm/paths/polynomial_path.hpp"
#include "tests/support/path_laws.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::paths::path_joint_test {
namespace {

using test::point_at;
using Values = std::vector<double>;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double even(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  std::size_t count(std::size_t low, std::size_t high) {
    return low + static_cast<std::size_t>(even(0, 1) * static_cast<double>(high - low + 1));
  }
  Values values(std::size_t n, double low, double high) {
    Values out(n);
    for (double& v : out) v = even(low, high);
    return out;
  }
  std::vector<JointWaypoint> waypoints(std::size_t joints, std::size_t count, double radius) {
    std::vector<JointWaypoint> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back({values(joints, -2, 2), radius, ""});
    return out;
  }

 private:
  std::mt19937_64 engine_;
};

double distance(const Values& a, const Values& b, const Values& weights = {}) {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j) {
    const double d = (weights.empty() ? 1.0 : weights[j]) * (b[j] - a[j]);
    sum += d * d;
  }
  return std::sqrt(sum);
}
/// From `q` to the line between `a` and `b`.
double to_line(const Values& q, const Values& a, const Values& b, const Values& w = {}) {
  double along = 0, square = 0;
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double weight = w.empty() ? 1.0 : w[j] * w[j];
    along += weight * (q[j] - a[j]) * (b[j] - a[j]);
    square += weight * (b[j] - a[j]) * (b[j] - a[j]);
  }
  const double t = std::clamp(along / square, 0.0, 1.0);
  Values foot(q.size());
  for (std::size_t j = 0; j < q.size(); ++j) foot[j] = a[j] + t * (b[j] - a[j]);
  return distance(q, foot, w);
}

TEST(Hermite, MeetsWhatIsGivenAtBothEnds) {
  const Jet<double> a{1, -2, 3, -4}, b{-0.5, 0.7, -9, 11};
  const double length = 0.37;
  const auto seven = hermite7(a, b, length);
  const auto five = hermite5(a, b, length);
  for (const auto& [tau, want] : {std::pair{0.0, a}, std::pair{1.0, b}}) {
    const Jet<double> x = polynomial_at(seven.data(), 8, tau, length),
                      y = polynomial_at(five.data(), 6, tau, length);
    EXPECT_NEAR(x.value, want.value, 1e-12);
    EXPECT_NEAR(x.first, want.first, 1e-10);
    EXPECT_NEAR(x.second, want.second, 1e-9);
    EXPECT_NEAR(x.third, want.third, 1e-7);
    EXPECT_NEAR(y.value, want.value, 1e-12);
    EXPECT_NEAR(y.first, want.first, 1e-10);
    EXPECT_NEAR(y.second, want.second, 1e-9);
  }
}

TEST(JointLines, AreContinuousAndKnowTheirDerivatives) {
  Draw draw(1);
  for (int k = 0; k < 300; ++k) {
    const std::size_t joints = draw.count(1, 9);
    JointPathOptions options;
    if (k % 2) options.weights = draw.values(joints, 0.2, 5);
    const auto path = joint_lines(draw.waypoints(joints, draw.count(2, 12), draw.even(0.01, 3)), options);
    for (const auto& section : path.sections) {
      test::expect_continuous(*section);
      test::expect_derivatives(*section);
    }
  }
}

TEST(JointLines, StayWithinTheRadiusAndElsewhereOnTheLines) {
  Draw draw(2);
  for (int k = 0; k < 200; ++k) {
    const std::size_t joints = draw.count(2, 7);
    const Values weights = k % 2 ? draw.values(joints, 0.2, 5) : Values{};
    const double radius = draw.even(0.01, 3);
    const auto w = draw.waypoints(joints, draw.count(3, 8), radius);
    const auto made = joint_lines(w, {weights, {}});
    ASSERT_EQ(made.sections.size(), 1u);
    const Path& path = *made.sections.front();
    std::size_t shrunk = 0;
    for (std::size_t i = 1; i + 1 < w.size(); ++i)
      shrunk +=
          radius > std::min(distance(w[i - 1].q, w[i].q, weights), distance(w[i].q, w[i + 1].q, weights)) / 2;
    EXPECT_EQ(made.warnings.size(), shrunk);
    for (int n = 0; n <= 2000; ++n) {
      const Values q = point_at(path, path.length() * n / 2000).q;
      double corner = 1e9, line = 1e9;
      for (std::size_t i = 1; i + 1 < w.size(); ++i) corner = std::min(corner, distance(q, w[i].q, weights));
      for (std::size_t i = 0; i + 1 < w.size(); ++i)
        line = std::min(line, to_line(q, w[i].q, w[i + 1].q, weights));
      if (line > 1e-12) {
        ASSERT_LE(corner, radius * (1 + 1e-12));
      }
      ASSERT_LE(line, radius * 3 / 8 + 1e-12);
    }
  }
}

TEST(JointLines, PassTheWaypointAtThreeEighthsOfTheRadiusTimesTheSineOfHalfTheTurn) {
  Draw draw(8);
  for (int k = 0; k < 100; ++k) {
    const double radius = draw.even(0.01, 3);
    const auto w = draw.waypoints(draw.count(2, 7), 3, radius);
    const auto made = joint_lines(w);
    const Path& path = *made.sections.front();
    const double before = distance(w[0].q, w[1].q), after = distance(w[1].q, w[2].q);
    const double d = std::min({radius, before / 2, after / 2}), across = distance(w[0].q, w[2].q);
    const double cosine = (across * across - before * before - after * after) / (2 * before * after);
    double nearest = radius;
    for (int n = 0; n <= 20000; ++n)
      nearest = std::min(nearest, distance(point_at(path, path.length() * n / 20000).q, w[1].q));
    ASSERT_NEAR(nearest, 0.375 * d * std::sqrt((1 - cosine) / 2), 1e-6);
  }
}

TEST(JointLines, ShrinkARadiusToHalfOfTheShorterWayAndNameTheWaypoint) {
  const auto made = joint_lines(std::vector<JointWaypoint>{
      {{0, 0}, 0, ""}, {{1, 0}, 0.6, "above the box"}, {{1, 0.4}, 0.1, ""}, {{3, 0.4}, 0, ""}});
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_EQ(made.warnings[0].code, "blend-shrunk");
  EXPECT_EQ(made.warnings[0].severity, Severity::warning);
  EXPECT_NE(made.warnings[0].what.find("above the box"), std::string::npos) << made.warnings[0].what;
  EXPECT_NE(made.warnings[0].what.find("0.2"), std::string::npos) << made.warnings[0].what;
  ASSERT_EQ(made.sections.size(), 1u);
  const auto breaks = made.sections[0]->breaks();  // line, corner, line, corner, line
  ASSERT_EQ(breaks.size(), 6u);
  EXPECT_NEAR(breaks[1], 0.8, 1e-12);
  EXPECT_NEAR(breaks[2], 1.2, 1e-12);
}

TEST(JointLines, StopExactlyAtAWaypointWithoutRadius) {
  const auto made = joint_lines(std::vector<JointWaypoint>{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{1, 3}}});
  ASSERT_EQ(made.sections.size(), 2u);  // the third waypoint is on the way
  EXPECT_EQ(point_at(*made.sections[0], 1).q, (Values{1, 0}));
  EXPECT_EQ(point_at(*made.sections[1], 0).q, (Values{1, 0}));
  EXPECT_NEAR(made.sections[1]->length(), 3, 1e-12);
  EXPECT_EQ(made.sections[1]->breaks().size(), 2u);
}

TEST(JointLines, CountRepeatedWaypointsOnceAndStopWhereTheyTurnStraightBack) {
  const auto made = joint_lines(
      std::vector<JointWaypoint>{{{0, 0}}, {{0, 0}}, {{1, 0}, 0.2}, {{1, 0}, 0.1}, {{0, 0}}, {{0, 0}}});
  ASSERT_EQ(made.warnings.size(), 4u);
  EXPECT_NE(made.warnings[3].what.find("turns straight back"), std::string::npos);
  ASSERT_EQ(made.sections.size(), 2u);
  EXPECT_NEAR(made.sections[0]->length(), 1, 1e-12);
  EXPECT_EQ(point_at(*made.sections[0], 1).q, (Values{1, 0}));
  EXPECT_EQ(point_at(*made.sections[1], 1).q, (Values{0, 0}));
}

TEST(JointLines, OfOnePlaceHaveNoLength) {
  for (const std::size_t n : {1, 3}) {
    const auto made = joint_lines(std::vector<JointWaypoint>(n, {{0.5, -1}}));
    ASSERT_EQ(made.sections.size(), 1u);
    EXPECT_EQ(made.sections[0]->length(), 0);
    EXPECT_EQ(point_at(*made.sections[0], 1).q, (Values{0.5, -1}));
    EXPECT_EQ(point_at(*made.sections[0], 1).first, (Values{0, 0}));
  }
}

TEST(JointLines, EndExactlyAtTheLastWaypointHoweverNear) {
  const auto tiny = joint_lines(std::vector<JointWaypoint>{{{1, 2}}, {{1, 2 + 1e-11}}});
  ASSERT_EQ(tiny.sections.size(), 1u);
  EXPECT_EQ(point_at(*tiny.sections[0], 1).q, (Values{1, 2 + 1e-11}));
  const auto twice = joint_lines(std::vector<JointWaypoint>{{{0, 0}}, {{1, 2}}, {{1, 2 + 1e-11}}});
  EXPECT_EQ(twice.warnings.size(), 1u);
  EXPECT_EQ(point_at(*twice.sections[0], 9).q, (Values{1, 2 + 1e-11}));
}

/// A flat arm of two links, which makes a radius at the TCP another one in joints.
TEST(JointLines, KeepARadiusAtTheTcp) {
  const auto tcp = [](std::span<const double> q) {
    return std::pair{0.7 * std::cos(q[0]) + 0.5 * std::cos(q[0] + q[1]),
                     0.7 * std::sin(q[0]) + 0.5 * std::sin(q[0] + q[1])};
  };
  JointPathOptions options;
  options.tcp_distance = [&](std::span<const double> a, std::span<const double> b) {
    const auto p = tcp(a), r = tcp(b);
    return std::hypot(p.first - r.first, p.second - r.second);
  };
  Draw draw(3);
  int tight = 0;
  for (int k = 0; k < 200; ++k) {
    const double radius = draw.even(0.005, 0.2);
    const auto w = draw.waypoints(2, 3, radius);
    const auto made = joint_lines(w, options);
    const Path& path = *made.sections.front();
    double furthest = 0;
    for (int n = 0; n <= 2000; ++n) {
      const Values q = point_at(path, path.length() * n / 2000).q;
      if (std::min(to_line(q, w[0].q, w[1].q), to_line(q, w[1].q, w[2].q)) < 1e-12) continue;
      furthest = std::max(furthest, options.tcp_distance(q, w[1].q));
    }
    ASSERT_LE(furthest, radius);
    tight += made.warnings.empty() && furthest > 0.9 * radius;
  }
  EXPECT_GT(tight, 100);
}

TEST(JointSpline, PassesEveryWaypointAtNearlyConstantRateWithoutWildOvershoot) {
  Draw draw(4);
  double slowest = 1e9, fastest = 0, overshoot = 0, lopsided = 0;
  for (int k = 0; k < 300; ++k) {
    const std::size_t joints = draw.count(2, 7);
    auto w = draw.waypoints(joints, draw.count(2, 12), 0);
    const bool near_pair = k % 3 == 0;  // two waypoints close together between far ones
    if (near_pair && w.size() > 3)
      for (std::size_t j = 0; j < joints; ++j) w[2].q[j] = w[1].q[j] + 0.02 * (w[2].q[j] - w[1].q[j]);
    const auto made = joint_spline(w);
    ASSERT_EQ(made.sections.size(), 1u);
    const Path& path = *made.sections[0];
    test::expect_continuous(path);
    test::expect_derivatives(path);
    const auto knots = path.breaks();
    ASSERT_EQ(knots.size(), w.size());
    for (std::size_t i = 0; i < w.size(); ++i) ASSERT_LE(distance(point_at(path, knots[i]).q, w[i].q), 1e-12);
    for (std::size_t i = 0; i + 1 < w.size(); ++i)
      for (int n = 0; n <= 100; ++n) {
        const auto at = point_at(path, knots[i] + (knots[i + 1] - knots[i]) * n / 100);
        const double rate = distance(at.first, Values(joints, 0.0));
        slowest = std::min(slowest, rate);
        fastest = std::max(fastest, rate);
        const double out = to_line(at.q, w[i].q, w[i + 1].q) / distance(w[i].q, w[i + 1].q);
        double& most = near_pair ? lopsided : overshoot;
        most = std::max(most, out);
      }
  }
  std::printf("rate %.3f to %.3f, overshoot %.3f of a chord, %.3f beside a short one\n", slowest, fastest,
              overshoot, lopsided);
  EXPECT_LT(fastest, 2);
  EXPECT_LT(overshoot, 0.5);
  EXPECT_LT(lopsided, 1);
}

TEST(JointSpline, OfTwoWaypointsIsALine) {
  const auto made = joint_spline(std::vector<JointWaypoint>{{{0, 1}}, {{3, 5}}});
  const auto at = point_at(*made.sections[0], 2.5);
  EXPECT_NEAR(at.q[0], 1.5, 1e-12);
  EXPECT_NEAR(at.q[1], 3, 1e-12);
  EXPECT_NEAR(at.first[0], 0.6, 1e-12);
}

TEST(JointPaths, TellEverythingThatIsWrong) {
  EXPECT_THROW(joint_lines({}), Error);
  try {
    joint_lines(std::vector<JointWaypoint>{{{0, 0}}, {{0}, 0, "pick"}, {{NAN, 0}, -1}});
    FAIL();
  } catch (const Error& e) {
    ASSERT_EQ(e.problems().size(), 3u) << e.what();
    EXPECT_NE(e.problems()[0].what.find("pick"), std::string::npos);
  }
  EXPECT_THROW(joint_spline(std::vector<JointWaypoint>{{{0, 0}}, {{0, 1}}}, {{1.0}, {}}), Error);
  EXPECT_THROW(joint_lines(std::vector<JointWaypoint>{{{0, 0}}, {{0, 1}}}, {{1.0, 0.0}, {}}), Error);
}

TEST(JointPaths, AreTheSameEveryTimeAndAllocateNothingWhenAsked) {
  Draw one(5), other(5);
  const auto a = joint_lines(one.waypoints(6, 20, 0.3)), b = joint_lines(other.waypoints(6, 20, 0.3));
  const Path &p = *a.sections[0], &r = *b.sections[0];
  ASSERT_EQ(p.length(), r.length());
  Values x(6), y(6), d1(6), d2(6), d3(6);
  test::RealtimeGuard guard;
  bool same = true;
  for (int n = -10; n < 2010; ++n) {
    p.at(p.length() * n / 2000, {x, d1, d2, d3});
    r.at(p.length() * n / 2000, {y, {}, {}, {}});
    same &= x == y;
  }
  EXPECT_EQ(guard.violations(), "");
  EXPECT_TRUE(same);
}

}  // namespace
}  // namespace polyarm::paths::path_joint_test
