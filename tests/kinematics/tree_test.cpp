#include "polyarm/kinematics/tree.hpp"

#include <gtest/gtest.h>

#include "polyarm/base/error.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/sample_trees.hpp"

namespace polyarm::kinematics {
namespace {

TEST(Tree, PlacesTheToolsOfAllRobotsWhereTheirChainsDo) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(1);
  for (const std::string& name : catalogue.names()) {
    const auto model = catalogue.load(name);
    const Pose base{{0.1, 0.2, 0.3}, from_rpy(0.1, 0.2, 0.3)};
    const Chain chain(model, model.tool_link(), base);
    const Tree tree(model, {RootJoint::fixed, base, {}});
    ASSERT_EQ(tree.positions(), chain.joints());
    const auto q = test::any_state(tree, random);
    const auto link = static_cast<std::size_t>(model.tool_link());
    const Pose is = tree.link_pose(q, link), want = chain.forward(q);
    EXPECT_LT(norm(is.position - want.position), 1e-13) << name;
    EXPECT_LT(angle_between(is.rotation, want.rotation), 1e-13) << name;
    std::vector<double> J(6 * chain.joints()), expected(6 * chain.joints());
    tree.jacobian(q, link, {}, J);
    chain.jacobian(q, expected);
    for (std::size_t i = 0; i < J.size(); ++i) EXPECT_NEAR(J[i], expected[i], 1e-13) << name;
  }
}

TEST(Tree, MimicJointsFollowWithTheirOffset) {
  Random random(2);
  for (const auto& sample : test::sample_trees()) {
    if (sample.options.root != RootJoint::fixed) continue;
    const Tree tree(sample.model, sample.options);
    const Chain chain(sample.model, static_cast<int>(sample.model.links.size()) - 1,
                      sample.options.T_world_base);
    const auto q = test::any_state(tree, random);
    std::vector<Pose> is(tree.links()), want(tree.links());
    tree.link_poses(q, is);
    chain.link_poses(q, want);
    for (std::size_t i = 0; i < is.size(); ++i) {
      EXPECT_LT(norm(is[i].position - want[i].position), 1e-13) << sample.name;
      EXPECT_LT(angle_between(is[i].rotation, want[i].rotation), 1e-13) << sample.name;
    }
  }
}

TEST(Tree, JacobiansAreDerivativesForEveryTypeOfJoint) {
  Random random(3);
  constexpr double kStep = 1e-6;
  for (const auto& sample : test::sample_trees()) {
    const Tree tree(sample.model, sample.options);
    const std::size_t n = tree.velocities();
    const auto q = test::any_state(tree, random);
    const Vec3 point = test::any_vector(random);
    for (std::size_t link = 0; link < tree.links(); ++link) {
      std::vector<double> aligned(6 * n), body(6 * n), space(6 * n);
      const Pose at = tree.jacobian(q, link, point, aligned);
      tree.jacobian(q, link, point, body, JacobianFrame::body);
      tree.jacobian(q, link, point, space, JacobianFrame::space);
      for (std::size_t j = 0; j < n; ++j) {
        std::vector<double> unit(n, 0.0);
        unit[j] = 1;
        auto a = q, b = q;
        tree.integrate(a, unit, -kStep);
        tree.integrate(b, unit, kStep);
        const Pose before = tree.link_pose(a, link), after = tree.link_pose(b, link);
        const Vec3 v = (0.5 / kStep) * (after * point - before * point);
        const Vec3 w = (0.5 / kStep) * to_rotation_vector(after.rotation * inverse(before.rotation));
        const auto expect = [&](const std::vector<double>& J, const Vec3& linear, const Vec3& angular) {
          const double want[] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
          for (std::size_t r = 0; r < 6; ++r)
            ASSERT_NEAR(J[r * n + j], want[r], 1e-7) << sample.name << " " << j;
        };
        expect(aligned, v, w);
        expect(body, inverse(at.rotation) * v, inverse(at.rotation) * w);
        expect(space, v - cross(w, at * point), w);
      }
    }
  }
}

TEST(Tree, AFloatingRootStandsWhereItsStateSays) {
  const auto model = test::ur3();
  const Pose base{{1, 2, 3}, from_rpy(0.1, 0.5, -0.3)};
  const Tree tree(model, {RootJoint::floating, base, {}});
  ASSERT_EQ(tree.positions(), 13u);
  ASSERT_EQ(tree.velocities(), 12u);
  EXPECT_EQ(tree.joints().front().name, "root");
  auto q = tree.neutral();
  EXPECT_LT(norm(tree.link_pose(q, 0).position - base.position), 1e-15);
  const Quaternion turn = from_rpy(0.3, 0.2, 0.1);
  q[0] = 0.5, q[1] = -0.25, q[2] = 2;
  q[3] = turn.x, q[4] = turn.y, q[5] = turn.z, q[6] = turn.w;
  const Pose want = base * Pose{{0.5, -0.25, 2}, turn}, is = tree.link_pose(q, 0);
  EXPECT_LT(norm(is.position - want.position), 1e-15);
  EXPECT_LT(angle_between(is.rotation, want.rotation), 1e-15);
}

TEST(Tree, RefusesModelsThatAreNone) {
  Random random(4);
  auto circle = test::any_tree(random, {3});
  circle.joints[2].child_link = 1;
  EXPECT_THROW(Tree{circle}, Error);
  auto mimic = test::any_tree(random, {3});
  mimic.actuated = {0};
  mimic.joints[1].mimic = {2, 1, 0};
  mimic.joints[2].mimic = {1, 1, 0};
  EXPECT_THROW(Tree{mimic}, Error);
  auto far = test::any_tree(random, {2});
  far.joints[0].origin.position.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Tree{far}, Error);
  auto plane = test::any_tree(random, {2});
  plane.joints[0].type = description::JointType::planar;
  plane.joints[1].mimic = {0, 1, 0};
  plane.actuated = {0};
  EXPECT_THROW(Tree{plane}, Error);
}

}  // namespace
}  // namespace polyarm::kinematics
