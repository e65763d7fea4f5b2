#include "polyarm/closed_form/general_six.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "tests/closed_form/sample_families.hpp"

namespace polyarm::kinematics {
namespace {

bool among(std::span<const GeneralSix::State> found, const GeneralSix::State& q) {
  return std::any_of(found.begin(), found.end(), [&](const GeneralSix::State& other) {
    double worst = 0;
    for (std::size_t j = 0; j < 6; ++j)
      worst = std::max(worst, std::abs(std::remainder(other[j] - q[j], 2 * std::numbers::pi)));
    return worst < 1e-3;
  });
}

TEST(GeneralSix, FindsTheStateThatAPoseWasMadeFrom) {
  Random random(51);
  int asked = 0, missed = 0;
  for (int i = 0; i < 50; ++i) {
    const auto model = test::random_arm(test::random_axes(ArmFamily::none, random), random);
    std::string why;
    const ArmGeometry arm = *geometry_of(Chain(model, test::tip_of(model)), why);
    for (const bool from_tool : {false, true}) {
      const GeneralSix six(arm, from_tool);
      for (int k = 0; k < 20; ++k) {
        GeneralSix::State q;
        for (double& value : q) value = random.between(-3, 3);
        PoseTarget target;
        arm.forward(q, target.rotation, target.position);
        std::array<GeneralSix::State, GeneralSix::kMost> found;
        const std::size_t count = six.solve(target, found);
        ++asked;
        missed += !among({found.data(), count}, q);
      }
    }
  }
  EXPECT_LE(missed, asked / 100) << "of " << asked;
}

TEST(GeneralSix, TellsFromOneStateWhatSolvingPosesWouldTell) {
  Random random(52);
  int found_it = 0, never = 0;
  std::array<GeneralSix::State, GeneralSix::kMost> found;
  for (int i = 0; i < 10; ++i)
    for (int family = 0; family <= static_cast<int>(ArmFamily::none); ++family) {
      const auto model = test::random_arm(test::random_axes(static_cast<ArmFamily>(family), random), random);
      std::string why;
      const ArmGeometry arm = *geometry_of(Chain(model, test::tip_of(model)), why);
      for (const bool from_tool : {false, true}) {
        GeneralSix tried(arm, from_tool, false);
        const GeneralSix six(arm, from_tool);
        for (int k = 0; k < 4; ++k) {
          GeneralSix::State q;
          for (double& value : q) value = random.between(-3, 3);
          PoseTarget target;
          arm.forward(q, target.rotation, target.position);
          const GeneralSix::Finds told = tried.finds(q, target, 1e-3);
          const std::size_t count = six.solve(target, found);
          EXPECT_EQ(told == GeneralSix::Finds::it, among({found.data(), count}, q)) << family;
          if (told == GeneralSix::Finds::nothing_ever) {
            EXPECT_EQ(count, 0U) << family;
          }
          found_it += told == GeneralSix::Finds::it;
          never += told == GeneralSix::Finds::nothing_ever;
        }
      }
    }
  EXPECT_GT(found_it, 200);
  EXPECT_GT(never, 200);
}

}  // namespace
}  // namespace polyarm::kinematics
