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

WorkspaceZone cone(const Vec3& direction, double within, const Vec3& axis = {0, 0, 1}) {
  WorkspaceZone out{"upright", {}, ZoneKind::cone, {}, direction, {}, {}};
  out.within = within;
  out.axis = axis;
  return out;
}

WorkspaceZone range(int joint, double lower, double upper) {
  WorkspaceZone out{"low", {}, ZoneKind::range, {}, {}, {}, {}};
  out.joint = "elbow";
  out.index = joint;
  out.lower = lower;
  out.upper = upper;
  return out;
}

Pose at(const Vec3& position) {
  return {position, {}};
}

TEST(Workspace, TellsHowFarTheTcpIsFromEachBoundary) {
  const Workspace workspace({plane("table", {0, 0, 1}, {0, 0, 2}),
                             {"post", {}, ZoneKind::outside, {}, {}, {1, 1, 0}, {2, 2, 4}},
                             {"cage", {}, ZoneKind::inside, {}, {}, {-3, -3, -3}, {3, 3, 5}}});
  EXPECT_EQ(workspace.boundaries(), 8u);
  EXPECT_DOUBLE_EQ(workspace.distance(0, at({5, 5, 1.5}), {}).distance, 0.5);
  EXPECT_DOUBLE_EQ(workspace.distance(1, at({0, 1.5, 1}), {}).distance, 1);
  EXPECT_EQ(workspace.distance(1, at({0, 1.5, 1}), {}).away, (Vec3{-1, 0, 0}));
  EXPECT_DOUBLE_EQ(workspace.distance(1, at({0, 0, 1}), {}).distance, std::sqrt(2.0));
  EXPECT_NEAR(workspace.distance(1, at({1.1, 1.5, 1}), {}).distance, -0.1, 1e-12);
  EXPECT_FALSE(workspace.check(at({0, 0, 2}), {}));
  EXPECT_EQ(workspace.check(at({0, 0, 0.5}), {})->zone, "table");
  EXPECT_EQ(workspace.check(at({1.5, 1.5, 2}), {})->zone, "post");
  EXPECT_NEAR(workspace.check(at({3.25, 0, 2}), {})->depth, 0.25, 1e-12);
}

TEST(Workspace, RefusesWhatIsNone) {
  EXPECT_THROW(Workspace({plane("p", {}, {0, 0, 0})}), Error);
  EXPECT_THROW(Workspace({{"b", {}, ZoneKind::inside, {}, {}, {1, 0, 0}, {0, 1, 1}}}), Error);
  EXPECT_THROW(Workspace({cone({0, 0, 0}, 0.2)}), Error);
  EXPECT_THROW(Workspace({cone({0, 0, 1}, 0)}), Error);
  EXPECT_THROW(Workspace({cone({0, 0, 1}, NAN)}), Error);
  EXPECT_THROW(Workspace({range(0, 1, 1)}), Error);
  EXPECT_THROW(
      Workspace(std::vector<WorkspaceZone>(11, {"b", {}, ZoneKind::inside, {}, {}, {0, 0, 0}, {1, 1, 1}})),
      Error);
}

TEST(Workspace, TellsHowFarTheToolMayTilt) {
  const Workspace workspace({cone({0, 0, -2}, 0.3), cone({1, 0, 0}, 0.5, {0, 1, 0})});
  const Quaternion down = from_axis_angle({1, 0, 0}, M_PI);
  EXPECT_NEAR(workspace.distance(0, {{}, down}, {}).distance, 0.3, 1e-9);
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> even(-1, 1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 about = normalized(Vec3{even(engine), even(engine), even(engine)});
    const Pose tcp{{1, 2, 3}, normalized(from_axis_angle(about, 2 * even(engine)) * down)};
    for (std::size_t k = 0; k < 2; ++k) {
      const Workspace::Distance d = workspace.distance(k, tcp, {});
      const Vec3 axis = tcp.rotation * (k == 0 ? Vec3{0, 0, 1} : Vec3{0, 1, 0});
      const double angle = std::acos(dot(axis, k == 0 ? Vec3{0, 0, -1} : Vec3{1, 0, 0}));
      ASSERT_NEAR(d.distance, (k == 0 ? 0.3 : 0.5) - angle, 1e-6);
      ASSERT_EQ(d.away, Vec3{});
      const Vec3 turn = normalized(Vec3{even(engine), even(engine), even(engine)});
      const Pose next{tcp.position, normalized(from_axis_angle(turn, 1e-6) * tcp.rotation)};
      ASSERT_NEAR((workspace.distance(k, next, {}).distance - d.distance) / 1e-6, dot(d.turn, turn), 1e-3);
    }
  }
}

TEST(Workspace, ARangeCountsInItsProfile) {
  WorkspaceZone narrow = range(1, -0.5, 0.25);
  narrow.profile = ZoneProfile::reduced;
  const Workspace workspace({narrow, range(0, -1, 1)});
  EXPECT_EQ(workspace.boundaries(), 4u);
  EXPECT_FALSE(workspace.counts(0, false));
  EXPECT_TRUE(workspace.counts(0, true));
  EXPECT_TRUE(workspace.counts(2, false));
  const std::vector<double> q{0, 0.5};
  EXPECT_NEAR(workspace.distance(0, {}, q).distance, 1, 1e-12);
  EXPECT_NEAR(workspace.distance(1, {}, q).distance, -0.25, 1e-12);
  EXPECT_EQ(workspace.distance(1, {}, q).joint, 1);
  EXPECT_EQ(workspace.distance(1, {}, q).sign, -1);
  EXPECT_FALSE(workspace.check({}, q, false));
  EXPECT_EQ(workspace.check({}, q, true)->crossing, "elbow, at 0.5000, leaves 'low', -0.5000 to 0.2500");
}

/// Against a search that looks at every ten-thousandth of the path.
TEST(Workspace, FindsTheFirstPlaceWhereAToolTiltsTooFarOrAJointLeavesItsRange) {
  const kinematics::Chain chain(polyarm::test::ur3(),
                                static_cast<int>(polyarm::test::ur3().links.size()) - 1);
  std::mt19937_64 engine(6);
  std::uniform_real_distribution<double> even(-1, 1);
  int left = 0, stayed = 0;
  for (int i = 0; i < 80; ++i) {
    std::vector<paths::JointWaypoint> waypoints(2);
    for (auto& w : waypoints)
      for (std::size_t j = 0; j < chain.joints(); ++j) w.q.push_back(1.5 * even(engine));
    const auto made = paths::joint_lines(waypoints);
    const paths::Path& path = *made.sections.at(0);
    WorkspaceZone zone = range(2, -0.1 - std::abs(even(engine)), 0.1 + std::abs(even(engine)));
    if (i % 2 == 0)
      zone = cone(chain.forward(waypoints[0].q).rotation * Vec3{0, 0, 1}, 0.1 + 2 * std::abs(even(engine)));
    zone.profile = ZoneProfile::reduced;
    const Workspace workspace({zone});
    double first = -1;
    std::vector<double> q(chain.joints());
    if (workspace.check(chain.forward(waypoints[0].q), waypoints[0].q, true)) continue;  // it begins outside
    for (int k = 0; k <= 10000 && first < 0; ++k) {
      const double s = path.length() * k / 10000;
      path.at(s, {q, {}, {}, {}});
      if (workspace.check(chain.forward(q), q, true, 1e-6)) first = s;
    }
    EXPECT_FALSE(first_violation(workspace, chain, path, false)) << "another profile";
    const auto found = first_violation(workspace, chain, path, true);
    ASSERT_EQ(found.has_value(), first >= 0) << i;
    ++(found ? left : stayed);
    if (found) {
      EXPECT_NEAR(found->at, first, path.length() * 1.1e-4);
    }
  }
  EXPECT_GT(left, 10);
  EXPECT_GT(stayed, 5);
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
      if (workspace.check(chain.forward(q), q, false, 1e-6)) first = s;
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
