#include "polyarm/moves/workspace.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "polyarm/paths/joint_path.hpp"
#include "tests/kinematics/sample_robots.hpp"

namespace polyarm::moves::workspace_test {
namespace {

WorkspaceZone plane(const char* name, const Vec3& point, const Vec3& normal) {
  return {name, {}, ZoneKind::plane, point, normal, {}, {}};
}

TEST(Workspace, TellsHowFarTheTcpIsFromEachBoundary) {
  const Workspace workspace({plane("table", {0, 0, 1}, {0, 0, 2}),
                             {"post", {}, ZoneKind::outside, {}, {}, {1, 1, 0}, {2, 2, 4}},
                             {"cage", {}, ZoneKind::inside, {}, {}, {-3, -3, -3}, {3, 3, 5}}});
  EXPECT_EQ(workspace.boundaries(), 8u);
  EXPECT_DOUBLE_EQ(workspace.distance(0, {5, 5, 1.5}).distance, 0.5);
  EXPECT_DOUBLE_EQ(workspace.distance(1, {0, 1.5, 1}).distance, 1);
  EXPECT_EQ(workspace.distance(1, {0, 1.5, 1}).away, (Vec3{-1, 0, 0}));
  EXPECT_DOUBLE_EQ(workspace.distance(1, {0, 0, 1}).distance, std::sqrt(2.0));
  EXPECT_NEAR(workspace.distance(1, {1.1, 1.5, 1}).distance, -0.1, 1e-12);
  EXPECT_FALSE(workspace.check({0, 0, 2}));
  EXPECT_EQ(workspace.check({0, 0, 0.5})->zone, "table");
  EXPECT_EQ(workspace.check({1.5, 1.5, 2})->zone, "post");
  EXPECT_NEAR(workspace.check({3.25, 0, 2})->depth, 0.25, 1e-12);
}

TEST(Workspace, RefusesWhatIsNone) {
  EXPECT_THROW(Workspace({plane("p", {}, {0, 0, 0})}), Error);
  EXPECT_THROW(Workspace({{"b", {}, ZoneKind::inside, {}, {}, {1, 0, 0}, {0, 1, 1}}}), Error);
  EXPECT_THROW(
      Workspace(std::vector<WorkspaceZone>(11, {"b", {}, ZoneKind::inside, {}, {}, {0, 0, 0}, {1, 1, 1}})),
      Error);
}

/// Against a search that looks at every ten-thousandth of the path.
TEST(Workspace, FindsTheFirstPlaceWhereAPathLeavesIt) {
  const kinematics::Chain chain(polyarm::test::ur3(),
                                static_cast<int>(polyarm::test::ur3().links.size()) - 1);
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> even(-1, 1);
  int left = 0, stayed = 0;
  for (int i = 0; i < 60; ++i) {
    std::vector<paths::JointWaypoint> waypoints(2);
    for (auto& w : waypoints)
      for (std::size_t j = 0; j < chain.joints(); ++j) w.q.push_back(1.5 * even(engine));
    const auto made = paths::joint_lines(waypoints);
    const paths::Path& path = *made.sections.at(0);
    const Vec3 start = chain.forward(waypoints[0].q).position;
    const Vec3 normal = normalized(Vec3{even(engine), even(engine), even(engine)});
    const Workspace workspace(
        {plane("wall", start - (0.02 + 0.1 * std::abs(even(engine))) * normal, normal)});
    double first = -1;
    std::vector<double> q(chain.joints());
    for (int k = 0; k <= 10000 && first < 0; ++k) {
      const double s = path.length() * k / 10000;
      path.at(s, {q, {}, {}, {}});
      if (workspace.check(chain.forward(q).position, 1e-6)) first = s;
    }
    const auto found = first_violation(workspace, chain, path);
    ASSERT_EQ(found.has_value(), first >= 0) << i;
    if (!found) {
      ++stayed;
      continue;
    }
    ++left;
    EXPECT_NEAR(found->at, first, path.length() * 1.1e-4);
    EXPECT_EQ(found->zone, "wall");
    try {
      check_workspace(workspace, chain, path, "the move to p1");
      ADD_FAILURE();
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("the move to p1 leaves the workspace"), std::string::npos);
      EXPECT_NE(std::string(e.what()).find("'wall'"), std::string::npos);
    }
  }
  EXPECT_GT(left, 10);
  EXPECT_GT(stayed, 5);
}

}  // namespace
}  // namespace polyarm::moves::workspace_test
