#include "polyarm/closed_form/spare_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/closed_form/curve_dips.hpp"
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

/// What a tick needs: the solution beside the seed, not another one.
TEST(SpareEnd, ASeedBesideASolutionHasOneNoFurther) {
  for (const char* name : {"franka/fer_panda", "kuka/lbr_iiwa_7_r800"}) {
    const Chain chain = chain_of(name);
    const ik::InverseKinematics arm(chain);
    Random random(4);
    std::vector<double> q(7), seed(7);
    IkSolution nearest;
    int further = 0;
    for (int i = 0; i < 1000; ++i) {
      double distance2 = 0;
      for (std::size_t k = 0; k < 7; ++k) {
        q[k] = random_value(chain, k, random);
        seed[k] = std::clamp(q[k] + random.between(-0.05, 0.05), chain.lower()[k], chain.upper()[k]);
        distance2 += (q[k] - seed[k]) * (q[k] - seed[k]);
      }
      ASSERT_EQ(arm.solve(chain.forward(q), seed, nearest), IkOutcome::solved) << name << ", pose " << i;
      further += nearest.distance > std::sqrt(distance2) + 1e-3;
    }
    EXPECT_LE(further, 3) << name;
  }
}

/// Two curves over one variable, cos on one and its opposite shifted up on the other; nothing in the middle.
TEST(Dips, EachCurveHasItsOwnNearestFirst) {
  constexpr std::size_t kCount = 24;
  std::array<double, kCount> costs, state;
  for (std::size_t k = 0; k < kCount; ++k) {
    const double at = 2 * std::numbers::pi * static_cast<double>(k) / kCount;
    const bool other = k >= 12;
    costs[k] = k == 12 || k == 13 ? Dips<8>::kNowhere : 3 + std::cos(at) + (other ? 0.1 : 0.0);
    state[k] = other ? 5 + 0.1 * static_cast<double>(k) : 0.1 * static_cast<double>(k);
  }
  Dips<8>::Rows rows;
  rows.fill(state.data());
  std::array<Dips<8>::State, 8> found;
  Dips<8> dips(found);
  dips.take_all(costs.data(), rows, kCount, true);
  // The ends towards the gap are the least of both; the other ends join at the beginning, where both rise.
  ASSERT_EQ(dips.count(), 2u);
  EXPECT_EQ(found[0][3], state[11]);
  EXPECT_EQ(found[1][3], state[14]);
  std::array<Dips<1>::State, 1> nearest;
  Dips<1> one(nearest);
  one.take_all(costs.data(), rows, kCount, true);
  ASSERT_EQ(one.count(), 1u);
  EXPECT_EQ(nearest[0][0], state[11]);
}

}  // namespace
}  // namespace polyarm::kinematics
