#include "polyarm/trajectory/splines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace polyarm::trajectory::splines_test {
namespace {

constexpr double kPi = std::numbers::pi;

struct Sample {
  double p, v, a;
};

Sample at(const Trajectory& trajectory, double t, std::size_t joint = 0) {
  std::vector<double> p(trajectory.joints()), v(trajectory.joints()), a(trajectory.joints());
  std::size_t hint = 0;
  trajectory.sample(t, p, v, a, hint);
  return {p[joint], v[joint], a[joint]};
}

void expect(const Sample& sample, double p, double v, double a) {
  EXPECT_NEAR(sample.p, p, 1e-8);
  EXPECT_NEAR(sample.v, v, 1e-8);
  EXPECT_NEAR(sample.a, a, 1e-8);
}

TrajectoryPoint point(double t, std::vector<double> p, std::vector<double> v = {},
                      std::vector<double> a = {}) {
  return {std::move(p), std::move(v), std::move(a), {}, t};
}

const TrajectoryPoint kZero = point(0, {0}, {0}, {0});

SplineOptions moving_end() {
  SplineOptions options;
  options.allow_nonzero_velocity_at_end = true;
  return options;
}

std::vector<std::string> codes(const std::vector<Problem>& problems) {
  std::vector<std::string> out;
  for (const Problem& problem : problems) out.push_back(problem.code);
  return out;
}

TEST(Splines, PositionsAloneAreStraightLines) {
  const std::vector points{point(1, {1}), point(2, {2}), point(3, {3})};
  const Trajectory line = interpolate(kZero, points);
  for (const double t : {0.5, 1.5, 2.5}) expect(at(line, t), t, 1, 0);
  for (const double t : {3.1, 10.0, 1e6}) expect(at(line, t), 3, 0, 0);
}

TEST(Splines, VelocitiesMakeCubics) {
  const std::vector points{point(1, {0}, {-2}), point(3, {4}, {10})};
  const Trajectory cubic = interpolate(kZero, points, {}, moving_end());
  expect(at(cubic, 1 + std::sqrt(2.0)), 0, 4, 6 * std::sqrt(2.0));
  EXPECT_NEAR(at(cubic, 1).a, 0, 1e-8);
  expect(at(cubic, 3), 4, 10, 12);
}

TEST(Splines, AccelerationsMakeQuintics) {
  const std::vector points{point(1, {0}, {24}, {-100}), point(3, {0}, {4}, {0})};
  const Trajectory quintic = interpolate(kZero, points, {}, moving_end());
  expect(at(quintic, 1), 0, 24, -100);
  expect(at(quintic, 2), 0, -6, 10);
  expect(at(quintic, 3), 0, 4, 0);
}

TEST(Splines, AFieldCountsOnlyWhenBothEndsHaveIt) {
  const std::vector points{point(1, {1}), point(2, {3}, {0}, {0}), point(3, {4}, {0})};
  const Trajectory mixed = interpolate(kZero, points);
  expect(at(mixed, 0.5), 0.5, 1, 0);
  expect(at(mixed, 1.5), 2, 2, 0);
  expect(at(mixed, 2.5), 3.5, 1.5, 0);
}

TEST(Splines, RandomEndsAreMet) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> value(-3, 3), length(0.05, 2);
  for (int i = 0; i < 300; ++i) {
    std::vector<TrajectoryPoint> points;
    double t = 0;
    for (int k = 0; k < 4; ++k)
      points.push_back(point(t += length(random), {value(random)}, {value(random)}, {value(random)}));
    const Trajectory spline = interpolate(kZero, points, {}, moving_end());
    for (const TrajectoryPoint& p : points) {
      const Sample before = at(spline, p.time_from_start * (1 - 1e-15)),
                   after = at(spline, p.time_from_start);
      EXPECT_NEAR(before.p, p.positions[0], 1e-8);
      EXPECT_NEAR(before.v, p.velocities[0], 1e-7);
      expect(after, p.positions[0], p.velocities[0], p.accelerations[0]);
    }
  }
}

TEST(Splines, AContinuousJointTakesTheShorterWay) {
  const std::vector points{point(1, {1.5 * kPi})};
  const Trajectory shifted = interpolate(kZero, points, {true});
  EXPECT_NEAR(at(shifted, 0).p, 2 * kPi, 1e-8);
  EXPECT_NEAR(at(shifted, 1).p, 1.5 * kPi, 1e-8);
  SplineOptions options;
  options.wraparound = Wraparound::points;
  const Trajectory joined = interpolate(kZero, points, {true}, options);
  EXPECT_NEAR(at(joined, 0).p, 0, 1e-8);
  EXPECT_NEAR(at(joined, 1).p, -0.5 * kPi, 1e-8);
  EXPECT_NEAR(at(interpolate(kZero, points, {false}), 0.5).p, 0.75 * kPi, 1e-8);
}

TEST(Splines, WithoutInterpolationItJumps) {
  SplineOptions options;
  options.method = InterpolationMethod::none;
  const std::vector points{point(1, {1}), point(2, {5}), point(3, {7})};
  const Trajectory steps = interpolate(point(0, {0.25}), points, {}, options);
  EXPECT_EQ(at(steps, 0.999).p, 0.25);
  EXPECT_EQ(at(steps, 1.0).p, 5);
  EXPECT_EQ(at(steps, 2.5).p, 7);
  EXPECT_EQ(at(steps, 9).p, 7);
  EXPECT_EQ(at(interpolate(kZero, std::span(points).first(1), {}, options), 1.5).p, 1);
}

TEST(Splines, AFirstPointAtTimeZeroIsTheStart) {
  const std::vector points{point(0, {2}), point(1, {3})};
  EXPECT_NEAR(at(interpolate(kZero, points), 0.5).p, 2.5, 1e-12);
  EXPECT_EQ(at(interpolate(kZero, std::span(points).first(1)), 0).p, 2);
}

TEST(Splines, EveryFaultIsFoundAtOnce) {
  const std::vector points{point(2, {1, 2}), point(2, {NAN}), point(1, {}, {1}), point(5, {1}, {0.5})};
  EXPECT_EQ(codes(check_points(kZero, points)),
            (std::vector<std::string>{"wrong-size", "bad-number", "no-positions", "bad-time", "bad-time",
                                      "moves-at-end"}));
  EXPECT_THROW(interpolate(kZero, points), Error);
}

TEST(Splines, RefusesNoPointsAndBadTimes) {
  EXPECT_EQ(codes(check_points(kZero, {})), std::vector<std::string>{"no-points"});
  for (const double t : {-1.0, double(NAN), double(INFINITY)})
    EXPECT_EQ(codes(check_points(kZero, std::vector{point(t, {1})})), std::vector<std::string>{"bad-time"});
  TrajectoryPoint pushing = point(1, {1});
  pushing.effort = {1, 2};
  EXPECT_EQ(codes(check_points(kZero, std::vector{pushing})), std::vector<std::string>{"wrong-size"});
}

TEST(Splines, AVelocityAtTheEndNeedsPermission) {
  const std::vector points{point(1, {1}, {0.5})};
  EXPECT_EQ(codes(check_points(kZero, points)), std::vector<std::string>{"moves-at-end"});
  EXPECT_NO_THROW(interpolate(kZero, points, {}, moving_end()));
}

}  // namespace
}  // namespace polyarm::trajectory::splines_test
