#include "polyarm/kinematics/general_six.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/kinematics/sample_families.hpp"

namespace polyarm::kinematics {
namespace {

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
        double nearest = 1e9;
        for (std::size_t f = 0; f < count; ++f) {
          double worst = 0;
          for (std::size_t j = 0; j < 6; ++j)
            worst = std::max(worst, std::abs(std::remainder(found[f][j] - q[j], 2 * std::numbers::pi)));
          nearest = std::min(nearest, worst);
        }
        ++asked;
        missed += nearest > 1e-3;
      }
    }
  }
  EXPECT_LE(missed, asked / 100) << "of " << asked;
}

}  // namespace
}  // namespace polyarm::kinematics
