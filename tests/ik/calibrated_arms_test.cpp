// Arms whose axes are where a maker's calibration finds them: up to 5 mrad and 2 mm off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/catalogue/catalogue.hpp"
#include "tests/ik/asking.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/unseen_arms.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::ik {
namespace {

constexpr const char* kArms[] = {
    "universal_robots/ur3", "universal_robots/ur5", "universal_robots/ur10e",
    "abb/irb_120",          "fanuc/er_4ia",         "kuka/kr_6_r700_2",
    "staubli/tx2_60l",      "doosan/m0609",         "mitsubishi_electric/rv_8crl"};
constexpr const char* kFiveAxes[] = {"fanuc/lr_mate_200ic_5h", "trossen_robotics/px150", "ufactory/xarm5"};

/// Tilts each axis by up to `mrad` and moves it by up to 0.4 mm for each of these.
description::RobotModel calibrated(const char* robot, double mrad, Random& random) {
  auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(robot);
  for (description::Joint& joint : model.joints) {
    if (!joint.moves()) continue;
    joint.origin.rotation = from_axis_angle(test::random_direction(random), 1e-3 * random.between(0, mrad)) *
                            joint.origin.rotation;
    joint.origin.position =
        joint.origin.position + 4e-4 * random.between(0, mrad) * test::random_direction(random);
  }
  return model;
}

Chain chain_of(const description::RobotModel& model) {
  return Chain(model, model.tool_link());
}

/// Counts of solve() beside solve_all().
struct Nearest {
  int asked = 0, unsolved = 0, wrong = 0, further = 0;
  void ask(const Chain& chain, const InverseKinematics& arm, std::span<const double> q,
           std::span<const double> seed) {
    const Pose target = chain.forward(q);
    IkSolution one;
    IkSolutions all;
    ++asked;
    if (arm.solve(target, seed, one) != IkOutcome::solved) {
      ++unsolved;
      return;
    }
    const std::span<const double> values(one.q.data(), chain.joints());
    wrong += !one.exact || test::error_of(chain, values, target) > 2e-9;
    for (std::size_t j = 0; j < chain.joints(); ++j)
      wrong += values[j] < chain.lower()[j] || values[j] > chain.upper()[j];
    arm.solve_all(target, seed, all);
    further += all.count > 0 && one.distance > all[0].distance + 1e-3;
  }
};

TEST(CalibratedArms, TheNearestIsExactWithinLimitsAndHardlyEverFurtherThanTheNearestOfAll) {
  Random random(71);
  for (const double mrad : {0.5, 5.0}) {
    Nearest tally;
    for (const char* robot : kArms) {
      const Chain chain = chain_of(calibrated(robot, mrad, random));
      const InverseKinematics arm(chain);
      for (int i = 0; i < test::poses_per_arm(150); ++i)
        tally.ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random));
    }
    EXPECT_EQ(tally.unsolved, 0) << mrad << " mrad, of " << tally.asked;
    EXPECT_EQ(tally.wrong, 0) << mrad << " mrad, of " << tally.asked;
    EXPECT_LE(tally.further, tally.asked / 200) << mrad << " mrad, of " << tally.asked;
  }
}

/// Also beside singularities, where the ideal arm's branches are others than the true arm's.
TEST(CalibratedArms, ASeedBesideASolutionHasThatSolution) {
  Random random(72);
  int asked = 0, strayed = 0;
  for (const double mrad : {0.5, 5.0})
    for (const char* robot : kArms) {
      const Chain chain = chain_of(calibrated(robot, mrad, random));
      const InverseKinematics arm(chain);
      for (int i = 0; i < 100; ++i) {
        const auto q = i % 2 ? test::near_singular_state(chain, random) : test::random_state(chain, random);
        const auto seed = test::nearby_state(chain, q, 0.02, random);
        IkSolution one;
        ++asked;
        // The seed is up to 0.05 rad away.
        strayed +=
            arm.solve(chain.forward(q), seed, one) != IkOutcome::solved || !one.exact || one.distance > 0.1;
      }
    }
  EXPECT_LE(strayed, asked / 900) << "of " << asked;
}

TEST(CalibratedArms, AllBranchesAreFound) {
  Random random(73);
  for (const double mrad : {0.5, 5.0}) {
    test::Tally tally;
    for (const char* robot : kArms) {
      const Chain chain = chain_of(calibrated(robot, mrad, random));
      const InverseKinematics arm(chain);
      for (int i = 0; i < test::poses_per_arm(60); ++i)
        test::ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random), robot,
                  tally);
    }
    EXPECT_LE(tally.missed, tally.asked / 500) << mrad << " mrad, of " << tally.asked;
    test::expect_clean(tally);
  }
}

/// Six axes of which one stands still may lead nowhere; iteration then has the last word.
TEST(CalibratedArms, FiveAxesReachEveryPoseOfTheirs) {
  Random random(74);
  for (const double mrad : {1.0, 5.0}) {
    Nearest tally;
    for (const char* robot : kFiveAxes) {
      const Chain chain = chain_of(calibrated(robot, mrad, random));
      const InverseKinematics arm(chain);
      for (int i = 0; i < 300; ++i)
        tally.ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random));
    }
    EXPECT_EQ(tally.unsolved, 0) << mrad << " mrad, of " << tally.asked;
    EXPECT_EQ(tally.wrong, 0) << mrad << " mrad, of " << tally.asked;
  }
}

TEST(CalibratedArms, AreSolvedInTheControlCycle) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers watch here";
  Random random(75);
  for (const double mrad : {0.5, 5.0}) {
    const Chain chain = chain_of(calibrated("universal_robots/ur5", mrad, random));
    const InverseKinematics arm(chain);
    std::vector<std::vector<double>> seeds;
    std::vector<Pose> targets;
    for (int i = 0; i < 100; ++i) {
      targets.push_back(chain.forward(test::near_singular_state(chain, random)));
      seeds.push_back(test::random_state(chain, random));
    }
    IkSolution one;
    IkSolutions all;
    std::string violations;
    {
      const test::RealtimeGuard guard;
      for (std::size_t i = 0; i < targets.size(); ++i) {
        arm.solve(targets[i], seeds[i], one);
        arm.solve_all(targets[i], seeds[i], all);
      }
      violations = guard.violations();
    }
    EXPECT_EQ(violations, "") << mrad;
  }
}

}  // namespace
}  // namespace polyarm::ik
