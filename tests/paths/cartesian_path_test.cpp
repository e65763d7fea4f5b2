#include "polyarm/paths/cartesian_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/realtime_guard.hpp"

namespace polyarm::paths::path_cartesian_test {
namespace {

constexpr double kPi = std::numbers::pi;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double even(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vec(double size) { return {even(-size, size), even(-size, size), even(-size, size)}; }
  Quaternion rotation() { return normalized(Quaternion{even(-1, 1), even(-1, 1), even(-1, 1), even(-1, 1)}); }
  Pose pose() { return {vec(0.5), rotation()}; }
  ArcOrientation orientation() { return static_cast<ArcOrientation>(even(0, 2.999)); }

 private:
  std::mt19937_64 engine_;
};

/// Lines, arcs, circles, splines and turns, of any radius.
CartesianPathBuilder random_path(Draw& draw, int segments, double radius) {
  CartesianPathBuilder path(draw.pose());
  for (int i = 0; i < segments; ++i) {
    const Corner corner{radius * draw.even(0.2, 1), ""};
    const double kind = draw.even(0, 6);
    if (kind < 2)
      path.line(draw.pose(), corner);
    else if (kind < 3)
      path.arc(draw.vec(0.5), draw.pose(), draw.orientation(), corner);
    else if (kind < 4)
      path.arc_about(draw.vec(0.5), draw.vec(1), draw.even(-4, 4), draw.orientation(), corner,
                     draw.rotation());
    else if (kind < 5)
      path.circle(draw.vec(0.5), draw.vec(0.5), draw.orientation(), corner);
    else {
      Pose a = draw.pose(), b = a, c = a;
      b.position = b.position + draw.vec(0.3);
      b.rotation = b.rotation * exponential(draw.vec(1));
      c.position = c.position + draw.vec(0.3);
      c.rotation = c.rotation * exponential(draw.vec(1));
      path.line(a, corner).spline(std::vector{b, c, draw.even(0, 1) < 0.5 ? a : b}, corner);
    }
  }
  return path;
}

double apart(const Quaternion& a, const Quaternion& b) {
  return angle_between(a, b);
}

void expect_near(const Vec3& a, const Vec3& b, double tolerance, const char* what, double s) {
  ASSERT_LE(norm(a - b), tolerance) << what << " at " << s << ": " << a.x << " " << a.y << " " << a.z
                                    << " for " << b.x << " " << b.y << " " << b.z;
}

void expect_derivatives(const CartesianPath& path) {
  const auto breaks = path.breaks();
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double length = breaks[i + 1] - breaks[i], h = 2e-4 * length;
    for (const double share : {0.05, 0.3, 0.62, 0.95}) {
      const double s = breaks[i] + share * length;
      const PoseDerivatives a = path.at(s - h), at = path.at(s), b = path.at(s + h);
      // What the derivatives of this piece are about, in units of its length.
      double size = 1e-3;
      for (int n = 0; n < 3; ++n)
        for (const auto& of : {at.linear, at.angular})
          size = std::max(size, norm(of[static_cast<std::size_t>(n)]) * std::pow(length, n + 1));
      const double tolerance = 3e-6 * size;
      const auto slope = [&](const Vec3& low, const Vec3& high) { return length / (2 * h) * (high - low); };
      expect_near(slope(a.pose.position, b.pose.position), length * at.linear[0], tolerance, "velocity", s);
      const Quaternion turned = b.pose.rotation * inverse(a.pose.rotation);
      expect_near(length / (2 * h) * to_rotation_vector(turned), length * at.angular[0], tolerance, "turning",
                  s);
      double scale = length;
      for (std::size_t n = 0; n < 2; ++n) {
        expect_near(scale * slope(a.linear[n], b.linear[n]), scale * length * at.linear[n + 1], tolerance,
                    "linear", s);
        expect_near(scale * slope(a.angular[n], b.angular[n]), scale * length * at.angular[n + 1], tolerance,
                    "angular", s);
        scale *= length;
      }
      ASSERT_NEAR(norm({at.pose.rotation.x, at.pose.rotation.y, at.pose.rotation.z}) *
                          norm({at.pose.rotation.x, at.pose.rotation.y, at.pose.rotation.z}) +
                      at.pose.rotation.w * at.pose.rotation.w,
                  1, 1e-12);
    }
  }
}

/// Up to the second derivative of position and the first of the angular velocity.
void expect_continuous(const CartesianPath& path) {
  const auto breaks = path.breaks();
  ASSERT_EQ(breaks.front(), 0);
  for (std::size_t i = 1; i + 1 < breaks.size(); ++i) {
    const PoseDerivatives a = path.on_piece(i - 1, breaks[i]), b = path.on_piece(i, breaks[i]);
    ASSERT_GT(breaks[i], breaks[i - 1]);
    ASSERT_LE(norm(a.pose.position - b.pose.position), 1e-12);
    ASSERT_LE(apart(a.pose.rotation, b.pose.rotation), 1e-11);
    for (std::size_t n = 0; n < 2; ++n) {
      const double length = std::min(breaks[i] - breaks[i - 1], breaks[i + 1] - breaks[i]);
      const double tolerance = 1e-9 * std::max(1.0, 1 / std::pow(length, static_cast<double>(n) + 1));
      expect_near(a.linear[n], b.linear[n], tolerance, "linear", breaks[i]);
      expect_near(a.angular[n], b.angular[n], tolerance, "angular", breaks[i]);
    }
  }
}

TEST(Rotations, OfAPolynomialVectorTurnAsDifferencesSay) {
  Draw draw(1);
  for (int k = 0; k < 1000; ++k) {
    const double size = k % 3 == 0 ? 1e-3 : 2;
    const Jet<Vec3> start{draw.vec(size), draw.vec(1), draw.vec(1), draw.vec(1)};
    const auto at = [&](double t) {
      return Jet<Vec3>{start.value + t * start.first + t * t / 2 * start.second + t * t * t / 6 * start.third,
                       start.first + t * start.second + t * t / 2 * start.third,
                       start.second + t * start.third, start.third};
    };
    const double h = 1e-4;
    const BodyRate rate = body_rate(start), before = body_rate(at(-h)), after = body_rate(at(h));
    const Vec3 turned = to_rotation_vector(inverse(exponential(at(-h).value)) * exponential(at(h).value));
    expect_near(1 / (2 * h) * turned, rate.value, 1e-6, "rate", k);
    expect_near(1 / (2 * h) * (after.value - before.value), rate.first, 1e-6, "first", k);
    expect_near(1 / (2 * h) * (after.first - before.first), rate.second, 1e-6, "second", k);
    if (norm(start.value) > 3.1) continue;
    const Jet<Vec3> back = rotation_vector(exponential(start.value), rate);
    expect_near(back.value, start.value, 1e-12, "vector", k);
    expect_near(back.first, start.first, 1e-10, "vector's rate", k);
    expect_near(back.second, start.second, 1e-10, "vector's second", k);
  }
}

TEST(CartesianPaths, AreContinuousAndKnowTheirDerivatives) {
  Draw draw(2);
  std::size_t joined = 0;
  for (int k = 0; k < 400; ++k) {
    const auto made = random_path(draw, 6, draw.even(0.005, 0.3)).build();
    for (const CartesianPath& path : made.sections) {
      joined += path.pieces();
      expect_continuous(path);
      expect_derivatives(path);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  EXPECT_GT(joined, 4000u);
}

/// What is left of a path when its corners are not rounded: to which every rounded path is compared.
double to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 way = b - a;
  const double t = std::clamp(dot(p - a, way) / dot(way, way), 0.0, 1.0);
  return norm(p - (a + t * way));
}

TEST(CartesianPaths, OfLinesLeaveThemOnlyWithinTheRadius) {
  Draw draw(3);
  for (int k = 0; k < 200; ++k) {
    const double radius = draw.even(0.001, 0.4);
    std::vector<Pose> poses{draw.pose()};
    CartesianPathBuilder builder(poses[0]);
    for (int i = 0; i < 5; ++i) {
      poses.push_back(draw.pose());
      builder.line(poses.back(), {radius, ""});
    }
    const auto made = builder.build();
    ASSERT_EQ(made.sections.size(), 1u);
    const CartesianPath& path = made.sections[0];
    for (int n = 0; n <= 2000; ++n) {
      const Pose at = path.at(path.length() * n / 2000).pose;
      double line = 1, corner = 1, turn = 4;
      for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
        const double off = to_segment(at.position, poses[i].position, poses[i + 1].position);
        line = std::min(line, off);
        if (off < 1e-12) {  // slerp, there
          const double share =
              norm(at.position - poses[i].position) / norm(poses[i + 1].position - poses[i].position);
          const Vec3 all = to_rotation_vector(inverse(poses[i].rotation) * poses[i + 1].rotation);
          turn = std::min(turn, apart(at.rotation, poses[i].rotation * exponential(share * all)));
        }
      }
      for (std::size_t i = 1; i + 1 < poses.size(); ++i)
        corner = std::min(corner, norm(at.position - poses[i].position));
      if (line > 1e-12) {
        ASSERT_LE(corner, radius * (1 + 1e-12));
      } else if (corner > radius) {
        ASSERT_LE(turn, 1e-9);
      }
      ASSERT_LE(line, 0.375 * radius + 1e-12);
    }
  }
}

TEST(CartesianPaths, LeaveAnySegmentOnlyWithinTheRadiusOfACorner) {
  Draw draw(4);
  double tightest = 0;
  for (int k = 0; k < 200; ++k) {
    const double radius = draw.even(0.002, 0.2);
    const Pose start = draw.pose(), first = draw.pose(), second = draw.pose();
    const Vec3 via = draw.vec(0.5);
    const auto orientation = draw.orientation();
    const auto with = [&](double r) {
      CartesianPathBuilder builder(start);
      return builder.line(first, {r, "first"})
          .arc(via, second, orientation, {r, "second"})
          .line(start)
          .build();
    };
    const auto sharp = with(0), rounded = with(radius);
    ASSERT_EQ(sharp.sections.size(), 3u);
    ASSERT_EQ(rounded.sections.size(), 1u);
    const CartesianPath& path = rounded.sections[0];
    const Vec3 center = [&] {
      const PoseDerivatives at = sharp.sections[1].at(0);
      return at.pose.position + 1 / dot(at.linear[1], at.linear[1]) * at.linear[1];
    }();
    const double arc = norm(via - center);
    const Vec3 normal = normalized(cross(first.position - center, via - center));
    for (int n = 0; n <= 1000; ++n) {
      const Vec3 p = path.at(path.length() * n / 1000).pose.position;
      const double off = std::min({to_segment(p, start.position, first.position),
                                   to_segment(p, second.position, start.position),
                                   std::hypot(dot(p - center, normal), norm(p - center) - arc)});
      const double corner = std::min(norm(p - first.position), norm(p - second.position));
      ASSERT_TRUE(off <= 1e-12 * (1 + arc) || corner <= radius * (1 + 1e-9))
          << off << " " << corner << " " << radius;
      if (off > 1e-9) tightest = std::max(tightest, off / radius);
    }
  }
  std::printf("largest distance of a rounded corner from its segments: %.3f of the radius\n", tightest);
  EXPECT_LT(tightest, 1);
}

TEST(CartesianPaths, ShrinkRadiiAndNameTheWaypoint) {
  const Quaternion r{};
  auto made = CartesianPathBuilder({{0, 0, 0}, r})
                  .line({{1, 0, 0}, r}, {0.3, "above the box"})
                  .line({{1, 0.4, 0}, r}, {0.1, ""})
                  .line({{0, 0.4, 0}, r})
                  .build();
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_EQ(made.warnings[0].code, "blend-shrunk");
  EXPECT_NE(made.warnings[0].what.find("0.3 m at above the box is shrunk to 0.2 m"), std::string::npos)
      << made.warnings[0].what;
  EXPECT_NEAR(made.sections[0].breaks()[1], 0.8, 1e-12);
  // An arc of 2 cm has no corner of 10 cm.
  made = CartesianPathBuilder({{0, 0, 0}, r})
             .line({{1, 0, 0}, r}, {0.1, "edge"})
             .arc_about({1, 0.02, 0}, {0, 1, 1}, 6, ArcOrientation::fixed)
             .build();
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_NE(made.warnings[0].what.find("edge"), std::string::npos);
  EXPECT_EQ(made.sections.size(), 1u);
}

TEST(CartesianPaths, StopOnlyWhereTheyHaveTo) {
  const Quaternion r{};
  const auto made = CartesianPathBuilder({{0, 0, 0}, r})
                        .line({{1, 0, 0}, r})
                        .line({{2, 0, 0}, r})                                             // goes on
                        .arc_about({2, 1, 0}, {0, 0, 1}, kPi / 2, ArcOrientation::fixed)  // tangent, but bent
                        .line({{3, 2, 0}, r})
                        .build();
  ASSERT_EQ(made.sections.size(), 3u);
  EXPECT_NEAR(made.sections[0].length(), 2, 1e-12);
  EXPECT_NEAR(made.sections[1].length(), kPi / 2, 1e-12);
  EXPECT_LE(norm(made.sections[2].at(9).pose.position - Vec3{3, 2, 0}), 1e-12);
  // The same with a radius at the tangent points: one path, within 1 cm of the sharp one.
  const auto round = CartesianPathBuilder({{0, 0, 0}, r})
                         .line({{2, 0, 0}, r}, {0.1, ""})
                         .arc_about({2, 1, 0}, {0, 0, 1}, kPi / 2, ArcOrientation::tangent, {0.1, ""})
                         .line({{3, 2, 0}, r})
                         .build();
  EXPECT_EQ(round.sections.size(), 1u);
  EXPECT_TRUE(round.warnings.empty());
}

TEST(CartesianPaths, TurnOnArcsAsTold) {
  const Pose start{{1, 0, 0}, from_axis_angle({0, 0, 1}, kPi / 2)};  // x along the tangent
  const Pose end{{0, 1, 0}, from_axis_angle({1, 0, 0}, 1)};
  const Vec3 via{std::sqrt(0.5), std::sqrt(0.5), 0};
  const auto along = [&](ArcOrientation o) {
    return CartesianPathBuilder(start).arc(via, end, o).build().sections[0];
  };
  const auto fixed = along(ArcOrientation::fixed), mixed = along(ArcOrientation::interpolated),
             tangent = along(ArcOrientation::tangent);
  for (const auto* path : {&fixed, &mixed, &tangent}) {
    EXPECT_NEAR(path->length(), kPi / 2, 1e-12);
    EXPECT_LE(norm(path->at(9).pose.position - end.position), 1e-12);
    for (int n = 0; n <= 100; ++n) {
      const Vec3 p = path->at(path->length() * n / 100).pose.position;
      ASSERT_NEAR(norm(p), 1, 1e-12);
      ASSERT_NEAR(p.z, 0, 1e-12);
    }
  }
  EXPECT_LE(apart(fixed.at(1).pose.rotation, start.rotation), 1e-12);
  EXPECT_LE(apart(mixed.at(9).pose.rotation, end.rotation), 1e-12);
  for (const double s : {0.0, 0.7, kPi / 2}) {
    const auto at = tangent.at(s);
    EXPECT_LE(norm(at.pose.rotation * Vec3{1, 0, 0} - at.linear[0]), 1e-12);
  }
}

TEST(CartesianPaths, CloseACircle) {
  Draw draw(5);
  for (int k = 0; k < 50; ++k) {
    const Pose start = draw.pose();
    const Vec3 a = draw.vec(0.5), b = draw.vec(0.5);
    const auto made = CartesianPathBuilder(start).circle(a, b, draw.orientation()).build();
    const CartesianPath& path = made.sections[0];
    EXPECT_LE(norm(path.at(path.length()).pose.position - start.position), 1e-11);
    EXPECT_LE(apart(path.at(path.length()).pose.rotation, start.rotation), 1e-11);
    double to_a = 1, to_b = 1, s_a = 0, s_b = 0;
    for (int n = 0; n <= 20000; ++n) {
      const double s = path.length() * n / 20000;
      const Vec3 p = path.at(s).pose.position;
      if (norm(p - a) < to_a) to_a = norm(p - a), s_a = s;
      if (norm(p - b) < to_b) to_b = norm(p - b), s_b = s;
    }
    EXPECT_LE(std::max(to_a, to_b), path.length() / 20000);
    EXPECT_LT(s_a, s_b);
  }
}

TEST(CartesianPaths, TurnOnTheSpotInRadiansAndAnglesOfSplinesDoNotRunWild) {
  const Pose a{{0.1, 0.2, 0.3}, {}}, b{{0.1, 0.2, 0.3}, from_axis_angle({0, 1, 0}, 2)},
      c{{0.5, 0.2, 0.3}, b.rotation};
  const auto made = CartesianPathBuilder(a).line(b, {0.05, ""}).line(c).build();
  ASSERT_EQ(made.sections.size(), 1u);
  EXPECT_NEAR(made.sections[0].length(), 2.4, 1e-12);
  expect_continuous(made.sections[0]);
  Draw draw(6);
  double fastest = 0, wild = 0;
  for (int k = 0; k < 200; ++k) {
    std::vector<Pose> poses{draw.pose()};
    for (int i = 0; i < 6; ++i) {
      Pose next{draw.vec(0.5), poses.back().rotation * exponential(draw.vec(1.2))};
      poses.push_back(next);
    }
    const auto spline = CartesianPathBuilder(poses[0]).spline(std::span(poses).subspan(1)).build();
    const CartesianPath& path = spline.sections[0];
    ASSERT_EQ(path.pieces(), 6u);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      ASSERT_LE(norm(path.at(path.breaks()[i]).pose.position - poses[i].position), 1e-12);
      ASSERT_LE(apart(path.at(path.breaks()[i]).pose.rotation, poses[i].rotation), 1e-11);
    }
    for (int n = 0; n <= 600; ++n) {
      const auto at = path.at(path.length() * n / 600);
      fastest = std::max(fastest, norm(at.linear[0]));
      const auto after =
          std::upper_bound(path.breaks().begin() + 1, path.breaks().end() - 1, path.length() * n / 600);
      const auto i = static_cast<std::size_t>(after - path.breaks().begin()) - 1;
      const double turn = apart(poses[i].rotation, poses[i + 1].rotation);
      const double back =
          apart(poses[i].rotation, at.pose.rotation) + apart(at.pose.rotation, poses[i + 1].rotation);
      wild = std::max(wild, back - turn);
    }
  }
  std::printf("splines: at most %.2f m per unit, %.2f rad of detour between two poses\n", fastest, wild);
  EXPECT_LT(fastest, 2);
  EXPECT_LT(wild, 1);
}

TEST(CartesianPaths, TellEverythingThatIsWrong) {
  const Quaternion r{};
  CartesianPathBuilder builder({{0, 0, 0}, r});
  builder.line({{NAN, 0, 0}, r}).line({{1, 0, 0}, {0, 0, 0, 0}}).line({{1, 0, 0}, r}, {-1, "here"});
  builder.arc({0.5, 0, 0}, {{1, 0, 0}, r}, ArcOrientation::fixed)
      .circle({1, 0, 0}, {1, 0, 0}, ArcOrientation::fixed);
  builder.arc_about({0, 0, 1}, {0, 0, 1}, 1, ArcOrientation::fixed)
      .arc_about({1, 0, 0}, {}, 1, ArcOrientation::fixed);
  builder.spline({});
  try {
    builder.build();
    FAIL();
  } catch (const Error& e) {
    std::vector<std::string> codes;
    for (const Problem& p : e.problems()) codes.push_back(p.code);
    EXPECT_EQ(codes, (std::vector<std::string>{"bad-number", "bad-number", "bad-radius", "no-arc", "no-arc",
                                               "no-arc", "no-axis", "no-waypoints"}))
        << e.what();
    EXPECT_NE(std::string(e.what()).find("here"), std::string::npos);
  }
  const auto still = CartesianPathBuilder({{1, 2, 3}, r}).line({{1, 2, 3}, r}).build();
  EXPECT_EQ(still.warnings.size(), 1u);
  EXPECT_EQ(still.sections[0].length(), 0);
  EXPECT_EQ(still.sections[0].at(1).pose.position, (Vec3{1, 2, 3}));
}

TEST(CartesianPaths, AreTheSameEveryTimeAndAllocateNothingWhenAsked) {
  Draw one(7), other(7);
  const auto a = random_path(one, 10, 0.05).build(), b = random_path(other, 10, 0.05).build();
  const CartesianPath &p = a.sections[0], &r = b.sections[0];
  ASSERT_EQ(p.length(), r.length());
  bool same = true;
  test::RealtimeGuard guard;
  for (int n = -5; n < 1005; ++n)
    same &= p.at(p.length() * n / 1000).pose == r.at(p.length() * n / 1000).pose;
  EXPECT_EQ(guard.violations(), "");
  EXPECT_TRUE(same);
}

}  // namespace
}  // namespace polyarm::paths::path_cartesian_test
