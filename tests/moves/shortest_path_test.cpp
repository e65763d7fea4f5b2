// Time on paths of a TCP against a slow optimiser that shares nothing with it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/moves/cartesian_joints.hpp"
#include "polyarm/paths/cartesian_path.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/support/slow_timing.hpp"

namespace polyarm::moves::shortest_path_test {
namespace {

/// Lines and arcs with blends of 1 to 4 cm, before the robot.
std::unique_ptr<const paths::Path> lines_and_arcs(const kinematics::Chain& chain, std::mt19937_64& engine) {
  const auto even = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const std::vector<double> seed{0.2, -1.3, 1.6, -1.9, -1.6, 0.1};
  const Pose home = chain.forward(seed);
  const auto near = [&] {
    Pose p = home;
    p.position = p.position + Vec3{even(-0.15, 0.15), even(-0.15, 0.15), even(-0.15, 0.1)};
    p.rotation = p.rotation * from_rpy(even(-0.3, 0.3), even(-0.3, 0.3), even(-0.5, 0.5));
    return p;
  };
  paths::CartesianPathBuilder builder(home);
  builder.line(near(), {even(0.01, 0.04), {}}).line(near(), {even(0.01, 0.04), {}});
  builder.arc(near().position, near(), paths::ArcOrientation::interpolated, {even(0.01, 0.04), {}});
  builder.line(near(), {0, {}});
  paths::PathSections joints = joints_along(chain, builder.build(), seed);
  return std::move(joints.sections.front());
}

TEST(ShortestPath, OfLinesArcsAndBlendsIsWithinFivePercentOfASlowOptimiser) {
  const description::RobotModel model =
      description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e");
  const kinematics::Chain chain(model, model.tool_link());
  const std::vector<trajectory::MotionLimits> limits(6, trajectory::MotionLimits::symmetric(3.14, 12, 150));
  std::mt19937_64 engine(3);
  int compared = 0;
  for (int k = 0; k < 8 && compared < 3; ++k) {
    std::unique_ptr<const paths::Path> path;
    try {
      path = lines_and_arcs(chain, engine);
    } catch (const Error&) {
      continue;  // cannot be followed, which is not what this is about
    }
    polyarm::test::SlowOptions options;
    options.intervals = 600;
    options.rounds = 2;
    const double slow = polyarm::test::SlowTiming(*path, limits, options).duration();
    EXPECT_LE(timing::time_path(*path, limits).profile.duration(), 1.05 * slow) << k;
    ++compared;
  }
  EXPECT_EQ(compared, 3);
}

}  // namespace
}  // namespace polyarm::moves::shortest_path_test
