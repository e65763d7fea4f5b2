#include "polyarm/kinematics/chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "polyarm/kinematics/inverse.hpp"
#include "tests/kinematics/sample_robots.hpp"

namespace polyarm::kinematics {
namespace {

std::vector<double> random_state(const Chain& chain, std::mt19937& random) {
  std::vector<double> q;
  for (std::size_t j = 0; j < chain.joints(); ++j)
    q.push_back(std::uniform_real_distribution<double>(chain.lower()[j], chain.upper()[j])(random));
  return q;
}

Chain chain_of(const description::RobotModel& model, const Pose& tcp = {}) {
  return Chain(model, model.find_link("tool0") >= 0 ? model.find_link("tool0") : static_cast<int>(model.links.size()) - 1,
               {}, tcp);
}

/// The classic Denavit-Hartenberg product with the maker's numbers, turned by half a turn about z.
Vec3 ur3_by_dh(const std::vector<double>& q) {
  const double a[] = {0, -0.24365, -0.21325, 0, 0, 0}, d[] = {0.1519, 0, 0, 0.11235, 0.08535, 0.0819};
  const double alpha[] = {M_PI / 2, 0, 0, M_PI / 2, -M_PI / 2, 0};
  Pose t{{}, from_rpy(0, 0, M_PI)};
  for (int i = 0; i < 6; ++i)
    t = t * Pose{{0, 0, d[i]}, from_rpy(0, 0, q[static_cast<std::size_t>(i)])} * Pose{{a[i], 0, 0}, from_rpy(alpha[i], 0, 0)};
  return t.position;
}

TEST(Chain, AgreesWithTheMakersDhParameters) {
  const auto model = test::ur3();
  const Chain chain = chain_of(model);
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const auto q = random_state(chain, random);
    EXPECT_LT(norm(chain.forward(q).position - ur3_by_dh(q)), 1e-12);
  }
}

TEST(Chain, JacobianIsTheDerivative) {
  for (const auto& model : {test::ur3(), test::seven()}) {
    const Chain chain = chain_of(model, {{0.01, 0.02, 0.1}, from_rpy(0.3, 0, 0.2)});
    const std::size_t n = chain.joints();
    std::mt19937 random(2);
    std::vector<double> jacobian(6 * n);
    for (int i = 0; i < 50; ++i) {
      auto q = random_state(chain, random);
      const Pose at = chain.jacobian(q, jacobian);
      EXPECT_LT(norm(at.position - chain.forward(q).position), 1e-15);
      for (std::size_t j = 0; j < n; ++j) {
        constexpr double h = 1e-6;
        auto ahead = q;
        ahead[j] += h;
        const Pose moved = chain.forward(ahead);
        const Vec3 v = (1 / h) * (moved.position - at.position);
        const Vec3 w = (1 / h) * to_rotation_vector(moved.rotation * inverse(at.rotation));
        EXPECT_LT(norm(v - Vec3{jacobian[j], jacobian[n + j], jacobian[2 * n + j]}), 1e-5);
        EXPECT_LT(norm(w - Vec3{jacobian[3 * n + j], jacobian[4 * n + j], jacobian[5 * n + j]}), 1e-5);
      }
    }
  }
}

TEST(Chain, NoPoseIsBeyondTheReach) {
  const auto model = test::seven();
  const Chain chain = chain_of(model);
  std::mt19937 random(3);
  for (int i = 0; i < 5000; ++i)
    EXPECT_LE(norm(chain.forward(random_state(chain, random)).position - chain.reach_center()), chain.reach() + 1e-12);
}

TEST(Chain, LinkPosesEndWhereForwardDoes) {
  const auto model = test::ur3();
  const Chain chain = chain_of(model);
  std::vector<Pose> links(model.links.size());
  const std::vector<double> q{0.1, -1, 1, -1, -1, 0.4};
  chain.link_poses(q, links);
  EXPECT_LT(norm(links.back().position - chain.forward(q).position), 1e-12);
}

TEST(Inverse, UndoesForwardOnRandomReachablePoses) {
  for (const auto& model : {test::ur3(), test::seven()}) {
    const Chain chain = chain_of(model);
    std::mt19937 random(4);
    int solved = 0;
    constexpr int kPoses = 1000;
    for (int i = 0; i < kPoses; ++i) {
      const Pose target = chain.forward(random_state(chain, random));
      const IkResult result = solve_inverse(chain, target, random_state(chain, random));
      if (!result) continue;
      ++solved;
      const Pose reached = chain.forward(result.q);
      EXPECT_LT(norm(reached.position - target.position), 1e-6);
      EXPECT_LT(angle_between(reached.rotation, target.rotation), 1e-6);
      for (std::size_t j = 0; j < result.q.size(); ++j) {
        EXPECT_GE(result.q[j], chain.lower()[j] - 1e-9);
        EXPECT_LE(result.q[j], chain.upper()[j] + 1e-9);
      }
    }
    EXPECT_GE(solved, kPoses * 999 / 1000) << model.name;
  }
}

TEST(Inverse, SaysHowFarAwayAPointIs) {
  const auto model = test::ur3();
  const IkResult result = solve_inverse(chain_of(model), {{5, 3, 2}, {}}, std::vector<double>(6, 0.0));
  EXPECT_EQ(result.status, IkStatus::unreachable);
  EXPECT_NE(result.reason.find("6.1"), std::string::npos) << result.reason;
}

TEST(Inverse, NamesTheJointWhoseLimitIsInTheWay) {
  auto model = test::ur3();
  const Chain free_chain = chain_of(model);
  const std::vector<double> q{0.5, -1.2, 1.5, -1.8, -1.5, 0.3};
  const Pose target = free_chain.forward(q);
  model.joints[1].limits.lower = -0.2;
  model.joints[1].limits.upper = 0.2;
  const IkResult result = solve_inverse(chain_of(model), target, std::vector<double>{0, -1.2, 1.5, -1.8, -1.5, 0});
  EXPECT_EQ(result.status, IkStatus::limits) << result.reason;
  EXPECT_NE(result.reason.find("shoulder_pan"), std::string::npos) << result.reason;
}

TEST(Inverse, SurvivesPosesThatAreNoPoses) {
  const auto model = test::ur3();
  const Chain chain = chain_of(model);
  const std::vector<double> seed(6, 0.1);
  EXPECT_FALSE(solve_inverse(chain, {{NAN, 0, 0}, {}}, seed));
  EXPECT_FALSE(solve_inverse(chain, {{1e300, 0, 0}, {}}, seed));
  EXPECT_FALSE(solve_nearest(chain, {{0, 0, INFINITY}, {}}, seed, seed));
}

TEST(Inverse, NearestKeepsTheConfiguration) {
  const auto model = test::ur3();
  const Chain chain = chain_of(model);
  const std::vector<double> home{0.0, -1.2, 1.5, -1.87, -1.57, 0.0};
  std::vector<double> at = home;
  const Pose start = chain.forward(home);
  for (int i = 0; i < 60; ++i) {
    Pose target = start;
    target.position.x += 0.05 * std::sin(0.3 * i);
    target.position.z += 0.03 * std::cos(0.2 * i) - 0.03;
    const IkResult result = solve_nearest(chain, target, at, home);
    ASSERT_TRUE(result) << result.reason;
    for (std::size_t j = 0; j < 6; ++j) EXPECT_LT(std::abs(result.q[j] - at[j]), 0.8);
    at = result.q;
  }
}

TEST(Inverse, IsDeterministic) {
  const auto model = test::seven();
  const Chain chain = chain_of(model);
  const Pose target = chain.forward(std::vector<double>{0.3, 0.5, -0.4, 1.2, 0.3, 0.7, 0.1});
  const std::vector<double> seed(7, 0.0);
  EXPECT_EQ(solve_inverse(chain, target, seed).q, solve_inverse(chain, target, seed).q);
}

TEST(Inverse, FindsAllEightOfAUr3) {
  const auto model = test::ur3();
  const Chain chain = chain_of(model);
  const std::vector<double> q{0.4, -1.2, 1.3, -1.5, -1.2, 0.3};
  IkOptions options;
  options.restarts = 200;
  EXPECT_EQ(find_solutions(chain, chain.forward(q), q, options).size(), 8u);
}

}  // namespace
}  // namespace polyarm::kinematics
