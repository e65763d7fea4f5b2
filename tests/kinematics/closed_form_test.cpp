#include "polyarm/kinematics/closed_form.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "polyarm/description/catalogue.hpp"
#include "polyarm/kinematics/planar_form.hpp"
#include "tests/kinematics/sample_families.hpp"

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

}  // namespace
}  // namespace polyarm::kinematics
