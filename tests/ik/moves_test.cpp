#include "polyarm/ik/moves.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/kinematics/random.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "tests/ik/answers.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/sample_states.hpp"

namespace polyarm::ik {
namespace {

void expect_solves(const Chain& chain, const Pose& target, const test::Answer& result) {
  ASSERT_TRUE(result) << result.reason;
  const Pose reached = chain.forward(result.q);
  EXPECT_LT(norm(reached.position - target.position), 1e-6);
  EXPECT_LT(angle_between(reached.rotation, target.rotation), 1e-6);
  EXPECT_TRUE(result.reason.empty());
  for (std::size_t j = 0; j < result.q.size(); ++j) {
    EXPECT_GE(result.q[j], chain.lower()[j]);
    EXPECT_LE(result.q[j], chain.upper()[j]);
  }
}

double largest_change(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t j = 0; j < a.size(); ++j) most = std::max(most, std::abs(a[j] - b[j]));
  return most;
}

bool says(const test::Answer& result, const char* words) {
  return result.reason.find(words) != std::string::npos;
}

TEST(Moves, UndoesForwardOnEveryRandomReachablePose) {
  for (const auto& model : {test::ur3(), test::seven(), test::five()}) {
    const Chain chain = test::chain_of(model);
    Random random(4);
    for (int i = 0; i < 3000; ++i) {
      const Pose target = chain.forward(test::random_state(chain, random));
      expect_solves(chain, target, test::descend(chain, target, test::random_state(chain, random)));
    }
  }
}

TEST(Moves, SolvesWithMimicAndSlidingJointsAndLeavesOthersAlone) {
  const Chain chain = test::chain_of(test::gantry());
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    const Pose target = chain.forward(test::random_state(chain, random));
    auto seed = test::random_state(chain, random);
    seed[3] = 0.25;
    const test::Answer result = test::descend(chain, target, seed);
    expect_solves(chain, target, result);
    EXPECT_EQ(result.q[3], 0.25);
  }
}

TEST(Moves, PolishesFarBeyondTheTolerance) {
  const Chain chain = test::chain_of(test::ur3());
  Random random(6);
  int fine = 0;
  for (int i = 0; i < 1000; ++i) {
    const test::Answer result = test::descend(chain, chain.forward(test::random_state(chain, random)),
                                              test::random_state(chain, random));
    fine += result && result.position_error < 1e-9 && result.orientation_error < 1e-9;
  }
  EXPECT_GE(fine, 990);
}

TEST(Moves, ReachesSingularPoses) {
  const Chain chain = test::chain_of(test::ur3());
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    auto q = test::random_state(chain, random);
    q[4] = i % 2 ? 0 : M_PI;   // wrist
    if (i % 3 == 0) q[2] = 0;  // elbow
    const Pose target = chain.forward(q);
    const test::Answer result = test::descend(chain, target, test::random_state(chain, random));
    expect_solves(chain, target, result);
  }
}

TEST(Moves, TurnsComeNearestTheSeed) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> q{0.4, -1.2, 1.3, -1.5, -1.2, 0.3};
  for (const double turn : {-2 * M_PI, 2 * M_PI}) {
    auto seed = q;
    seed[5] = q[5] + turn * 0.99;
    const test::Answer result = test::descend(chain, chain.forward(q), seed);
    ASSERT_TRUE(result);
    EXPECT_NEAR(result.q[5], turn > 0 ? q[5] : q[5] + turn, 1e-6);  // 0.3 + 2 pi is beyond the limit
  }
}

TEST(Moves, SaysHowFarAwayAPointIs) {
  const Chain chain = test::chain_of(test::ur3());
  const test::Answer result = test::descend(chain, {{5, 1.7, 0.5}, {}}, std::vector<double>(6, 0.0));
  EXPECT_EQ(result.outcome, IkOutcome::unreachable);
  EXPECT_TRUE(says(result, "5.30 m from the base, this robot reaches 0.74 m")) << result.reason;
  EXPECT_NEAR(norm(chain.forward(result.q).position - Vec3{5, 1.7, 0.5}), result.position_error, 1e-9);
}

TEST(Moves, NamesTheJointWhoseLimitIsInTheWay) {
  auto model = test::ur3();
  const Chain free_chain = test::chain_of(model);
  const std::vector<double> q{0.5, -1.2, 1.5, -1.8, -1.5, 0.3};
  const Pose target = free_chain.forward(q);
  for (const std::size_t joint : {1, 2, 3}) {
    model.joints[joint].limits.lower = q[joint - 1] - 0.2;
    model.joints[joint].limits.upper = q[joint - 1] + 0.2;
  }
  model.joints[3].limits.upper = q[2] - 0.05;
  const test::Answer result = test::descend(test::chain_of(model), target, q);
  EXPECT_EQ(result.outcome, IkOutcome::limits);
  EXPECT_EQ(result.reason, "only with elbow 0.05 rad beyond its upper limit 1.45");
}

TEST(Moves, SaysWhenOnlyTheOrientationIsInTheWay) {
  const Chain chain = test::chain_of(test::five());
  Pose target = chain.forward(std::vector<double>{0, 0.4, -0.3, 0.5, 0.2});
  target.rotation = from_axis_angle({0, 0, 1}, 0.2) * target.rotation;  // no joint turns the tool sideways
  const test::Answer result = test::descend(chain, target, std::vector<double>(5, 0.1));
  EXPECT_EQ(result.outcome, IkOutcome::unreachable);
  EXPECT_TRUE(says(result, "the orientation cannot be reached at that place: ")) << result.reason;
  EXPECT_TRUE(test::descend(chain, target, std::vector<double>(5, 0.1), IkTask::position_only()));
}

TEST(Moves, EveryFailureHasAReasonAndNoStateOutsideLimits) {
  for (const auto& model : {test::ur3(), test::seven(), test::five(), test::gantry()}) {
    const Chain chain = test::chain_of(model);
    Random random(8);
    for (int i = 0; i < 40; ++i) {
      const Pose target{{random.between(-1.2, 1.2), random.between(-1.2, 1.2), random.between(-1, 1)},
                        from_rpy(random.between(-3, 3), random.between(-1.5, 1.5), random.between(-3, 3))};
      const test::Answer result = test::descend(chain, target, test::random_state(chain, random));
      EXPECT_EQ(result.reason.empty(), bool(result));
      ASSERT_EQ(result.q.size(), chain.joints());
      for (std::size_t j = 0; j < result.q.size(); ++j) {
        EXPECT_GE(result.q[j], chain.lower()[j]);
        EXPECT_LE(result.q[j], chain.upper()[j]);
      }
    }
  }
}

TEST(Moves, SurvivesPosesAndSeedsThatAreNone) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> seed(6, 0.1), broken{0, NAN, INFINITY, -1e300, 0, 0};
  EXPECT_FALSE(test::descend(chain, {{NAN, 0, 0}, {}}, seed));
  EXPECT_FALSE(test::descend(chain, {{1e300, 0, 0}, {}}, seed));
  EXPECT_FALSE(test::descend(chain, {{0.2, 0, 0}, {0, 0, 0, 0}}, seed));
  EXPECT_FALSE(test::descend(chain, {{0.2, 0, 0}, {}}, std::vector<double>(5)));
  EXPECT_FALSE(test::move(chain, {{0, 0, INFINITY}, {}}, seed, seed));
  EXPECT_TRUE(test::all_of(chain, {{NAN, 0, 0}, {}}, seed).empty());
  const Pose target = chain.forward(std::vector<double>{0.4, -1.2, 1.3, -1.5, -1.2, 0.3});
  expect_solves(chain, target, test::descend(chain, target, broken));
  const Pose longer{
      target.position,
      {3 * target.rotation.x, 3 * target.rotation.y, 3 * target.rotation.z, 3 * target.rotation.w}};
  expect_solves(chain, target, test::descend(chain, longer, seed));
}

TEST(Moves, IsDeterministic) {
  const Chain chain = test::chain_of(test::seven());
  const Pose target = chain.forward(std::vector<double>{0.3, 0.5, -0.4, 1.2, 0.3, 0.7, 0.1});
  const std::vector<double> seed(7, 0.0);
  EXPECT_EQ(test::descend(chain, target, seed).q, test::descend(chain, target, seed).q);
  EXPECT_EQ(test::all_of(chain, target, seed), test::all_of(chain, target, seed));
}

TEST(Moves, PartsOfPosesAreSolvedOrRefusedInWords) {
  const Chain chain = test::chain_of(test::ur3());
  const InverseKinematics arm(chain);
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3}, seed(6, 0.3);
  Pose target = chain.forward(q);
  target.rotation = target.rotation * from_axis_angle({0, 0, 1}, 0.7);
  const test::Answer spun = test::descend(arm, target, seed, IkTask::free_spin());
  ASSERT_TRUE(spun) << spun.reason;
  EXPECT_LT(norm(chain.forward(spun.q).position - target.position), 1e-5);
  IkTask box;
  for (std::size_t row = 0; row < 3; ++row) box.low[row] = -0.05, box.high[row] = 0.05;
  Pose outside = chain.forward(std::vector<double>{0, 0, 0, 0, -1.5, 0});
  outside.position = outside.position + 0.03 * normalized(outside.position - Vec3{0, 0, 0.15});
  EXPECT_TRUE(test::descend(arm, outside, seed, box));
  EXPECT_FALSE(test::descend(arm, {{4, 0, 0}, {}}, seed, IkTask::position_only()));
  EXPECT_NE(
      test::descend(arm, {{4, 0, 0}, {}}, seed, IkTask::position_only()).reason.find("this robot reaches"),
      std::string::npos);
  const test::Answer far = test::descend(arm, {{4, 0, 0}, {}}, seed, box);
  EXPECT_EQ(far.outcome, IkOutcome::unreachable);
  EXPECT_NE(far.reason, "");
  box.low[4] = 1;
  EXPECT_NE(test::descend(arm, target, seed, box).reason.find("about y"), std::string::npos);
}

TEST(Moves, TheNearestOfAFailureIsTheBestOfAFewerJointedArm) {
  const Chain chain = test::chain_of(test::five());
  Random random(12);
  for (int i = 0; i < 50; ++i) {
    const auto q = test::random_state(chain, random);
    Pose target = chain.forward(q);
    target.rotation = from_axis_angle({0, 0, 1}, 0.1) * target.rotation;
    const test::Answer result = test::descend(chain, target, test::random_state(chain, random));
    if (result) continue;
    // As good as where the question came from: 0.1 rad beside it, at 1 m per rad.
    EXPECT_LT(std::hypot(result.position_error, result.orientation_error), 0.1 + 1e-3);
  }
}

TEST(Moves, FindsAllEightOfAUr3NearestFirst) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3};
  const Pose target = chain.forward(q);
  const auto found = test::all_of(chain, target, q);
  ASSERT_EQ(found.size(), 8u);
  EXPECT_LT(largest_change(found[0], q), 1e-6);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LT(norm(chain.forward(found[i]).position - target.position), 1e-6);
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT(largest_change(found[i], found[k]), 1e-3);
  }
}

TEST(Moves, NearestKeepsTheConfigurationAlongAPath) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> home{0.0, -1.2, 1.5, -1.87, -1.57, 0.0};
  std::vector<double> at = home;
  const Pose start = chain.forward(home);
  for (int i = 0; i < 60; ++i) {
    Pose target = start;
    target.position.x += 0.05 * std::sin(0.3 * i);
    target.position.z += 0.03 * std::cos(0.2 * i) - 0.03;
    const test::Answer result = test::move(chain, target, at, home);
    expect_solves(chain, target, result);
    EXPECT_LT(largest_change(result.q, at), 0.5);
    at = result.q;
  }
}

TEST(Moves, NearestIsTheNearestOfAll) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> home{0.0, -1.2, 1.5, -1.87, -1.57, 0.0};
  Random random(9);
  for (int i = 0; i < 50; ++i) {
    const auto current = test::random_state(chain, random);
    const Pose target = chain.forward(test::random_state(chain, random));
    const test::Answer result = test::move(chain, target, current, home);
    expect_solves(chain, target, result);
    const auto all = test::all_of(chain, target, current);
    const auto distance = [&](const std::vector<double>& q) {
      double sum = 0;
      for (std::size_t j = 0; j < q.size(); ++j) sum += (q[j] - current[j]) * (q[j] - current[j]);
      return std::sqrt(sum);
    };
    if (largest_change(result.q, current) <= InverseKinematics::kNearby) continue;
    for (const auto& other : all) {
      if (smallest_singular_value(chain, other) < kSingular) continue;
      EXPECT_LE(distance(result.q), distance(other) + 1e-5);
    }
  }
}

TEST(Moves, TheSingularValueVanishesAtSingularPosesOnly) {
  const Chain ur3 = test::chain_of(test::ur3());
  EXPECT_LT(smallest_singular_value(ur3, std::vector<double>{0.4, -1.2, 1.3, -1.5, 0, 0.3}), 1e-7);
  EXPECT_GT(smallest_singular_value(ur3, std::vector<double>{0.4, -1.2, 1.3, -1.5, -1.2, 0.3}), 0.05);
  const Chain five = test::chain_of(test::five());
  EXPECT_GT(smallest_singular_value(five, std::vector<double>{0, 0.4, -0.3, 0.5, 0.2}), 0.02);
}

}  // namespace
}  // namespace polyarm::ik
