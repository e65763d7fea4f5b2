/// The solver inside a control cycle.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "polyarm/ik/inverse_kinematics.hpp"
#include "tests/closed_form/sample_families.hpp"
#include "tests/kinematics/sample_states.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::ik {
namespace {

/// Every call but explain(): nothing is allocated, locked, thrown, waited for or written after construction.
TEST(InverseKinematics, IsFitForTheControlLoop) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers watch here";
  Random random(5);
  const auto any = test::random_arm(test::random_axes(ArmFamily::none, random), random);
  for (const auto& model : {test::ur3(), test::five(), test::seven(), test::gantry(), any}) {
    const Chain chain = test::chain_of(model);
    const InverseKinematics arm(chain);
    const auto q = test::random_state(chain, random), seed = test::random_state(chain, random),
               home = test::random_state(chain, random);
    const Pose reachable = chain.forward(q),
               singular = chain.forward(std::vector<double>(chain.joints(), 0.0));
    const std::array<Pose, 3> targets{reachable, singular, Pose{{9, 9, 9}, {}}};
    IkSolutions all;
    IkSolution one;
    std::array<IkSolution, 3> many;
    std::array<IkOutcome, 3> outcomes;
    std::string violations;
    {
      const test::RealtimeGuard guard;
      const int rounds = arm.way() == IkWay::closed_form ? 20000 : 100;
      for (int i = 0; i < rounds; ++i) {
        for (const Pose& target : targets) {
          arm.solve_all(target, seed, all);
          arm.solve(target, seed, one);
          arm.track(target, seed, one);
        }
        arm.solve_batch(targets, seed, many, outcomes);
      }
      for (int i = 0; i < 20; ++i)
        for (const Pose& target : targets) {
          arm.solve_move(target, seed, home, one);
          arm.solve(target, IkTask::position_only(), seed, one);
          arm.solve(target, IkTask::free_spin(), seed, one);
          arm.solve_all(target, IkTask::position_only(), seed, all);
        }
      violations = guard.violations();
    }
    EXPECT_EQ(violations, "") << model.name;
  }
}

}  // namespace
}  // namespace polyarm::ik
