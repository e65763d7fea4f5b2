// Poses near which solutions meet or are endlessly many.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/closed_form/closed_form.hpp"
#include "tests/closed_form/sample_families.hpp"
#include "tests/ik/asking.hpp"
#include "tests/ik/missed_once.hpp"

namespace polyarm::ik {
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

/// Beside a wrist's singularity, of eight states side by side.
TEST(NearSingular, TheLeastMotionsAreThoseOfTheJacobian) {
  const auto model = test::ur3();
  const Chain chain(model, test::tip_of(model));
  std::string why_not;
  const ArmGeometry geometry = *geometry_of(chain, why_not);
  const LaneArm lanes = lane_arm(geometry);
  Random random(56);
  for (int round = 0; round < 200; ++round) {
    std::array<std::vector<double>, kBranches> states;
    Branches at;
    for (std::size_t k = 0; k < kBranches; ++k) {
      states[k] = test::random_state(chain, random);
      states[k][4] = std::pow(10, random.between(-5, -2));
      for (std::size_t i = 0; i < 6; ++i) at.value[i][k] = states[k][i];
    }
    LeastMotions flat;
    find_least_motions(lanes, at, true, flat);
    for (std::size_t k = 0; k < kBranches; ++k) {
      std::array<double, 36> J;
      chain.jacobian(states[k], J);
      const auto moved = [&](const double(*way)[kBranches]) {
        double sum = 0;
        for (std::size_t row = 0; row < 6; ++row) {
          double part = 0;
          for (std::size_t i = 0; i < 6; ++i) part += J[6 * row + i] * way[i][k];
          sum += row < 3 ? part * part / (geometry.size() * geometry.size()) : part * part;
        }
        return std::sqrt(sum);
      };
      double across = 0;
      for (std::size_t i = 0; i < 6; ++i) across += flat.way[i][k] * flat.next_way[i][k];
      EXPECT_NEAR(across, 0, 5e-3);
      EXPECT_NEAR(moved(flat.way), flat.least[k], 0.01 * flat.least[k] + 1e-6);
      EXPECT_LT(flat.least[k], states[k][4]);
      EXPECT_LE(flat.least[k], flat.next[k]);
      EXPECT_NEAR(moved(flat.next_way), flat.next[k], 0.2 * flat.next[k]);
    }
  }
}

/// So stretched that they are long enough only with the spare axis within a hundredth of a radian of one
/// value.
TEST(NearSingular, SevenAxesReachAsFarAsTheyAreLong) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  for (const test::Missed& one : test::kStretched) {
    const auto model = catalogue.load(one.robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    const Pose target = chain.forward(one.q);
    IkSolutions found;
    ASSERT_EQ(arm.solve_all(target, one.seed, found), IkOutcome::solved) << one.robot;
    for (const IkSolution& each : found)
      EXPECT_LT(test::error_of(chain, {each.q.data(), chain.joints()}, target), 2e-9) << one.robot;
    IkSolution nearest;
    EXPECT_EQ(arm.solve(target, one.seed, nearest), IkOutcome::solved) << one.robot;
  }
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
  EXPECT_GT(near.asked, 500);
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
}  // namespace polyarm::ik
