#include "polyarm/trajectory/point_chunks.hpp"

#include <gtest/gtest.h>

namespace polyarm::trajectory::point_chunks_test {
namespace {

std::vector<TrajectoryPoint> points_of(std::vector<double> TrajectoryPoint::*field,
                                       std::vector<double> values) {
  std::vector<TrajectoryPoint> out;
  for (const double value : values) {
    TrajectoryPoint point;
    (point.*field) = {value};
    point.time_from_start = static_cast<double>(out.size() + 1);
    out.push_back(point);
  }
  return out;
}

TEST(PointChunks, VelocitiesAreAddedUpFromRest) {
  auto points = points_of(&TrajectoryPoint::velocities, {1, 2, 1});
  integrate_points(points, 1);
  EXPECT_NEAR(points[0].positions[0], 0.5, 1e-12);
  EXPECT_NEAR(points[1].positions[0], 2.0, 1e-12);
  EXPECT_NEAR(points[2].positions[0], 3.5, 1e-12);
}

TEST(PointChunks, AccelerationsAreAddedUpTwice) {
  auto points = points_of(&TrajectoryPoint::accelerations, {1, 2, 1});
  integrate_points(points, 1);
  const double v[] = {0.5, 2, 3.5}, x[] = {0.25, 1.5, 4.25};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(points[i].velocities[0], v[i], 1e-12);
    EXPECT_NEAR(points[i].positions[0], x[i], 1e-12);
  }
}

TEST(PointChunks, WhatCannotBeAddedUpStaysAsItIs) {
  auto points = points_of(&TrajectoryPoint::velocities, {1, 2});
  points[1].velocities.clear();
  integrate_points(points, 1);
  EXPECT_FALSE(points[0].positions.empty());
  EXPECT_TRUE(points[1].positions.empty());
}

TEST(PointChunks, ASplineWithContinuousAccelerationGoesThroughAllPoints) {
  auto points = points_of(&TrajectoryPoint::positions, {0, .1, .3});
  upsample_positions(points, 10);
  const double v[] = {0, 2.25, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(points[i].velocities[0], v[i], 1e-12);
    EXPECT_NEAR(points[i].time_from_start, 0.1 * static_cast<double>(i + 1), 1e-12);
  }
  auto many = points_of(&TrajectoryPoint::positions, {0, 1, -2, 3, 0.5, 0.25, 8, -1});
  upsample_positions(many, 4);
  const double h = 0.25;
  for (std::size_t i = 1; i + 1 < many.size(); ++i) {  // acceleration is the same on both sides of each point
    const auto p = [&](std::size_t k) { return many[k].positions[0]; };
    const auto u = [&](std::size_t k) { return many[k].velocities[0]; };
    const double before = (-6 * (p(i) - p(i - 1)) / h + 2 * u(i - 1) + 4 * u(i)) / h;
    const double after = (6 * (p(i + 1) - p(i)) / h - 4 * u(i) - 2 * u(i + 1)) / h;
    EXPECT_NEAR(before, after, 1e-9);
  }
}

TEST(PointChunks, TimesThatDoNotIncreaseAreLeftAlone) {
  auto points = points_of(&TrajectoryPoint::positions, {0, 1, 2});
  points[2].time_from_start = points[1].time_from_start;
  upsample_positions(points, 10);
  EXPECT_TRUE(points[0].velocities.empty());
  EXPECT_EQ(points[0].time_from_start, 1);
}

}  // namespace
}  // namespace polyarm::trajectory::point_chunks_test
