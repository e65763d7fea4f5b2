#include "polyarm/closed_form/spare_end.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/description/catalogue.hpp"
#include "polyarm/closed_form/eightfold_search.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/random.hpp"

namespace polyarm::kinematics {
namespace {

Chain chain_of(const char* name) {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  return Chain(model, model.tool_link());
}

/// Along the last axis (Franka), looked at eight values at a time, and along the first where only that suits.
TEST(SpareEnd, TheNearestIsExactInsideLimitsAndNoFurtherThanWhatSamplesShow) {
  for (const char* name : {"franka/fer_panda", "kuka/lbr_iiwa_7_r800"}) {
    const Chain chain = chain_of(name);
    const ik::InverseKinematics arm(chain);
    Random random(3);
    std::vector<double> q(7), seed(7);
    IkSolution nearest;
    IkSolutions all;
    int further = 0;
    for (int i = 0; i < 200; ++i) {
      for (std::size_t k = 0; k < 7; ++k) {
        q[k] = random_value(chain, k, random);
        seed[k] = random_value(chain, k, random);
      }
      const Pose target = chain.forward(q);
      ASSERT_EQ(arm.solve(target, seed, nearest), IkOutcome::solved) << name << ", pose " << i;
      const Pose there = chain.forward({nearest.q.data(), 7});
      EXPECT_LT(norm(there.position - target.position), 1e-8);
      EXPECT_LT(angle_between(there.rotation, target.rotation), 1e-7);
      for (std::size_t k = 0; k < 7; ++k) {
        EXPECT_GE(nearest.q[k], chain.lower()[k]);
        EXPECT_LE(nearest.q[k], chain.upper()[k]);
      }
      if (arm.solve_all(target, seed, all) != IkOutcome::solved) continue;
      further += nearest.distance > all[0].distance + 1e-6;
    }
    EXPECT_LE(further, 4) << name;
  }
}

TEST(SpareEnd, IsThereForFrankaAndNotForArmsOfSixAxes) {
  std::string why_not;
  const LaneLimits limits{};
  EXPECT_EQ(SpareEnd::of(*geometry_of(chain_of("franka/fer_panda"), why_not), limits)->axis(), 6u);
  EXPECT_FALSE(SpareEnd::of(*geometry_of(chain_of("universal_robots/ur5e"), why_not), limits));
}

TEST(EightfoldSearch, FindsTheLeastOfSmoothCostsInFewRoundsAndOfBrokenOnes) {
  const auto rounds_of = [](auto cost, double from, double reach, double least) {
    EightfoldSearch search(from, cost(from), reach);
    int rounds = 0;
    for (; search.going(1e-7); ++rounds) {
      double costs[EightfoldSearch::kValues];
      for (std::size_t k = 0; k < EightfoldSearch::kValues; ++k)
        costs[k] = cost(search.first() + static_cast<double>(k) * search.step());
      search.see(costs);
    }
    EXPECT_NEAR(search.best(), least, 2e-6);
    return rounds;
  };
  const auto smooth = [](double x) { return 3 + (x - 0.3) * (x - 0.3) + 0.2 * std::pow(x - 0.3, 3); };
  EXPECT_LE(rounds_of(smooth, 0.5, 0.3, 0.3), 6);
  const auto walled = [&](double x) { return x < 0.35 ? EightfoldSearch::kNowhere : smooth(x); };
  rounds_of(walled, 0.5, 0.3, 0.35);
}

}  // namespace
}  // namespace polyarm::kinematics
