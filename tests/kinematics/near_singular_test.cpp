// Poses near which solutions meet or are endlessly many.
#include <gtest/gtest.h>

#include "polyarm/description/catalogue.hpp"
#include "tests/kinematics/asking.hpp"
#include "tests/kinematics/missed_once.hpp"
#include "tests/kinematics/sample_families.hpp"

namespace polyarm::kinematics {
namespace {

TEST(NearSingular, FindsAgainWhatWasMissedOnce) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  test::Tally tally;
  for (const test::Missed& one : test::kMissedOnce) {
    const auto model = catalogue.load(one.robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    test::ask(chain, arm, one.q, one.seed.empty() ? one.q : one.seed, one.robot, tally);
  }
  EXPECT_EQ(tally.missed, 0) << "of " << tally.asked;
  test::expect_clean(tally);
}

/// Joints at multiples of 90 degrees and a little off: wrists, elbows and shoulders nearly singular at once.
TEST(NearSingular, FindsStatesOfTheCatalogueBesideTheirSingularities) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(51);
  test::Tally exact, near;
  for (const std::string& robot : catalogue.names()) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    if (!arm || arm.way() != IkWay::closed_form) continue;
    test::Tally& tally = arm.report().find("true within") == std::string::npos ? exact : near;
    for (int i = 0; i < test::poses_per_arm(100); ++i)
      test::ask(chain, arm, test::near_singular_state(chain, random), test::random_state(chain, random),
                robot, tally);
  }
  EXPECT_EQ(exact.missed, 0) << "of " << exact.asked;
  EXPECT_LE(near.missed, near.asked / 2000) << "of " << near.asked;
  EXPECT_GT(near.asked, 2000);
  test::expect_clean(exact);
  test::expect_clean(near);
}

/// Near a singular pose a calibrated arm has left a few of the family that the ideal arm has there.
TEST(NearSingular, CalibratedArmsKeepTheirBranchesBesideSingularities) {
  Random random(52);
  test::Tally tally;
  for (const double size : {1e-5, 1e-4, 4e-4}) {
    for (const ArmFamily family : {ArmFamily::wrist_2_parallel_3, ArmFamily::parallel_234_5_meets_6}) {
      for (int i = 0; i < 20; ++i) {
        const auto axes = test::spoiled(test::random_axes(family, random), size, random);
        const Chain chain = test::chain_of(test::random_arm(axes, random));
        const InverseKinematics arm(chain);
        if (arm.family() != family) continue;  // spoiled too much for so small an arm
        for (int k = 0; k < 60; ++k) {
          auto q = test::random_state(chain, random);
          // Where axes 4 and 6 (of three parallel axes: 2 and 6) are as near to parallel as they can be.
          const Vec3 held = axes[family == ArmFamily::wrist_2_parallel_3 ? 3 : 1].direction;
          double best = -1, at = 0;
          for (int step = 0; step < 4000; ++step) {
            const double value = -3 + 6.0 * step / 4000;
            const double along =
                std::abs(dot(held, from_axis_angle(axes[4].direction, value) * axes[5].direction));
            if (along > best) best = along, at = value;
          }
          q[4] = std::clamp(at + random.between(-20, 20) * size, -3.0, 3.0);
          test::ask(chain, arm, q, test::random_state(chain, random), describe(family), tally);
        }
      }
    }
  }
  EXPECT_GT(tally.asked, 5000);
  EXPECT_LE(tally.missed, tally.asked / 300) << "of " << tally.asked;
  test::expect_clean(tally);
}

}  // namespace
}  // namespace polyarm::kinematics
