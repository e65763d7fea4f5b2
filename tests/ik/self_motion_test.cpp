#include "polyarm/ik/self_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/kinematics/singularity.hpp"

namespace polyarm::ik {
namespace {

constexpr const char* kSearched[] = {"rethink_robotics/sawyer", "flexiv/rizon_4",
                                     "kawada/nextage_open_left_arm"};
constexpr const char* kByValues[] = {"ufactory/xarm_7", "franka/fr3"};

Chain chain_of(const std::string& name) {
  const auto model = description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load(name);
  return Chain(model, model.tool_link());
}

std::vector<double> drawn(const Chain& chain, Random& random) {
  std::vector<double> q;
  for (std::size_t k = 0; k < chain.joints(); ++k) q.push_back(random_value(chain, k, random));
  return q;
}

void expect_answer(const Chain& chain, const Pose& target, const IkSolution& one, const std::string& what) {
  const Pose there = chain.forward({one.q.data(), chain.joints()});
  EXPECT_LT(norm(there.position - target.position), 2e-9) << what;
  EXPECT_LT(angle_between(there.rotation, target.rotation), 2e-8) << what;
  for (std::size_t k = 0; k < chain.joints(); ++k) {
    if (!chain.moves_tcp(k)) continue;
    EXPECT_GE(one.q[k], chain.lower()[k]) << what;
    EXPECT_LE(one.q[k], chain.upper()[k]) << what;
  }
}

/// Of `poses` how often samples of the spare axis hold an answer that is nearer, and how much nearer to the
/// seed the answers are on the average.
struct Compared {
  int further = 0;
  double gained = 0;
};
Compared compare(const std::string& name, int poses, const IkSettings& settings) {
  const Chain chain = chain_of(name);
  const InverseKinematics arm(chain, settings);
  Random random(3);
  IkSolution nearest;
  IkSolutions all;
  Compared out;
  for (int i = 0; i < poses; ++i) {
    const std::vector<double> q = drawn(chain, random), seed = drawn(chain, random);
    const Pose target = chain.forward(q);
    const std::string what = name + ", pose " + std::to_string(i);
    EXPECT_EQ(arm.solve(target, seed, nearest), IkOutcome::solved) << what;
    expect_answer(chain, target, nearest, what);
    if (arm.solve_all(target, seed, all) != IkOutcome::solved) continue;
    out.further += nearest.distance > all[0].distance + 1e-6;
    out.gained += (all[0].distance - nearest.distance) / poses;
  }
  return out;
}

/// Of a searched arm samples are no longer what solve_all() looks at: descents from many seeds are.
TEST(SelfMotion, TheNearestOfASearchedArmIsExactInsideLimitsAndNoFurtherThanWhatManyDescentsShow) {
  for (const char* name : kSearched) {
    const Chain chain = chain_of(name);
    const InverseKinematics arm(chain);
    NumericSettings settings;
    settings.searches = 400;
    const NumericIk descents(chain, settings);
    Random random(3);
    IkSolution nearest;
    IkSolutions all;
    int further = 0;
    double gained = 0;
    constexpr int kPoses = 200;
    for (int i = 0; i < kPoses; ++i) {
      const std::vector<double> q = drawn(chain, random), seed = drawn(chain, random);
      const Pose target = chain.forward(q);
      const std::string what = std::string(name) + ", pose " + std::to_string(i);
      ASSERT_EQ(arm.solve(target, seed, nearest), IkOutcome::solved) << what;
      expect_answer(chain, target, nearest, what);
      if (descents.solve_all(target, seed, all) != IkOutcome::solved) continue;
      further += nearest.distance > all[0].distance + 1e-6;
      gained += (all[0].distance - nearest.distance) / kPoses;
    }
    EXPECT_LE(further, 4) << name;
    EXPECT_GT(gained, 0) << name;
  }
}

TEST(SelfMotion, SoIsThatOfAnArmThatIsNotQuiteIdeal) {
  const Compared found = compare("kinova/gen3_7dof", 400, {});
  EXPECT_LE(found.further, 2);
  EXPECT_GT(found.gained, 0.01);
}

/// The nearest of arms that are solved at values of their last axis, some side by side, is rarely another
/// one.
TEST(SelfMotion, ThatOfAnArmSolvedAtValuesOfAnAxisIsSeldomFurther) {
  for (const char* name : kByValues) {
    const Compared found = compare(name, 400, {});
    EXPECT_LE(found.further, 12) << name;
    EXPECT_GT(found.gained, 0.01) << name;
  }
}

TEST(SelfMotion, WeightsSayWhatIsNear) {
  IkSettings settings;
  settings.weights = {0.2, 1, 3, 1, 0.5, 1, 2};
  const Compared found = compare("kinova/gen3_7dof", 400, settings);
  EXPECT_LE(found.further, 3);
  EXPECT_GT(found.gained, 0.01);
}

/// The state itself is one that leads there.
TEST(SelfMotion, FromASeedNearbyNothingIsFurtherThanTheStateThatThePoseIsOf) {
  for (const char* name : kSearched) {
    const Chain chain = chain_of(name);
    const InverseKinematics arm(chain);
    Random random(5);
    IkSolution one;
    int further = 0;
    for (int i = 0; i < 500; ++i) {
      const std::vector<double> q = drawn(chain, random), aside = drawn(chain, random);
      std::vector<double> seed = q;
      double away2 = 0;
      const double part = i % 2 == 0 ? 0.001 : 0.04;
      for (std::size_t k = 0; k < q.size(); ++k) {
        seed[k] += part * (aside[k] - q[k]);
        if (chain.moves_tcp(k)) away2 += (seed[k] - q[k]) * (seed[k] - q[k]);
      }
      const Pose target = chain.forward(q);
      ASSERT_EQ(arm.solve(target, seed, one), IkOutcome::solved) << name << ", pose " << i;
      expect_answer(chain, target, one, name);
      further += one.distance > std::sqrt(away2) + 1e-6;
    }
    EXPECT_LE(further, 1) << name;
  }
}

/// Most of a curve's states are none that a sample would show, and nearly all that samples show are near one.
TEST(SelfMotion, AllSolutionsOfASearchedArmAreSpreadOverItsCurves) {
  for (const char* name : kSearched) {
    const Chain chain = chain_of(name);
    const InverseKinematics arm(chain);
    Random random(11);
    IkSolutions all;
    IkSolution nearest;
    std::size_t found = 0, near_own = 0;
    constexpr int kPoses = 60;
    for (int i = 0; i < kPoses; ++i) {
      const std::vector<double> q = drawn(chain, random), seed = drawn(chain, random);
      const Pose target = chain.forward(q);
      ASSERT_EQ(arm.solve_all(target, q, all), IkOutcome::solved) << name << ", pose " << i;
      const auto is_near = [&](const IkSolution& one) {
        double most = 0;
        for (std::size_t k = 0; k < q.size(); ++k)
          if (chain.moves_tcp(k)) most = std::max(most, std::abs(one.q[k] - q[k]));
        return most < 0.3;
      };
      near_own += std::any_of(all.begin(), all.end(), is_near);
      ASSERT_EQ(arm.solve_all(target, seed, all), IkOutcome::solved) << name << ", pose " << i;
      arm.solve(target, seed, nearest);
      EXPECT_LE(all[0].distance, nearest.distance + 1e-6);
      for (const IkSolution& one : all) {
        expect_answer(chain, target, one, name);
        if (&one != all.begin()) {
          EXPECT_GE(one.distance, (&one - 1)->distance);
        }
      }
      found += all.count;
    }
    EXPECT_GE(found, kPoses * 10u) << name;
    EXPECT_GE(near_own, kPoses - 1u) << name;
  }
}

TEST(SelfMotion, TheSameQuestionHasTheSameAnswer) {
  const Chain chain = chain_of("rethink_robotics/sawyer");
  const InverseKinematics arm(chain), other(chain);
  Random random(7);
  IkSolution one, two;
  for (int i = 0; i < 50; ++i) {
    const std::vector<double> q = drawn(chain, random), seed = drawn(chain, random);
    const Pose target = chain.forward(q);
    arm.solve(target, seed, one);
    other.solve(target, seed, two);
    EXPECT_TRUE(std::equal(one.q.begin(), one.q.begin() + static_cast<std::ptrdiff_t>(chain.joints()),
                           two.q.begin()));
  }
}

TEST(SelfMotion, SeedsFarOutsideOfLimitsHaveAnswersToo) {
  const Chain chain = chain_of("kinova/gen3_7dof");
  const InverseKinematics arm(chain);
  Random random(9);
  IkSolution one;
  for (const double far : {20.0, 3e4, 1e8}) {
    const std::vector<double> q = drawn(chain, random);
    std::vector<double> seed = drawn(chain, random);
    for (double& value : seed) value += far;
    const Pose target = chain.forward(q);
    EXPECT_EQ(arm.solve(target, seed, one), IkOutcome::solved) << far;
    if (far < 1e3) expect_answer(chain, target, one, "far");
  }
}

TEST(SelfMotion, IsNoWayForSixAxes) {
  const Chain chain = chain_of("universal_robots/ur5e");
  std::string why_not;
  const NumericIk numeric(chain);
  EXPECT_FALSE(SelfMotion::of(numeric.core(), *geometry_of(chain, why_not), LaneLimits{}, true));
}

}  // namespace
}  // namespace polyarm::ik
