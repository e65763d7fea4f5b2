#include "polyarm/kinematics/closed_form.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

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
