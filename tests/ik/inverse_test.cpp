#include "polyarm/ik/inverse.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/ik/arm_solver.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/kinematics/random.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/sample_states.hpp"

namespace polyarm::kinematics {
namespace {

void expect_solves(const Chain& chain, const Pose& target, const IkResult& result) {
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

bool says(const IkResult& result, const char* words) {
  return result.reason.find(words) != std::string::npos;
}

TEST(Inverse, UndoesForwardOnEveryRandomReachablePose) {
  for (const auto& model : {test::ur3(), test::seven(), test::five()}) {
    const Chain chain = test::chain_of(model);
    Random random(4);
    for (int i = 0; i < 3000; ++i) {
      const Pose target = chain.forward(test::random_state(chain, random));
      expect_solves(chain, target, solve_inverse(chain, target, test::random_state(chain, random)));
    }
  }
}

TEST(Inverse, SolvesWithMimicAndSlidingJointsAndLeavesOthersAlone) {
  const Chain chain = test::chain_of(test::gantry());
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    const Pose target = chain.forward(test::random_state(chain, random));
    auto seed = test::random_state(chain, random);
    seed[3] = 0.25;
    const IkResult result = solve_inverse(chain, target, seed);
    expect_solves(chain, target, result);
    EXPECT_EQ(result.q[3], 0.25);
  }
}

TEST(Inverse, PolishesFarBeyondTheTolerance) {
  const Chain chain = test::chain_of(test::ur3());
  Random random(6);
  int fine = 0;
  for (int i = 0; i < 1000; ++i) {
    const IkResult result = solve_inverse(chain, chain.forward(test::random_state(chain, random)),
                                          test::random_state(chain, random));
    fine += result && result.position_error < 1e-9 && result.orientation_error < 1e-9;
  }
  EXPECT_GE(fine, 990);
}

TEST(Inverse, ReachesSingularPoses) {
  const Chain chain = test::chain_of(test::ur3());
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    auto q = test::random_state(chain, random);
    q[4] = i % 2 ? 0 : M_PI;   // wrist
    if (i % 3 == 0) q[2] = 0;  // elbow
    const Pose target = chain.forward(q);
    const IkResult result = solve_inverse(chain, target, test::random_state(chain, random));
    expect_solves(chain, target, result);
  }
}

TEST(Inverse, TurnsComeNearestTheSeed) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> q{0.4, -1.2, 1.3, -1.5, -1.2, 0.3};
  for (const double turn : {-2 * M_PI, 2 * M_PI}) {
    auto seed = q;
    seed[5] = q[5] + turn * 0.99;
    const IkResult result = solve_inverse(chain, chain.forward(q), seed);
    ASSERT_TRUE(result);
    EXPECT_NEAR(result.q[5], turn > 0 ? q[5] : q[5] + turn, 1e-6);  // 0.3 + 2 pi is beyond the limit
  }
}

TEST(Inverse, SaysHowFarAwayAPointIs) {
  const Chain chain = test::chain_of(test::ur3());
  const IkResult result = solve_inverse(chain, {{5, 1.7, 0.5}, {}}, std::vector<double>(6, 0.0));
  EXPECT_EQ(result.status, IkStatus::unreachable);
  EXPECT_TRUE(says(result, "5.30 m from the base, this robot reaches 0.74 m")) << result.reason;
  EXPECT_NEAR(norm(chain.forward(result.q).position - Vec3{5, 1.7, 0.5}), result.position_error, 1e-9);
}

TEST(Inverse, NamesTheJointWhoseLimitIsInTheWay) {
  auto model = test::ur3();
  const Chain free_chain = test::chain_of(model);
  const std::vector<double> q{0.5, -1.2, 1.5, -1.8, -1.5, 0.3};
  const Pose target = free_chain.forward(q);
  for (const std::size_t joint : {1, 2, 3}) {
    model.joints[joint].limits.lower = q[joint - 1] - 0.2;
    model.joints[joint].limits.upper = q[joint - 1] + 0.2;
  }
  model.joints[3].limits.upper = q[2] - 0.05;
  const IkResult result = solve_inverse(test::chain_of(model), target, q);
  EXPECT_EQ(result.status, IkStatus::limits);
  EXPECT_EQ(result.reason, "only with elbow 0.05 rad beyond its upper limit 1.45");
}

TEST(Inverse, SaysWhenOnlyTheOrientationIsInTheWay) {
  const Chain chain = test::chain_of(test::five());
  Pose target = chain.forward(std::vector<double>{0, 0.4, -0.3, 0.5, 0.2});
  target.rotation = from_axis_angle({0, 0, 1}, 0.2) * target.rotation;  // no joint turns the tool sideways
  const IkResult result = solve_inverse(chain, target, std::vector<double>(5, 0.1));
  EXPECT_EQ(result.status, IkStatus::unreachable);
  EXPECT_TRUE(says(result, "the orientation cannot be reached at that place: ")) << result.reason;
  IkOptions options;
  options.orientation_free = true;
  EXPECT_TRUE(solve_inverse(chain, target, std::vector<double>(5, 0.1), options));
}

TEST(Inverse, EveryFailureHasAReasonAndNoStateOutsideLimits) {
  for (const auto& model : {test::ur3(), test::seven(), test::five(), test::gantry()}) {
    const Chain chain = test::chain_of(model);
    Random random(8);
    for (int i = 0; i < 40; ++i) {
      const Pose target{{random.between(-1.2, 1.2), random.between(-1.2, 1.2), random.between(-1, 1)},
                        from_rpy(random.between(-3, 3), random.between(-1.5, 1.5), random.between(-3, 3))};
      const IkResult result = solve_inverse(chain, target, test::random_state(chain, random));
      EXPECT_EQ(result.reason.empty(), bool(result));
      ASSERT_EQ(result.q.size(), chain.joints());
      for (std::size_t j = 0; j < result.q.size(); ++j) {
        EXPECT_GE(result.q[j], chain.lower()[j]);
        EXPECT_LE(result.q[j], chain.upper()[j]);
      }
    }
  }
}

TEST(Inverse, SurvivesPosesAndSeedsThatAreNone) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> seed(6, 0.1), broken{0, NAN, INFINITY, -1e300, 0, 0};
  EXPECT_FALSE(solve_inverse(chain, {{NAN, 0, 0}, {}}, seed));
  EXPECT_FALSE(solve_inverse(chain, {{1e300, 0, 0}, {}}, seed));
  EXPECT_FALSE(solve_inverse(chain, {{0.2, 0, 0}, {0, 0, 0, 0}}, seed));
  EXPECT_FALSE(solve_inverse(chain, {{0.2, 0, 0}, {}}, std::vector<double>(5)));
  EXPECT_FALSE(solve_nearest(chain, {{0, 0, INFINITY}, {}}, seed, seed));
  EXPECT_TRUE(find_solutions(chain, {{NAN, 0, 0}, {}}, seed).empty());
  const Pose target = chain.forward(std::vector<double>{0.4, -1.2, 1.3, -1.5, -1.2, 0.3});
  expect_solves(chain, target, solve_inverse(chain, target, broken));
  const Pose longer{
      target.position,
      {3 * target.rotation.x, 3 * target.rotation.y, 3 * target.rotation.z, 3 * target.rotation.w}};
  expect_solves(chain, target, solve_inverse(chain, longer, seed));
}

TEST(Inverse, IsDeterministic) {
  const Chain chain = test::chain_of(test::seven());
  const Pose target = chain.forward(std::vector<double>{0.3, 0.5, -0.4, 1.2, 0.3, 0.7, 0.1});
  const std::vector<double> seed(7, 0.0);
  EXPECT_EQ(solve_inverse(chain, target, seed).q, solve_inverse(chain, target, seed).q);
  EXPECT_EQ(find_solutions(chain, target, seed), find_solutions(chain, target, seed));
}

TEST(Inverse, AKeptSolverAnswersAsTheFunctionsDo) {
  for (const auto& model : {test::ur3(), test::seven(), test::five()}) {
    const Chain chain = test::chain_of(model);
    const ArmSolver solver(chain);
    Random random(10);
    for (int i = 0; i < 40; ++i) {
      Pose target = chain.forward(test::random_state(chain, random));
      if (i % 4 == 0) target.position.x += 0.6;
      const auto seed = test::random_state(chain, random), home = test::random_state(chain, random);
      const IkResult a = solver.solve(target, seed), b = solve_inverse(chain, target, seed);
      EXPECT_EQ(a.q, b.q);
      EXPECT_EQ(a.reason, b.reason);
      EXPECT_EQ(solver.find_solutions(target, seed), find_solutions(chain, target, seed));
      EXPECT_EQ(solver.solve_nearest(target, seed, home).q, solve_nearest(chain, target, seed, home).q);
    }
  }
}

TEST(Inverse, PartsOfPosesAreSolvedOrRefusedInWords) {
  const Chain chain = test::chain_of(test::ur3());
  const ArmSolver arm(chain);
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3}, seed(6, 0.3);
  Pose target = chain.forward(q);
  target.rotation = target.rotation * from_axis_angle({0, 0, 1}, 0.7);
  const IkResult spun = arm.solve(target, IkTask::free_spin(), seed);
  ASSERT_TRUE(spun) << spun.reason;
  EXPECT_LT(norm(chain.forward(spun.q).position - target.position), 1e-5);
  IkTask box;
  for (std::size_t row = 0; row < 3; ++row) box.low[row] = -0.05, box.high[row] = 0.05;
  Pose outside = chain.forward(std::vector<double>{0, 0, 0, 0, -1.5, 0});
  outside.position = outside.position + 0.03 * normalized(outside.position - Vec3{0, 0, 0.15});
  EXPECT_TRUE(arm.solve(outside, box, seed));
  EXPECT_FALSE(arm.solve({{4, 0, 0}, {}}, IkTask::position_only(), seed));
  EXPECT_NE(arm.solve({{4, 0, 0}, {}}, IkTask::position_only(), seed).reason.find("this robot reaches"),
            std::string::npos);
  const IkResult far = arm.solve({{4, 0, 0}, {}}, box, seed);
  EXPECT_EQ(far.status, IkStatus::unreachable);
  EXPECT_NE(far.reason, "");
  box.low[4] = 1;
  EXPECT_NE(arm.solve(target, box, seed).reason.find("about y"), std::string::npos);
}

TEST(Inverse, TheNearestOfAFailureIsTheBestOfAFewerJointedArm) {
  const Chain chain = test::chain_of(test::five());
  Random random(12);
  for (int i = 0; i < 50; ++i) {
    const auto q = test::random_state(chain, random);
    Pose target = chain.forward(q);
    target.rotation = from_axis_angle({0, 0, 1}, 0.1) * target.rotation;
    const IkResult result = solve_inverse(chain, target, test::random_state(chain, random));
    if (result) continue;
    // As good as where the question came from: 0.1 rad beside it, at 1 m per rad.
    EXPECT_LT(std::hypot(result.position_error, result.orientation_error), 0.1 + 1e-3);
  }
}

TEST(Inverse, FindsAllEightOfAUr3NearestFirst) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3};
  const Pose target = chain.forward(q);
  const auto found = find_solutions(chain, target, q);
  ASSERT_EQ(found.size(), 8u);
  EXPECT_LT(largest_change(found[0], q), 1e-6);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LT(norm(chain.forward(found[i]).position - target.position), 1e-6);
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT(largest_change(found[i], found[k]), 1e-3);
  }
}

TEST(Inverse, NearestKeepsTheConfigurationAlongAPath) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> home{0.0, -1.2, 1.5, -1.87, -1.57, 0.0};
  std::vector<double> at = home;
  const Pose start = chain.forward(home);
  for (int i = 0; i < 60; ++i) {
    Pose target = start;
    target.position.x += 0.05 * std::sin(0.3 * i);
    target.position.z += 0.03 * std::cos(0.2 * i) - 0.03;
    const IkResult result = solve_nearest(chain, target, at, home);
    expect_solves(chain, target, result);
    EXPECT_LT(largest_change(result.q, at), 0.5);
    at = result.q;
  }
}

TEST(Inverse, NearestIsTheNearestOfAll) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> home{0.0, -1.2, 1.5, -1.87, -1.57, 0.0};
  Random random(9);
  for (int i = 0; i < 50; ++i) {
    const auto current = test::random_state(chain, random);
    const Pose target = chain.forward(test::random_state(chain, random));
    const IkResult result = solve_nearest(chain, target, current, home);
    expect_solves(chain, target, result);
    const auto all = find_solutions(chain, target, current);
    const auto distance = [&](const std::vector<double>& q) {
      double sum = 0;
      for (std::size_t j = 0; j < q.size(); ++j) sum += (q[j] - current[j]) * (q[j] - current[j]);
      return std::sqrt(sum);
    };
    if (largest_change(result.q, current) <= kNearby) continue;
    for (const auto& other : all) {
      if (smallest_singular_value(chain, other) < kSingular) continue;
      EXPECT_LE(distance(result.q), distance(other) + 1e-5);
    }
  }
}

TEST(Inverse, TheSingularValueVanishesAtSingularPosesOnly) {
  const Chain ur3 = test::chain_of(test::ur3());
  EXPECT_LT(smallest_singular_value(ur3, std::vector<double>{0.4, -1.2, 1.3, -1.5, 0, 0.3}), 1e-7);
  EXPECT_GT(smallest_singular_value(ur3, std::vector<double>{0.4, -1.2, 1.3, -1.5, -1.2, 0.3}), 0.05);
  const Chain five = test::chain_of(test::five());
  EXPECT_GT(smallest_singular_value(five, std::vector<double>{0, 0.4, -0.3, 0.5, 0.2}), 0.02);
}

}  // namespace
}  // namespace polyarm::kinematics
