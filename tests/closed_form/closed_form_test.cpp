#include "polyarm/closed_form/closed_form.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/closed_form/planar_form.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "tests/closed_form/sample_families.hpp"
#include "tests/kinematics/sample_states.hpp"

namespace polyarm::kinematics {
namespace {

/// What one processor finds another does too: the vector instructions here against those that all have.
TEST(ClosedForm, IsTheSameWithAndWithoutTheInstructionsOfThisProcessor) {
  Random random(1);
  int exact = 0;
  for (const ArmFamily family : test::kClosedFamilies)
    for (int i = 0; i < 40; ++i) {
      std::string why_not;
      const auto model = test::random_arm(test::random_axes(family, random), random);
      const ArmGeometry arm = *geometry_of(Chain(model, test::tip_of(model)), why_not);
      const SixAxisForm form = form_of(classify(arm));
      const LaneArm lanes = lane_arm(arm);
      std::array<double, 6> q{}, seed{};
      for (double& value : q) value = random.between(-3, 3);
      BranchJob job;
      job.form = &form;
      job.arm = &lanes;
      job.seed = seed.data();
      arm.forward(q, job.target.rotation, job.target.position);
      Branches here, anywhere;
      solve_branches(job, here);
      solve_branches_portably(job, anywhere);
      EXPECT_EQ(here.free, anywhere.free);
      for (std::size_t k = 0; k < kBranches; ++k) {
        const bool good = here.position_error2[k] < 1e-18 && here.orientation_error2[k] < 1e-18;
        EXPECT_EQ(good, anywhere.position_error2[k] < 1e-18 && anywhere.orientation_error2[k] < 1e-18);
        exact += good;
        for (std::size_t j = 0; good && j < 6; ++j)
          EXPECT_LT(std::abs(std::remainder(here.value[j][k] - anywhere.value[j][k], 2 * std::numbers::pi)),
                    1e-6);
      }
    }
  EXPECT_GT(exact, 800);
}

/// Arms whose axes are square to each other have shorter ways; each finds what the general one finds.
TEST(ClosedForm, IsTheSameByTheShorterWaysOfSquareArms) {
  Random random(3);
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  for (const char* robot :
       {"universal_robots/ur5e", "abb/irb_2400_10", "fanuc/m_10ia", "kuka/kr_6_r900_sixx"})
    for (const bool anywhere : {false, true}) {
      auto model = catalogue.load(robot);
      const Pose base{{0.3, -0.2, 0.5}, normalized(Quaternion{0.1, 0.7, -0.4, 0.5})};
      if (anywhere)
        for (auto& joint : model.joints)
          if (joint.parent_link == model.root) joint.origin = base * joint.origin;
      const Chain chain(model, model.tool_link());
      std::string why_not;
      const ArmGeometry arm = *geometry_of(chain, why_not);
      const SixAxisClass known = classify(arm);
      QuickJob job;
      job.form = form_for_quick(known);
      ASSERT_TRUE(planar_form(job.form, job.planar)) << robot;
      LaneArm lanes = lane_arm(arm);
      EXPECT_TRUE(job.planar.square.usable && job.planar.upright && lanes.square) << robot;
      EXPECT_EQ(lanes.level, !anywhere);
      QuickJob general = job;
      LaneArm all_axes = lanes;
      general.planar.square.usable = general.planar.upright = all_axes.square = false;
      int solved = 0;
      for (int i = 0; i < 20; ++i) {
        std::array<double, 6> seed;
        for (std::size_t k = 0; k < 6; ++k) {
          seed[k] = random.between(-3, 3);
          job.window[k] = general.window[k] = window_of(-4, 5, 1);
          job.joint[k] = general.joint[k] = static_cast<std::uint8_t>(k);
          job.to_arm[k] = general.to_arm[k] = static_cast<std::uint8_t>(known.from_tool ? 5 - k : k);
        }
        std::array<Pose, 8> poses;
        for (Pose& pose : poses) {
          std::vector<double> q(6);
          for (double& value : q) value = random.between(-3, 3);
          pose = chain.forward(q);
        }
        QuickAnswers one, other;
        const auto alike = [&](std::size_t k, std::size_t m) {
          double most = std::abs(one.position_error[k] - other.position_error[m]);
          for (std::size_t j = 0; j < 6; ++j)
            most = std::max(most, std::abs(one.value[j][k] - other.value[j][m]));
          return (one.good >> k & other.good >> m & 1u) != 0 && most < 1e-9;
        };
        solve_eight(job, lanes, poses, seed.data(), one);
        solve_eight(general, all_axes, poses, seed.data(), other);
        for (std::size_t k = 0; k < 8; ++k) solved += alike(k, k);
        // All branches, in an order of its own.
        if (!solve_quickly(job, lanes, poses[0], seed.data(), one) ||
            !solve_quickly(general, all_axes, poses[0], seed.data(), other))
          continue;
        EXPECT_EQ(std::popcount(one.good), std::popcount(other.good)) << robot;
        for (std::size_t k = 0; k < 8; ++k) {
          int twins = 0;
          for (std::size_t m = 0; m < 8; ++m) twins += alike(k, m);
          EXPECT_EQ(twins, one.good >> k & 1u) << robot << ", branch " << k;
        }
      }
      EXPECT_GT(solved, 140) << robot;
    }
}

/// Eight poses at a time, by all that this processor has.
TEST(ClosedForm, EightAtATimeFindTheSameWithEverySetOfInstructions) {
  Random random(2);
  int solved = 0;
  for (const ArmFamily family : test::kClosedFamilies) {
    for (int i = 0; i < 20; ++i) {
      std::string why_not;
      const auto model = test::random_arm(test::random_axes(family, random), random);
      const ArmGeometry arm = *geometry_of(Chain(model, test::tip_of(model)), why_not);
      const SixAxisClass known = classify(arm);
      if (!takes_quick(known)) continue;
      QuickJob job;
      job.form = form_for_quick(known);
      planar_form(job.form, job.planar);
      if (!takes_quick(job)) continue;
      std::array<double, 6> seed;
      for (std::size_t k = 0; k < 6; ++k) {
        seed[k] = random.between(-3, 3);
        job.window[k] = window_of(-4, 5, 1);
        job.joint[k] = static_cast<std::uint8_t>(k);
        job.to_arm[k] = static_cast<std::uint8_t>(known.from_tool ? 5 - k : k);
      }
      const LaneArm lanes = lane_arm(arm);
      std::array<Pose, 8> poses;
      for (Pose& pose : poses) {
        std::vector<double> q(6);
        for (double& value : q) value = random.between(-3, 3);
        pose = Chain(model, test::tip_of(model)).forward(q);
      }
      QuickAnswers most;
      solve_eight(fastest_instructions(), job, lanes, poses, seed.data(), most);
      for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2}) {
        QuickAnswers other;
        solve_eight(supported(set), job, lanes, poses, seed.data(), other);
        EXPECT_EQ(other.good, most.good) << describe(family) << ", " << name(set);
        for (std::size_t k = 0; k < 8; ++k)
          for (std::size_t j = 0; (most.good & other.good) >> k & 1u && j < 6; ++j)
            EXPECT_NEAR(most.value[j][k], other.value[j][k], 1e-7);
      }
      solved += std::popcount(most.good);
    }
  }
  EXPECT_GT(solved, 800);
}

/// `count` joints that come first in a joint state and that the tool does not hang on.
description::RobotModel with_fingers(description::RobotModel model, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const int link = static_cast<int>(model.links.size()), joint = static_cast<int>(model.joints.size());
    description::Joint finger = model.joints[static_cast<std::size_t>(model.actuated[0])];
    finger.name = "finger_" + std::to_string(i);
    finger.parent_link = 0;
    finger.child_link = link;
    model.links.push_back({finger.name, {}, {}, {}, joint});
    model.joints.push_back(finger);
    model.actuated.insert(model.actuated.begin() + static_cast<std::ptrdiff_t>(i), joint);
  }
  return model;
}

TEST(ClosedForm, ABatchLeavesJointsThatDoNotMoveTheToolWhereTheSeedHasThem) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  constexpr std::size_t kPoses = 300;  // more than go in one piece, and the last eight are not full
  for (const std::size_t fingers : {0u, 1u, 2u, 3u, 7u}) {
    const auto model = with_fingers(catalogue.load("universal_robots/ur5e"), fingers);
    const Chain chain(model, model.tool_link());
    ASSERT_EQ(chain.joints(), 6 + fingers);
    const ik::InverseKinematics arm(chain);
    Random random(17);
    const auto seed = test::random_state(chain, random);
    std::vector<Pose> targets;
    for (std::size_t i = 0; i < kPoses; ++i)
      targets.push_back(chain.forward(test::random_state(chain, random)));
    std::vector<IkSolution> out(kPoses + 1);
    std::vector<IkOutcome> outcomes(kPoses + 1, IkOutcome::limits);
    out[kPoses].q.fill(-77);
    out[kPoses].distance = -77;
    EXPECT_EQ(arm.solve_batch(targets, seed, std::span(out).first(kPoses), std::span(outcomes).first(kPoses)),
              kPoses);
    for (std::size_t i = 0; i < kPoses; ++i) {
      IkSolution one;
      ASSERT_EQ(arm.solve(targets[i], seed, one), outcomes[i]);
      for (std::size_t j = 0; j < chain.joints(); ++j)
        EXPECT_NEAR(out[i].q[j], chain.moves_tcp(j) ? one.q[j] : seed[j], 1e-12) << fingers << " " << i;
      EXPECT_NEAR(out[i].distance, one.distance, 1e-11);
      EXPECT_LT(out[i].position_error, 1e-9);
      EXPECT_LT(out[i].orientation_error, 1e-9);
      EXPECT_TRUE(out[i].exact);
      EXPECT_EQ(out[i].singular, one.singular);
    }
    EXPECT_EQ(std::ranges::count(out[kPoses].q, -77.0), std::ssize(out[kPoses].q)) << "beyond the end";
    EXPECT_EQ(out[kPoses].distance, -77);
    EXPECT_EQ(outcomes[kPoses], IkOutcome::limits);
  }
}

}  // namespace
}  // namespace polyarm::kinematics
