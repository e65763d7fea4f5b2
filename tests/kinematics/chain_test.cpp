#include "polyarm/kinematics/chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/sample_states.hpp"
#include "tests/kinematics/unseen_arms.hpp"

namespace polyarm::kinematics {
namespace {

const Pose kSomewhere{{0.4, -0.3, 0.8}, from_rpy(0.2, -0.4, 2.1)};
const Pose kTool{{0.01, 0.02, 0.1}, from_rpy(0.3, 0, 0.2)};

/// The classic Denavit-Hartenberg product with the maker's numbers, turned by half a turn about z.
Pose ur3_by_dh(const std::vector<double>& q) {
  const double a[] = {0, -0.24365, -0.21325, 0, 0, 0}, d[] = {0.1519, 0, 0, 0.11235, 0.08535, 0.0819};
  const double alpha[] = {std::numbers::pi / 2, 0, 0, std::numbers::pi / 2, -std::numbers::pi / 2, 0};
  Pose t{{}, from_rpy(0, 0, std::numbers::pi)};
  for (std::size_t i = 0; i < 6; ++i)
    t = t * Pose{{0, 0, d[i]}, from_rpy(0, 0, q[i])} * Pose{{a[i], 0, 0}, from_rpy(alpha[i], 0, 0)};
  return t;
}

TEST(Chain, AgreesWithTheMakersDhParameters) {
  const auto model = test::ur3();
  const Chain chain(model, test::tip_of(model));
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const auto q = test::random_state(chain, random);
    EXPECT_LT(norm(chain.forward(q).position - ur3_by_dh(q).position), 1e-12);
    EXPECT_LT(angle_between(chain.forward(q).rotation, ur3_by_dh(q).rotation), 1e-7);
  }
}

TEST(Chain, StretchedOutUr3StandsWhereTheDrawingSays) {
  const auto model = test::ur3();
  const Chain chain(model, test::tip_of(model));
  const Vec3 at = chain.forward(std::vector<double>(6, 0.0)).position;
  EXPECT_NEAR(at.x, 0.24365 + 0.21325, 1e-12);
  EXPECT_NEAR(at.y, 0.11235 + 0.0819, 1e-12);
  EXPECT_NEAR(at.z, 0.1519 - 0.08535, 1e-12);
}

TEST(Chain, JacobianIsTheDerivativeOfThePose) {
  for (const auto& model : {test::ur3(), test::seven(), test::five(), test::gantry()}) {
    const Chain chain(model, test::tip_of(model), kSomewhere, kTool);
    const std::size_t n = chain.joints();
    Random random(2);
    std::vector<double> J(6 * n);
    for (int i = 0; i < 50; ++i) {
      const auto q = test::random_state(chain, random);
      const Pose at = chain.jacobian(q, J);
      EXPECT_EQ(at, chain.forward(q));
      for (std::size_t j = 0; j < n; ++j) {
        constexpr double h = 1e-5;
        auto ahead = q, behind = q;
        ahead[j] += h;
        behind[j] -= h;
        const Pose a = chain.forward(ahead), b = chain.forward(behind);
        const Vec3 v = (0.5 / h) * (a.position - b.position);
        const Vec3 w = (0.5 / h) * to_rotation_vector(a.rotation * inverse(b.rotation));
        EXPECT_LT(norm(v - Vec3{J[j], J[n + j], J[2 * n + j]}), 1e-8);
        EXPECT_LT(norm(w - Vec3{J[3 * n + j], J[4 * n + j], J[5 * n + j]}), 1e-8);
      }
    }
  }
}

TEST(Chain, BaseAndToolFrameTheChain) {
  const auto model = test::seven();
  const Chain bare(model, test::tip_of(model)), placed(model, test::tip_of(model), kSomewhere, kTool);
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const auto q = test::random_state(bare, random);
    const Pose expected = kSomewhere * bare.forward(q) * kTool;
    EXPECT_LT(norm(placed.forward(q).position - expected.position), 1e-14);
    EXPECT_LT(angle_between(placed.forward(q).rotation, expected.rotation), 1e-7);
  }
}

TEST(Chain, LinkPosesPutTheTipWhereForwardDoes) {
  for (const auto& model : {test::ur3(), test::seven(), test::five(), test::gantry()}) {
    const auto tip = static_cast<std::size_t>(test::tip_of(model));
    const Chain chain(model, test::tip_of(model), kSomewhere);
    ASSERT_EQ(chain.links(), model.links.size());
    std::vector<Pose> links(chain.links());
    Random random(4);
    for (int i = 0; i < 50; ++i) {
      const auto q = test::random_state(chain, random);
      chain.link_poses(q, links);
      EXPECT_EQ(links[0], kSomewhere);
      EXPECT_LT(norm(links[tip].position - chain.forward(q).position), 1e-14);
      EXPECT_LT(angle_between(links[tip].rotation, chain.forward(q).rotation), 1e-7);
    }
  }
}

TEST(Chain, AJointBesideThePathMovesOnlyItsOwnLink) {
  const auto model = test::gantry();
  const Chain chain(model, test::tip_of(model));
  EXPECT_FALSE(chain.moves_tcp(3));
  std::vector<double> q{0.1, 0.2, 0.3, 0};
  std::vector<Pose> before(chain.links()), after(chain.links());
  const Pose tcp = chain.forward(q);
  chain.link_poses(q, before);
  q[3] = 0.5;
  chain.link_poses(q, after);
  EXPECT_EQ(chain.forward(q), tcp);
  for (std::size_t i = 0; i + 1 < chain.links(); ++i) EXPECT_EQ(before[i], after[i]);
  EXPECT_NEAR(norm(after.back().position - before.back().position), 0.5, 1e-12);
}

TEST(Chain, AMimicJointFollows) {
  const auto model = test::gantry();
  auto unhooked = model;
  unhooked.joints[2].mimic.reset();
  unhooked.actuated = {0, 1, 2, 3};
  const Chain chain(model, test::tip_of(model)), free(unhooked, test::tip_of(unhooked));
  const Pose expected = free.forward(std::vector<double>{0.7, 0.9, -0.5 * 0.9 + 0.1, -0.4});
  const Pose got = chain.forward(std::vector<double>{0.7, 0.9, -0.4, 0});
  EXPECT_LT(norm(got.position - expected.position), 1e-14);
}

TEST(Chain, NoPoseIsBeyondTheReachWhichIsWithinTheBound) {
  for (const auto& model : {test::ur3(), test::seven(), test::five(), test::gantry()}) {
    const Chain chain(model, test::tip_of(model), kSomewhere, kTool);
    EXPECT_LE(chain.reach(), chain.reach_bound() + 1e-12);
    Random random(5);
    double most = 0;
    for (int i = 0; i < 50000; ++i)
      most = std::max(most,
                      norm(chain.forward(test::random_state(chain, random)).position - chain.reach_center()));
    EXPECT_LE(most, chain.reach() + 1e-9) << model.name;
    EXPECT_GE(most, 0.9 * chain.reach()) << model.name;
  }
}

TEST(Chain, LimitsAndPeriodsAreTheModels) {
  auto model = test::ur3();
  model.joints[6].type = description::JointType::continuous;
  model.joints[3].limits = {};
  const Chain chain(model, test::tip_of(model));
  EXPECT_EQ(chain.names()[2], "elbow");
  EXPECT_EQ(chain.lower()[0], -2 * std::numbers::pi);
  EXPECT_EQ(chain.upper()[2], std::numeric_limits<double>::infinity());
  EXPECT_EQ(chain.upper()[5], std::numeric_limits<double>::infinity());
  EXPECT_EQ(chain.period(0), 2 * std::numbers::pi);
  const auto sliding = test::gantry();
  const Chain gantry(sliding, test::tip_of(sliding));
  EXPECT_EQ(gantry.period(0), 0);  // slides
  EXPECT_EQ(gantry.period(1), 0);  // turns a mimic joint by half as much
  EXPECT_EQ(gantry.period(2), 2 * std::numbers::pi);
  EXPECT_TRUE(gantry.slides(0));
  EXPECT_FALSE(gantry.slides(1));
}

TEST(Chain, AJointThatAnotherFollowsAtAnyMultipleHasNoPeriodWhicheverComesFirst) {
  for (const bool in_front : {false, true}) {
    for (const double multiplier : {0.3, 1.0}) {
      auto model = test::ur3();
      const auto joints = test::moving_joints(model, test::tip_of(model));
      const int last = joints.back(), first = joints.front();
      test::follow(model, in_front ? first : last, in_front ? last : first, multiplier, 0);
      const Chain chain(model, test::tip_of(model));
      const std::size_t followed = in_front ? chain.joints() - 1 : 0;
      EXPECT_EQ(chain.period(followed), 0) << in_front << ' ' << multiplier;
      EXPECT_EQ(chain.period(2), 2 * std::numbers::pi);
    }
  }
}

// As KDL has it: a joint of several values counts as fixed, so that arms on a free base have kinematics.
TEST(Chain, TakesPlanarAndFloatingJointsAsFixedAtTheirOrigins) {
  using description::JointType;
  for (const JointType type : {JointType::floating, JointType::planar}) {
    auto free = test::ur3(), fixed = test::ur3();
    free.joints[0].type = type, fixed.joints[0].type = JointType::fixed;
    for (auto* model : {&free, &fixed}) model->actuated.erase(model->actuated.begin());
    const Chain chain(free, test::tip_of(free)), reference(fixed, test::tip_of(fixed));
    ASSERT_EQ(chain.joints(), reference.joints());
    const std::vector<double> q{-1.1, 0.7, -0.4, 1.3, 0.2};
    const Pose a = chain.forward(q), b = reference.forward(q);
    EXPECT_LT(norm(a.position - b.position), 1e-12);
    EXPECT_LT(norm(a.rotation * Vec3{1, 0, 0} - b.rotation * Vec3{1, 0, 0}), 1e-12);
  }
}

TEST(Chain, RefusesModelsThatAreNone) {
  const auto good = test::ur3();
  EXPECT_THROW(Chain(good, -1), Error);
  EXPECT_THROW(Chain(good, 99), Error);
  EXPECT_THROW(Chain(good, 7, Pose{{NAN, 0, 0}, {}}), Error);
  auto circle = test::gantry();
  circle.joints[1].mimic = description::Mimic{2, 1, 0};
  circle.actuated = {0, 3};
  EXPECT_THROW(Chain(circle, test::tip_of(circle)), Error);
  auto orphan = test::ur3();
  orphan.links[3].parent_joint = 77;
  EXPECT_THROW(Chain(orphan, test::tip_of(orphan)), Error);
  auto loop = test::ur3();
  loop.joints[2].parent_link = 5;
  EXPECT_THROW(Chain(loop, test::tip_of(loop)), Error);
  auto endless = test::ur3();
  endless.joints[2].origin.position.x = INFINITY;
  EXPECT_THROW(Chain(endless, test::tip_of(endless)), Error);
}

TEST(Chain, ARobotWithoutJointsStandsStill) {
  description::RobotModel model;
  model.links.push_back({"base", {}, {}, {}, -1});
  const Chain chain(model, 0, kSomewhere, kTool);
  EXPECT_LT(norm(chain.forward({}).position - (kSomewhere * kTool).position), 1e-15);
  EXPECT_NEAR(chain.reach(), norm(kTool.position), 1e-12);
}

}  // namespace
}  // namespace polyarm::kinematics
