#include "polyarm/ik/inverse_kinematics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/closed_form/arm_class.hpp"
#include "polyarm/descent/numeric_ik.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "tests/closed_form/sample_families.hpp"
#include "tests/ik/answers.hpp"
#include "tests/ik/asking.hpp"
#include "tests/kinematics/sample_states.hpp"

namespace polyarm::ik {
namespace {

using test::ask, test::difference, test::error_of, test::expect_clean, test::grid_state, test::poses_per_arm,
    test::Tally;

TEST(InverseKinematics, FindsEveryConfigurationOfEveryArmOfTheCatalogueThatHasAClosedForm) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(1);
  Tally exact, near;
  int arms = 0;
  for (const std::string& robot : catalogue.names()) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    if (!arm || !arm.complete()) continue;
    ++arms;
    Tally& tally = arm.report().find("true within") == std::string::npos ? exact : near;
    for (int i = 0; i < poses_per_arm(200); ++i)
      ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random), robot, tally);
  }
  fmt::print("{} arms: {} of {} poses missed, of descriptions that are not quite ideal {} of {}\n", arms,
             exact.missed, exact.asked, near.missed, near.asked);
  EXPECT_GE(arms, 286);
  EXPECT_EQ(exact.missed, 0) << "of " << exact.asked;
  EXPECT_LE(near.missed, near.asked / 1000) << "of " << near.asked;
  expect_clean(exact);
  expect_clean(near);
}

/// Random and singular poses, poses out of reach and poses that are none, of every arm with a closed form.
TEST(InverseKinematics, ABatchIsTheSameAsOneByOneAndAsItselfAgain) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(41);
  constexpr std::size_t kPoses = 45;  // the last eight are not full
  std::size_t solved = 0, arms = 0, different = 0;
  for (const std::string& robot : catalogue.names()) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    if (!arm || !arm.complete()) continue;
    ++arms;
    std::vector<Pose> targets;
    for (std::size_t i = 0; i < kPoses; ++i)
      targets.push_back(
          chain.forward(i % 5 == 4 ? grid_state(chain, random) : test::random_state(chain, random)));
    targets[3].position.x += 3 * chain.reach();
    targets[7].position.y = NAN;
    const auto seed = test::random_state(chain, random);
    std::vector<IkSolution> out(kPoses), again(kPoses);
    std::vector<IkOutcome> outcomes(kPoses), outcomes_again(kPoses);
    const std::size_t count = arm.solve_batch(targets, seed, out, outcomes);
    EXPECT_EQ(arm.solve_batch(targets, seed, again, outcomes_again), count);
    EXPECT_EQ(outcomes[7], IkOutcome::malformed);
    solved += count;
    for (std::size_t i = 0; i < kPoses; ++i) {
      IkSolution one;
      EXPECT_EQ(arm.solve(targets[i], seed, one), outcomes[i]) << robot << ", pose " << i;
      EXPECT_EQ(outcomes[i], outcomes_again[i]);
      if (outcomes[i] != IkOutcome::solved) continue;
      const std::span<const double> q(out[i].q.data(), chain.joints());
      EXPECT_LT(error_of(chain, q, targets[i]), 2e-9) << robot;
      for (std::size_t j = 0; j < chain.joints(); ++j) {
        EXPECT_EQ(out[i].q[j], again[i].q[j]);
        different += !(std::abs(one.q[j] - out[i].q[j]) < 1e-12);
      }
    }
  }
  EXPECT_GE(arms, 286u);
  EXPECT_GE(solved, arms * (kPoses - 3));
  EXPECT_EQ(different, 0u);
}

TEST(InverseKinematics, FindsTheSeedAtSingularPosesOfTheCatalogue) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(2);
  Tally tally;
  for (const std::string& robot : catalogue.names()) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    if (!arm || !arm.complete()) continue;
    for (int i = 0; i < poses_per_arm(60); ++i) {
      const auto q = grid_state(chain, random);
      ask(chain, arm, q, q, robot, tally);
    }
  }
  EXPECT_EQ(tally.missed, 0) << "of " << tally.asked;
  expect_clean(tally);
}

TEST(InverseKinematics, SolvesFiveAxesForPosesTheyReachAndGivesPositionFirstForOthers) {
  const Chain chain = test::chain_of(test::five());
  const InverseKinematics arm(chain);
  EXPECT_EQ(arm.report(),
            "five axes, solved as six of which axis 6 stands still: axes 2, 3 and 4 parallel, axes 5 "
            "and 6 meet");
  Random random(11);
  Tally tally;
  for (int i = 0; i < 1000; ++i)
    ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random), "five", tally);
  EXPECT_EQ(tally.missed, 0);
  expect_clean(tally);
  Pose target = chain.forward(std::vector<double>{0, 0.4, -0.3, 0.5, 0.2});
  target.rotation = from_axis_angle({0, 0, 1}, 0.2) * target.rotation;  // no joint turns the tool sideways
  IkSolution found;
  EXPECT_EQ(arm.solve(target, std::vector<double>(5, 0.1), found), IkOutcome::unreachable);
  EXPECT_FALSE(found.exact);
  EXPECT_LT(found.orientation_error, 0.3);
}

/// How often arms with a joint too many reach the pose of a random state at all, and from itself at once.
TEST(InverseKinematics, SolvesSevenAxesByTheOneThatIsSpare) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(12);
  int arms = 0, asked = 0, solved = 0, nearer = 0;
  for (const std::string& robot : catalogue.names()) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    if (arm.way() != IkWay::spare_axis || searched(arm.family())) continue;
    ++arms;
    Tally tally;
    for (int i = 0; i < 20; ++i) {
      const auto q = test::random_state(chain, random), seed = test::random_state(chain, random);
      ask(chain, arm, q, q, robot, tally);
      IkSolution found;
      ++asked;
      const Pose target = chain.forward(q);
      if (arm.solve(target, seed, found) != IkOutcome::solved) continue;
      ++solved;
      EXPECT_LT(error_of(chain, {found.q.data(), chain.joints()}, target), 2e-9);
      double distance = 0;
      for (std::size_t j = 0; j < q.size(); ++j) distance += (q[j] - seed[j]) * (q[j] - seed[j]);
      nearer += found.distance <= std::sqrt(distance) + 1e-6;
    }
    EXPECT_EQ(tally.missed, 0) << robot;
    expect_clean(tally);
  }
  EXPECT_GE(arms, 17);
  EXPECT_GE(solved, asked * 98 / 100) << "of " << asked;
  EXPECT_GE(nearer, asked * 97 / 100) << "nearer to the seed than the state that was drawn, of " << asked;
}

/// By elbow angle: as near as any of many descents to the seed, whatever the limits leave.
TEST(InverseKinematics, SphericalShouldersAndWristsComeNearerThanAnyOfManyDescents) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(13);
  int asked = 0, solved = 0, beaten = 0;
  for (const char* robot : {"kuka/lbr_iiwa_7_r800", "kuka/lbr_iiwa_14_r820"}) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    ASSERT_NE(arm.report().find("elbow angle"), std::string::npos) << arm.report();
    NumericSettings settings;
    settings.goal = IkGoal::near_seed;
    const NumericIk numeric(chain, settings);
    for (int i = 0; i < 1000; ++i) {
      const auto q = test::random_state(chain, random), seed = test::random_state(chain, random);
      const Pose target = chain.forward(q);
      IkSolution one, other;
      ++asked;
      if (arm.solve(target, seed, one) != IkOutcome::solved) continue;
      ++solved;
      ASSERT_LT(error_of(chain, {one.q.data(), chain.joints()}, target), 2e-9);
      double distance = 0;
      for (std::size_t j = 0; j < q.size(); ++j) {
        EXPECT_GE(one.q[j], chain.lower()[j]);
        EXPECT_LE(one.q[j], chain.upper()[j]);
        distance += (q[j] - seed[j]) * (q[j] - seed[j]);
      }
      beaten += std::sqrt(distance) < one.distance - 1e-3;
      if (i % 10 == 0 && numeric.solve(target, seed, other) == IkOutcome::solved)
        beaten += other.distance < one.distance - 1e-3;
    }
  }
  EXPECT_EQ(solved, asked);
  EXPECT_LE(beaten, asked / 200) << "of " << asked;
}

/// Arms with a wrist that is no single point. The same poses are asked of descent from many starts: whatever
/// that finds, the search has to have found.
TEST(InverseKinematics, SearchesArmsOfTheCatalogueThatHaveNoClosedForm) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(31);
  Tally drawn, seeded;
  int arms = 0;
  for (const std::string& robot : catalogue.names()) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    if (arm.way() != IkWay::search) continue;
    ++arms;
    for (int i = 0; i < 150; ++i)
      ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random), robot, drawn);
    for (int i = 0; i < 20; ++i) {
      const auto q = grid_state(chain, random);
      ask(chain, arm, q, q, robot, seeded);
    }
  }
  EXPECT_GE(arms, 19);
  EXPECT_LE(drawn.missed, drawn.asked / 1000) << "of " << drawn.asked;
  EXPECT_EQ(seeded.missed, 0) << "of " << seeded.asked;
  expect_clean(drawn);
  expect_clean(seeded);
}

TEST(InverseKinematics, NoBranchOfASearchIsLostAgainstDescentFromManySeeds) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  Random random(32);
  int known = 0, lost = 0;
  for (const char* robot : {"fanuc/crx_10ia", "yaskawa/hc10", "kinova/jaco2_6dof_non_spherical_j2n6s300"}) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    const InverseKinematics arm(chain);
    for (int i = 0; i < 6; ++i) {
      const Pose target = chain.forward(test::random_state(chain, random));
      IkSolutions found;
      arm.solve_all(target, test::random_state(chain, random), found);
      for (int k = 0; k < 60; ++k) {
        const test::Answer one = test::descend(chain, target, test::random_state(chain, random));
        if (!one || smallest_singular_value(chain, one.q) < 1e-3) continue;
        ++known;
        bool there = false;
        for (const IkSolution& branch : found)
          there |= difference(chain, {branch.q.data(), chain.joints()}, one.q) < 1e-4;
        lost += !there;
      }
    }
  }
  EXPECT_GT(known, 800);
  EXPECT_EQ(lost, 0) << "of " << known;
}

/// Joints that slide and arms of few axes: from poses that they reach.
TEST(InverseKinematics, SolvesScarasGantriesPalletisersAndArmsOfFewAxes) {
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  auto scara = test::robot_of_axes("scara", {{z, {}}, {z, {0.35, 0, 0}}, {-z, {0.6, 0, 0}}, {z, {0.6, 0, 0}}},
                                   {{0.6, 0, -0.1}, {}});
  auto gantry = test::robot_of_axes(
      "gantry", {{x, {}}, {y, {}}, {z, {}}, {z, {0, 0, -0.2}}, {y, {0, 0, -0.3}}, {x, {0, 0, -0.3}}},
      {{0.05, 0, -0.4}, {}});
  auto rail = test::robot_of_axes("rail",
                                  {{y, {}},
                                   {z, {}},
                                   {y, {0.1, 0, 0.4}},
                                   {y, {0.1, 0, 0.9}},
                                   {x, {0.5, 0, 1.0}},
                                   {y, {0.7, 0, 1.0}},
                                   {x, {0.7, 0, 1.0}}},
                                  {{0.8, 0, 1.0}, {}});
  const auto slides = [](description::RobotModel& model, std::initializer_list<std::size_t> joints) {
    for (const std::size_t j : joints) {
      model.joints[j].type = description::JointType::prismatic;
      model.joints[j].limits.lower = -0.8;
      model.joints[j].limits.upper = 0.8;
    }
  };
  slides(scara, {2});
  slides(gantry, {0, 1, 2});
  slides(rail, {0});
  const auto four =
      test::robot_of_axes("palletiser", {{z, {}}, {y, {0.1, 0, 0.4}}, {y, {0.1, 0, 1.0}}, {y, {0.7, 0, 1.1}}},
                          {{0.8, 0, 1.0}, {}});
  const auto slanted = test::robot_of_axes("slanted",
                                           {{z, {}},
                                            {normalized(Vec3{1, 2, 0}), {0.1, 0, 0.4}},
                                            {x, {0.3, 0.2, 0.7}},
                                            {y, {0.5, 0, 0.9}},
                                            {normalized(Vec3{1, 0, 1}), {0.6, 0.1, 0.9}}},
                                           {{0.8, 0, 1.0}, {}});
  const auto three =
      test::robot_of_axes("three", {{z, {}}, {y, {0.1, 0, 0.4}}, {y, {0.1, 0, 1.0}}}, {{0.7, 0, 1.0}, {}});
  const auto two = test::robot_of_axes("two", {{z, {}}, {y, {0.1, 0, 0.4}}}, {{0.7, 0, 0.5}, {}});
  Random random(33);
  for (const auto& model : {scara, gantry, rail, four, slanted, three, two}) {
    const InverseKinematics arm(model, test::tip_of(model));
    const Chain chain = test::chain_of(model);
    Tally tally;
    int solved = 0;
    for (int i = 0; i < 60; ++i) {
      const auto q = test::random_state(chain, random), seed = test::random_state(chain, random);
      IkSolution one;
      solved += arm.solve(chain.forward(q), seed, one) == IkOutcome::solved && one.exact;
      if (arm.way() == IkWay::spare_axis)
        ask(chain, arm, q, q, model.name, tally);
      else
        ask(chain, arm, q, seed, model.name, tally);
    }
    EXPECT_EQ(solved, 60) << model.name << ": " << arm.report();
    EXPECT_EQ(tally.missed, 0) << model.name << ": " << arm.report();
    expect_clean(tally);
  }
}

TEST(InverseKinematics, FewAxesGiveTheLeastErrorWherePosesAreBeyondThem) {
  const Vec3 y{0, 1, 0}, z{0, 0, 1};
  const auto model =
      test::robot_of_axes("palletiser", {{z, {}}, {y, {0.1, 0, 0.4}}, {y, {0.1, 0, 1.0}}, {y, {0.7, 0, 1.1}}},
                          {{0.8, 0, 1.0}, {}});
  const InverseKinematics arm(model, test::tip_of(model));
  const Chain chain = test::chain_of(model);
  const std::vector<double> q{0.3, -0.2, 0.5, 0.4};
  Pose target = chain.forward(q);
  target.rotation = from_axis_angle({1, 0, 0}, 0.1) * target.rotation;
  IkSolution found;
  EXPECT_EQ(arm.solve(target, q, found), IkOutcome::unreachable);
  EXPECT_FALSE(found.exact);
  EXPECT_GT(found.position_error + found.orientation_error, 0.01);
  EXPECT_LT(found.position_error, 0.1);
  EXPECT_LT(found.orientation_error, 0.15);
}

/// Six axes of which none meet or are parallel: all branches, also by the word of descent from many seeds.
TEST(InverseKinematics, FindsEveryConfigurationOfSixAxesOfAnyKind) {
  Random random(34);
  Tally tally;
  int arms = 0, known = 0, lost = 0;
  for (int i = 0; i < 200; ++i) {
    auto axes = test::random_axes(ArmFamily::none, random);
    if (i % 4 == 1) axes[2].direction = axes[1].direction;  // two parallel axes and no more
    if (i % 4 == 2) axes[3].point = axes[2].point;          // two in the middle that meet
    if (i % 4 == 3) axes[5].point = axes[3].point;          // and two that are no neighbours
    const auto model = test::random_arm(axes, random);
    const Chain chain = test::chain_of(model);
    const InverseKinematics arm(chain);
    if (arm.way() != IkWay::algebra) continue;  // by chance nearly of another class
    ++arms;
    EXPECT_NE(arm.report().find("degree 16"), std::string::npos);
    for (int k = 0; k < 60; ++k)
      ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random), "any six", tally);
    const Pose target = chain.forward(test::random_state(chain, random));
    IkSolutions found;
    arm.solve_all(target, test::random_state(chain, random), found);
    const NumericIk descent(chain);
    for (int k = 0; k < 40; ++k) {
      IkSolution one;
      if (descent.solve(target, test::random_state(chain, random), one) != IkOutcome::solved) continue;
      if (smallest_singular_value(chain, {one.q.data(), 6}) < 1e-3) continue;
      ++known;
      bool there = false;
      for (const IkSolution& branch : found)
        there |= difference(chain, {branch.q.data(), 6}, {one.q.data(), 6}) < 1e-4;
      lost += !there;
    }
  }
  EXPECT_GT(arms, 190);
  EXPECT_EQ(tally.missed, 0) << "of " << tally.asked;
  expect_clean(tally);
  EXPECT_GT(known, 5000);
  EXPECT_EQ(lost, 0) << "of " << known;
}

TEST(InverseKinematics, ScarasAndGantriesAreClosedWhateverTheOrderOfTheirJoints) {
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  Random random(35);
  struct Case {
    const char* name;
    std::vector<test::AxisRow> axes;
    std::vector<std::size_t> slides;
    const char* report;
  };
  const Vec3 a{0.1, 0, 0.3}, b{0.4, 0.05, 0.3}, c{0.65, 0, 0.3};
  const Case cases[] = {
      {"RRPR", {{z, a}, {-z, b}, {z, c}, {z, c}}, {2}, "three parallel axes"},
      {"PRRR", {{z, a}, {z, a}, {z, b}, {-z, c}}, {0}, "three parallel axes"},
      {"RRRP", {{-z, a}, {z, b}, {z, c}, {-z, c}}, {3}, "three parallel axes"},
      {"RPRR", {{z, a}, {z, a}, {z, b}, {z, c}}, {1}, "three parallel axes"},
      {"lying",
       {{y, a}, {y, a}, {y, a + Vec3{0.3, 0, 0.1}}, {-y, a + Vec3{0.5, 0, 0}}},
       {0},
       "three parallel axes"},
      {"PPPR", {{x, a}, {y, a}, {z, a}, {z, b}}, {0, 1, 2}, "three axes that slide"},
      {"PPPRR", {{x, a}, {y, a}, {-z, a}, {z, b}, {y, b}}, {0, 1, 2}, "three axes that slide"},
      {"PPPRRR",
       {{x, a}, {y, a}, {z, a}, {z, b}, {y, c}, {normalized(Vec3{1, 0, 1}), c}},
       {0, 1, 2},
       "three axes that slide"},
  };
  for (const Case& one : cases) {
    auto model = test::robot_of_axes(one.name, one.axes, {{0.7, 0.1, 0.1}, from_axis_angle(y, 0.4)});
    for (const std::size_t j : one.slides) {
      model.joints[j].type = description::JointType::prismatic;
      model.joints[j].limits.lower = -0.8;
      model.joints[j].limits.upper = 0.8;
    }
    const Chain chain = test::chain_of(model);
    const InverseKinematics arm(chain);
    EXPECT_NE(arm.report().find(one.report), std::string::npos) << one.name << ": " << arm.report();
    EXPECT_EQ(arm.way(), IkWay::closed_form) << one.name;
    Tally tally;
    for (int k = 0; k < 500; ++k)
      ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random), one.name, tally);
    for (int k = 0; k < 100; ++k) {
      const auto q = grid_state(chain, random);
      ask(chain, arm, q, q, one.name, tally);
    }
    EXPECT_EQ(tally.missed, 0) << one.name;
    expect_clean(tally);
  }
}

/// A joint that drives two axes, one of them at a rate of its own.
TEST(InverseKinematics, AChainThatIsNoRowOfJointsIsSolvedByTheSameDoor) {
  const auto model = test::gantry();
  const Chain chain = test::chain_of(model);
  const InverseKinematics arm(chain);
  EXPECT_EQ(arm.way(), IkWay::descent);
  EXPECT_FALSE(arm);
  Random random(41);
  for (int i = 0; i < 50; ++i) {
    const auto q = test::random_state(chain, random), seed = test::random_state(chain, random);
    const Pose target = chain.forward(q);
    IkSolution one;
    IkSolutions all;
    ASSERT_EQ(arm.solve(target, seed, one), IkOutcome::solved);
    EXPECT_LT(error_of(chain, {one.q.data(), chain.joints()}, target), 2e-9);
    ASSERT_EQ(arm.solve_all(target, seed, all), IkOutcome::solved);
    for (const IkSolution& other : all)
      EXPECT_LT(error_of(chain, {other.q.data(), chain.joints()}, target), 2e-9);
  }
}

TEST(InverseKinematics, PartsOfPosesGoToTheNumericSolver) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3}, seed{0.5, -1.4, 1.5, -1.5, -1.0, 2.0};
  Pose turned = chain.forward(q);
  turned.rotation = turned.rotation * from_axis_angle({0, 0, 1}, 0.7);
  IkSolution one;
  const InverseKinematics ready(chain);
  ASSERT_EQ(ready.solve(turned, IkTask::free_spin(), seed, one), IkOutcome::solved);
  const Pose there = chain.forward({one.q.data(), 6});
  EXPECT_LT(norm(there.position - turned.position), 1e-8);
  EXPECT_LT(norm(there.rotation * Vec3{0, 0, 1} - turned.rotation * Vec3{0, 0, 1}), 1e-8);
  EXPECT_EQ(ready.solve({{4, 0, 0}, {}}, IkTask::position_only(), seed, one), IkOutcome::unreachable);
  EXPECT_FALSE(one.exact);
}

TEST(InverseKinematics, FindsEveryConfigurationOfRandomArmsOfEachFamilyAndTurnedRound) {
  Random random(3);
  for (const ArmFamily family : test::kClosedFamilies) {
    Tally tally;
    for (int i = 0; i < 40; ++i) {
      auto axes = test::random_axes(family, random);
      if (i % 2) axes = test::turned_round(axes);
      const Chain chain = test::chain_of(test::random_arm(axes, random));
      const InverseKinematics arm(chain);
      ASSERT_EQ(arm.family(), family) << arm.report();
      for (int k = 0; k < 100; ++k)
        ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random),
            describe(family), tally);
    }
    EXPECT_EQ(tally.missed, 0) << describe(family) << ", of " << tally.asked;
    expect_clean(tally);
  }
}

TEST(InverseKinematics, CalibratedArmsLoseHardlyABranch) {
  Random random(4);
  Tally tally;
  for (const double size : {1e-4, 3e-4}) {
    for (const ArmFamily family : test::kClosedFamilies) {
      const int missed = tally.missed;
      for (int i = 0; i < 20; ++i) {
        const auto axes = test::spoiled(test::random_axes(family, random), size, random);
        const Chain chain = test::chain_of(test::random_arm(axes, random));
        const InverseKinematics arm(chain);
        if (!arm) continue;  // spoiled too much for so small an arm
        for (int k = 0; k < 100; ++k)
          ask(chain, arm, test::random_state(chain, random), test::random_state(chain, random),
              describe(family), tally);
      }
      EXPECT_LE(tally.missed - missed, 8) << describe(family) << ", spoiled by " << size;
    }
  }
  EXPECT_GT(tally.asked, 20000);
  EXPECT_LE(tally.missed, tally.asked / 1000) << "of " << tally.asked;
  expect_clean(tally);
}

TEST(InverseKinematics, FindsAllEightOfAUr3AndNamesItsKind) {
  const Chain chain = test::chain_of(test::ur3());
  const InverseKinematics arm(chain);
  EXPECT_EQ(arm.family(), ArmFamily::parallel_234_5_meets_6);
  EXPECT_EQ(arm.report(), "axes 2, 3 and 4 parallel, axes 5 and 6 meet");
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3};
  IkSolutions found;
  EXPECT_EQ(arm.solve_all(chain.forward(q), q, found), IkOutcome::solved);
  ASSERT_EQ(found.count, 8u);
  EXPECT_LT(difference(chain, found[0].q, q), 1e-9);
  EXPECT_LT(found[0].distance, 1e-9);
}

TEST(InverseKinematics, JointsComeToTheTurnNearestTheSeedWithinLimits) {
  const Chain chain = test::chain_of(test::ur3());
  const InverseKinematics arm(chain);
  const std::vector<double> q{0.4, -1.2, 1.3, -1.5, -1.2, 0.3};
  for (const double turn : {-2 * std::numbers::pi, 2 * std::numbers::pi}) {
    auto seed = q;
    seed[5] = q[5] + turn * 0.99;
    IkSolution found;
    ASSERT_EQ(arm.solve(chain.forward(q), seed, found), IkOutcome::solved);
    EXPECT_NEAR(found.q[5], turn > 0 ? q[5] : q[5] + turn, 1e-9);  // 0.3 + 2 pi is beyond the limit
  }
}

TEST(InverseKinematics, WeightsDecideWhatIsNear) {
  const Chain chain = test::chain_of(test::ur3());
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3}, seed{3.2, -1.0, 1.8, -1.8, 0.2, 0.3};
  IkSettings settings;
  settings.weights = {1e3, 1, 1, 1, 1, 1};
  IkSolutions even, heavy;
  InverseKinematics(chain).solve_all(chain.forward(q), seed, even);
  InverseKinematics(chain, settings).solve_all(chain.forward(q), seed, heavy);
  ASSERT_EQ(even.count, heavy.count);
  for (const IkSolution& one : even)
    EXPECT_GE(std::abs(one.q[0] - seed[0]) + 1e-9, std::abs(heavy[0].q[0] - seed[0]));
}

TEST(InverseKinematics, SaysWhyNothingWasFound) {
  auto model = test::ur3();
  const Chain chain = test::chain_of(model);
  const InverseKinematics arm(chain);
  const std::vector<double> q{0.5, -1.2, 1.5, -1.8, -1.5, 0.3};
  IkSolution found;
  EXPECT_EQ(arm.solve({{5, 1.7, 0.5}, {}}, q, found), IkOutcome::unreachable);
  EXPECT_FALSE(found.exact);
  EXPECT_GT(found.position_error, 4);
  EXPECT_EQ(arm.solve({{NAN, 0, 0}, {}}, q, found), IkOutcome::malformed);
  EXPECT_EQ(arm.solve({{0.2, 0, 0}, {0, 0, 0, 0}}, q, found), IkOutcome::malformed);
  EXPECT_EQ(arm.solve({}, std::vector<double>(5), found), IkOutcome::malformed);
  EXPECT_EQ(arm.solve({}, std::vector<double>{0, INFINITY, 0, 0, 0, 0}, found), IkOutcome::malformed);
  const Pose target = chain.forward(q);
  for (description::Joint& joint : model.joints)
    if (joint.moves()) joint.limits.lower = -0.1, joint.limits.upper = 0.1;
  EXPECT_EQ(InverseKinematics(test::chain_of(model)).solve(target, std::vector<double>(6, 0.0), found),
            IkOutcome::limits);
}

TEST(InverseKinematics, ALittleOutOfReachItGivesTheNearestAndSaysSo) {
  const Vec3 y{0, 1, 0}, z{0, 0, 1};
  const Chain chain = test::chain_of(test::robot_of_axes(
      "straight", {{z, {}}, {y, {}}, {y, {0, 0, 0.5}}, {z, {0, 0, 1}}, {y, {0, 0, 1}}, {z, {0, 0, 1}}},
      {{0, 0, 1.1}, {}}));
  const InverseKinematics arm(chain);
  const std::vector<double> q{0.5, 0.4, 0, 0.3, 0.4, 0.3};  // the elbow is stretched
  Pose target = chain.forward(q);
  target.position = target.position + 1e-3 * (from_rpy(0, 0.4, 0.5) * z);
  IkSolution found;
  EXPECT_EQ(arm.solve(target, q, found), IkOutcome::unreachable);
  EXPECT_FALSE(found.exact);
  EXPECT_NEAR(found.position_error, 1e-3, 1e-4);
  EXPECT_LT(difference(chain, found.q, q), 0.1);
}

}  // namespace
}  // namespace polyarm::ik
