#include "polyarm/descent/numeric_ik.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/descent/descent_lanes.hpp"
#include "polyarm/descent/numeric_core.hpp"
#include "polyarm/kinematics/random.hpp"
#include "polyarm/kinematics/singularity.hpp"
#include "tests/ik/missed_once.hpp"
#include "tests/kinematics/sample_robots.hpp"
#include "tests/kinematics/sample_states.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::kinematics {
namespace {

std::span<const double> joints_of(const Chain& chain, const IkSolution& found) {
  return {found.q.data(), chain.joints()};
}

void expect_within_limits(const Chain& chain, const IkSolution& found) {
  for (std::size_t j = 0; j < chain.joints(); ++j) {
    EXPECT_GE(found.q[j], chain.lower()[j]);
    EXPECT_LE(found.q[j], chain.upper()[j]);
  }
}

void expect_there(const Chain& chain, const Pose& target, const IkSolution& found) {
  const Pose reached = chain.forward(joints_of(chain, found));
  EXPECT_LT(norm(reached.position - target.position), 1.01e-6);
  EXPECT_LT(angle_between(reached.rotation, target.rotation), 1.01e-6);
  EXPECT_TRUE(found.exact);
  expect_within_limits(chain, found);
}

/// Twelve turning joints, bent in all directions.
description::RobotModel twelve() {
  description::RobotModel model;
  std::vector<test::AxisRow> rows;
  for (int i = 0; i < 12; ++i) {
    const double a = 1.1 * i;
    rows.push_back({{std::sin(a), std::cos(a), 0.3 * (i % 3)}, {0.02 * (i % 2), 0.01 * i, 0.1 * i}});
  }
  return test::robot_of_axes("twelve", rows, {{0, 0, 1.25}, {}});
}

/// Turn, turn, slide, turn about parallel axes.
description::RobotModel scara() {
  auto model = test::serial_robot("scara", {{"one", {0, 0, 0.4}, {0, 0, 0}, {0, 0, 1}, -2.5, 2.5},
                                            {"two", {0.3, 0, 0}, {0, 0, 0}, {0, 0, 1}, -2.4, 2.4},
                                            {"down", {0.25, 0, 0}, {0, 0, 0}, {0, 0, -1}, 0, 0.2},
                                            {"spin", {0, 0, -0.05}, {0, 0, 0}, {0, 0, 1}, -6, 6},
                                            {"tool", {0, 0, -0.02}, {3.14159265, 0, 0}, {0, 0, 1}, 0, 0}});
  model.joints[2].type = description::JointType::prismatic;
  return model;
}

std::vector<description::RobotModel> all_kinds() {
  return {test::ur3(), test::seven(), test::five(), test::gantry(), scara(), twelve()};
}

TEST(NumericIk, UndoesForwardOfEveryKindOfArm) {
  for (const auto& model : all_kinds()) {
    SCOPED_TRACE(model.name);
    const Chain chain = test::chain_of(model);
    const NumericIk ik(chain);
    Random random(31);
    for (int i = 0; i < 2000; ++i) {
      const auto q = test::random_state(chain, random);
      const auto seed = test::random_state(chain, random);
      IkSolution found;
      ASSERT_EQ(ik.solve(chain.forward(q), seed, found), IkOutcome::solved) << testing::PrintToString(q);
      expect_there(chain, chain.forward(q), found);
      for (std::size_t j = 0; j < chain.joints(); ++j)
        EXPECT_TRUE(chain.moves_tcp(j) || found.q[j] == seed[j]);
    }
  }
}

/// With the environment variable POLYARM_IK_POSES: so many poses of each robot; every miss is printed as a
/// case to repeat.
TEST(NumericIk, SolvesEveryRobotOfTheCatalogue) {
  namespace fs = std::filesystem;
  const char* wanted = std::getenv("POLYARM_IK_POSES");
  const int poses = wanted ? std::atoi(wanted) : 100;
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  int robots = 0;
  for (const auto& entry : fs::recursive_directory_iterator(POLYARM_SOURCE_DIR "/robots")) {
    if (entry.path().extension() != ".yaml" || entry.path().parent_path().filename() == "demo") continue;
    const std::string name =
        entry.path().parent_path().filename().string() + "/" + entry.path().stem().string();
    const auto model = catalogue.load(name);
    const Chain chain(model, model.tool_link());
    const NumericIk ik(chain);
    Random random(17);
    ++robots;
    for (int i = 0; i < poses; ++i) {
      const auto q = test::random_state(chain, random), seed = test::random_state(chain, random);
      IkSolution found;
      EXPECT_EQ(ik.solve(chain.forward(q), seed, found), IkOutcome::solved)
          << name << " misses the pose of q = " << testing::PrintToString(q)
          << " from seed = " << testing::PrintToString(seed);
      expect_there(chain, chain.forward(q), found);
    }
  }
  EXPECT_GT(robots, 100);
}

TEST(NumericIk, SolvesAtSingularitiesAndLimits) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericIk ik(chain);
  Random random(32);
  for (int i = 0; i < 1000; ++i) {
    auto q = test::random_state(chain, random);
    q[4] = i % 2 ? 0 : M_PI;
    if (i % 3 == 0) q[2] = 0;
    if (i % 5 == 0) q[2] = chain.upper()[2];
    IkSolution found;
    ASSERT_EQ(ik.solve(chain.forward(q), test::random_state(chain, random), found), IkOutcome::solved) << i;
    expect_there(chain, chain.forward(q), found);
  }
}

TEST(NumericIk, FindsWhatItMissedOnce) {
  const description::Catalogue catalogue({POLYARM_SOURCE_DIR "/robots"});
  for (const auto& [robot, q, seed] : test::kMissedByIterationOnce) {
    const auto model = catalogue.load(robot);
    const Chain chain(model, model.tool_link());
    IkSolution found;
    EXPECT_EQ(NumericIk(chain).solve(chain.forward(q), seed, found), IkOutcome::solved) << robot;
    expect_there(chain, chain.forward(q), found);
  }
}

TEST(NumericIk, ABatchSolvesEachOfItsTargets) {
  for (const auto& model : all_kinds()) {
    SCOPED_TRACE(model.name);
    const Chain chain = test::chain_of(model);
    const NumericIk ik(chain);
    Random random(33);
    for (const std::size_t count : {0, 1, 7, 501}) {
      std::vector<Pose> targets;
      std::vector<double> seeds;
      for (std::size_t i = 0; i < count; ++i) {
        targets.push_back(chain.forward(test::random_state(chain, random)));
        for (const double v : test::random_state(chain, random)) seeds.push_back(v);
      }
      std::vector<IkSolution> found(count);
      EXPECT_EQ(ik.solve_batch(targets, seeds, found), count);
      for (std::size_t i = 0; i < count; ++i) expect_there(chain, targets[i], found[i]);
      EXPECT_EQ(ik.solve_batch(targets, {}, found), count);
    }
  }
}

TEST(NumericIk, ABatchTellsWhichOfItsTargetsCannotBeHad) {
  const Chain chain = test::chain_of(test::seven());
  const NumericIk ik(chain, {.steps = 100});
  Random random(34);
  std::vector<Pose> targets;
  for (int i = 0; i < 30; ++i) targets.push_back(chain.forward(test::random_state(chain, random)));
  targets[3].position.x += 5;
  targets[11].rotation = {NAN, 0, 0, 0};
  targets[29].position.z -= 4;
  std::vector<IkSolution> found(targets.size());
  EXPECT_EQ(ik.solve_batch(targets, {}, found), 27u);
  for (std::size_t i = 0; i < targets.size(); ++i)
    EXPECT_EQ(found[i].exact, i != 3 && i != 11 && i != 29) << i;
  EXPECT_GT(found[3].position_error, 3.9);
}

TEST(NumericIk, FindsAllEightOfAUr3NearestFirst) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericIk ik(chain);
  const std::vector<double> q{0.4, -1.6, 1.8, -1.8, -1.2, 0.3};
  IkSolutions found;
  ASSERT_EQ(ik.solve_all(chain.forward(q), q, found), IkOutcome::solved);
  ASSERT_EQ(found.count, 8u);
  EXPECT_LT(found[0].distance, 1e-6);
  for (std::size_t i = 0; i < found.count; ++i) {
    expect_there(chain, chain.forward(q), found[i]);
    EXPECT_GE(found[i].distance, i > 0 ? found[i - 1].distance : 0);
  }
}

TEST(NumericIk, TracksAPathOnOneBranch) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericIk ik(chain);
  std::vector<double> at{0.0, -1.2, 1.5, -1.87, -1.57, 0.0};
  const Pose start = chain.forward(at);
  for (int i = 0; i < 2000; ++i) {
    Pose target = start;
    target.position.x += 0.05 * std::sin(0.01 * i);
    target.position.z += 0.03 * std::cos(0.01 * i) - 0.03;
    IkSolution found;
    ASSERT_EQ(ik.track(target, at, found), IkOutcome::solved) << i;
    expect_there(chain, target, found);
    for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(found.q[j], at[j], 0.05);
    at.assign(found.q.begin(), found.q.begin() + 6);
  }
}

TEST(NumericIk, TurnsComeNearestTheSeed) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericIk ik(chain);
  const std::vector<double> q{0.4, -1.2, 1.3, -1.5, -1.2, 0.3};
  auto seed = q;
  seed[5] = q[5] - 0.99 * 2 * M_PI;
  IkSolution found;
  ASSERT_EQ(ik.track(chain.forward(q), seed, found), IkOutcome::solved);
  EXPECT_NEAR(found.q[5], q[5] - 2 * M_PI, 1e-6);
}

TEST(NumericIk, LeavesFreeWhatTheTaskLeavesFree) {
  const Chain chain = test::chain_of(test::five());
  const NumericIk ik(chain);
  const Chain arm = test::chain_of(test::ur3());
  const NumericIk ur3(arm);
  const std::vector<double> home(6, 0.1);
  Random random(35);
  for (int i = 0; i < 500; ++i) {
    Pose target = chain.forward(test::random_state(chain, random));
    target.rotation = target.rotation * from_axis_angle({0, 0, 1}, random.between(-3, 3));
    IkSolution found;
    const auto seed = test::random_state(chain, random);
    ASSERT_EQ(ik.solve(target, IkTask::free_spin(2), seed, found), IkOutcome::solved) << i;
    Pose there = chain.forward(joints_of(chain, found));
    const Vec3 z{0, 0, 1};
    EXPECT_LT(norm(there.position - target.position), 2e-6);
    EXPECT_LT(norm(there.rotation * z - target.rotation * z), 2e-6);
    expect_within_limits(chain, found);

    target.rotation = from_rpy(random.between(-3, 3), random.between(-1, 1), random.between(-3, 3));
    ASSERT_EQ(ik.solve(target, IkTask::position_only(), seed, found), IkOutcome::solved) << i;
    there = chain.forward(joints_of(chain, found));
    EXPECT_LT(norm(there.position - target.position), 2e-6);

    target.position = {9, 9, 9};
    ASSERT_EQ(ur3.solve(target, IkTask::axis_only(0), home, found), IkOutcome::solved) << i;
    there = arm.forward(joints_of(arm, found));
    const Vec3 x{1, 0, 0};
    EXPECT_LT(norm(there.rotation * x - target.rotation * x), 2e-6);
  }
}

TEST(NumericIk, KeepsWithinToleranceBoxesOfToolAndWorld) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericIk ik(chain);
  Random random(36);
  IkTask task;
  task.low = {-0.01, 0, 0, 0, 0, -0.3};
  task.high = {0.02, 0, 0.05, 0, 0, 0.1};
  for (int i = 0; i < 500; ++i) {
    task.frame = i % 2 ? IkTask::Frame::tool : IkTask::Frame::world;
    const Pose target = chain.forward(test::random_state(chain, random));
    IkSolution found;
    ASSERT_EQ(ik.solve(target, task, test::random_state(chain, random), found), IkOutcome::solved) << i;
    const Pose there = chain.forward(joints_of(chain, found));
    const Quaternion into = i % 2 ? inverse(target.rotation) : Quaternion{};
    const Vec3 off = into * (there.position - target.position);
    const Vec3 turn = into * to_rotation_vector(there.rotation * inverse(target.rotation));
    const double rows[] = {off.x, off.y, off.z, turn.x, turn.y, turn.z};
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_GE(rows[k], task.low[k] - 2e-6) << k;
      EXPECT_LE(rows[k], task.high[k] + 2e-6) << k;
    }
  }
}

TEST(NumericIk, AToleranceMakesPosesReachableThatAreNot) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericIk ik(chain);
  const std::vector<double> straight{0.2, -0.7, 0, -0.8, -1.2, 0.3};
  Pose target = chain.forward(straight);
  target.position = target.position + 0.02 * normalized(target.position - Vec3{0, 0, 0.1519});
  IkTask task;
  for (std::size_t k = 0; k < 3; ++k) task.low[k] = -0.05, task.high[k] = 0.05;
  IkSolution found;
  EXPECT_EQ(ik.solve(target, straight, found), IkOutcome::unreachable);
  EXPECT_GT(found.position_error, 1e-3);
  EXPECT_LT(found.position_error, 0.05);
  EXPECT_EQ(ik.solve(target, task, straight, found), IkOutcome::solved);
}

double goal_of(const Chain& chain, const IkSolution& found, std::span<const double> seed, IkGoal goal) {
  const auto q = joints_of(chain, found);
  if (goal == IkGoal::manipulability || goal == IkGoal::away_from_singularities)
    return smallest_singular_value(chain, q);
  double sum = 0;
  for (std::size_t j = 0; j < q.size(); ++j) {
    const double middle = 0.5 * (chain.lower()[j] + chain.upper()[j]);
    const double half = 0.5 * (chain.upper()[j] - chain.lower()[j]);
    sum -= goal == IkGoal::near_seed ? std::pow(q[j] - seed[j], 2) : std::pow((q[j] - middle) / half, 2);
  }
  return sum;
}

TEST(NumericIk, GoalsAreFollowedWithJointsToSpare) {
  const Chain chain = test::chain_of(test::seven());
  const NumericIk plain(chain);
  for (const IkGoal goal :
       {IkGoal::near_seed, IkGoal::mid_range, IkGoal::manipulability, IkGoal::away_from_singularities}) {
    const NumericIk ik(chain, {.goal = goal});
    Random random(37);
    double gained = 0;
    for (int i = 0; i < 100; ++i) {
      const Pose target = chain.forward(test::random_state(chain, random));
      const auto seed = test::random_state(chain, random);
      IkSolution with, without;
      ASSERT_EQ(ik.solve(target, seed, with), IkOutcome::solved);
      ASSERT_EQ(plain.solve(target, seed, without), IkOutcome::solved);
      expect_there(chain, target, with);
      const double change = goal_of(chain, with, seed, goal) - goal_of(chain, without, seed, goal);
      EXPECT_TRUE(change >= -1e-6 || (goal != IkGoal::near_seed && goal != IkGoal::mid_range)) << change;
      gained += change;
    }
    EXPECT_GT(gained, goal == IkGoal::away_from_singularities ? 1e-3 : 1e-2) << static_cast<int>(goal);
  }
}

TEST(NumericIk, SaysWhatFailed) {
  auto model = test::ur3();
  const Chain free_chain = test::chain_of(model);
  const std::vector<double> q{0.5, -1.2, 1.5, -1.8, -1.5, 0.3};
  IkSolution found;
  const NumericIk ik(free_chain);
  EXPECT_EQ(ik.solve({{3, 0, 0.2}, {}}, q, found), IkOutcome::unreachable);
  EXPECT_FALSE(found.exact);
  EXPECT_NEAR(found.position_error,
              norm(free_chain.forward(joints_of(free_chain, found)).position - Vec3{3, 0, 0.2}), 1e-6);
  for (const std::size_t joint : {1, 2, 3}) {
    model.joints[joint].limits.lower = q[joint - 1] - 0.2;
    model.joints[joint].limits.upper = q[joint - 1] + 0.2;
  }
  model.joints[3].limits.upper = q[2] - 0.05;
  const Chain chain = test::chain_of(model);
  const NumericIk narrow(chain);
  EXPECT_EQ(narrow.solve(free_chain.forward(q), q, found), IkOutcome::limits);
  expect_within_limits(chain, found);
  IkSolutions all;
  EXPECT_EQ(narrow.solve_all(free_chain.forward(q), q, all), IkOutcome::limits);
  EXPECT_EQ(all.count, 0u);
}

TEST(NumericIk, RefusesWhatIsNoQuestion) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericIk ik(chain);
  const std::vector<double> seed(6, 0.1);
  IkSolution found;
  EXPECT_EQ(ik.solve({{NAN, 0, 0}, {}}, seed, found), IkOutcome::malformed);
  EXPECT_EQ(ik.solve({{1e300, 0, 0}, {}}, seed, found), IkOutcome::malformed);
  EXPECT_EQ(ik.solve({{0.2, 0, 0}, {0, 0, 0, 0}}, seed, found), IkOutcome::malformed);
  EXPECT_EQ(ik.solve({{0.2, 0, 0}, {}}, std::vector<double>(5), found), IkOutcome::malformed);
  EXPECT_EQ(ik.track({{0.2, 0, 0}, {}}, std::vector<double>{0, NAN, 0, 0, 0, 0}, found),
            IkOutcome::malformed);
  IkTask task;
  task.low[2] = 1;
  EXPECT_EQ(ik.solve({{0.2, 0, 0.2}, {}}, task, seed, found), IkOutcome::malformed);
}

TEST(NumericIk, IsTheSameEveryTime) {
  const Chain chain = test::chain_of(test::seven());
  const NumericIk ik(chain), other(chain);
  Random random(38);
  for (int i = 0; i < 200; ++i) {
    const Pose target = chain.forward(test::random_state(chain, random));
    const auto seed = test::random_state(chain, random);
    IkSolution a, b;
    ik.solve(target, seed, a);
    other.solve(target, seed, b);
    for (std::size_t j = 0; j < chain.joints(); ++j) EXPECT_EQ(a.q[j], b.q[j]);
  }
}

TEST(NumericIk, DoesNothingThatTheControlCycleMayNot) {
  const Chain chain = test::chain_of(test::seven());
  const NumericIk ik(chain), going(chain, {.goal = IkGoal::manipulability});
  Random random(39);
  const auto q = test::random_state(chain, random), seed = test::random_state(chain, random);
  const Pose target = chain.forward(q);
  const auto beside = test::nearby_state(chain, q, 0.01, random);
  Pose far = target;
  far.position.x += 3;
  const std::vector<Pose> targets(20, target);
  std::vector<IkSolution> found(20);
  IkSolution one;
  IkSolutions all;
  const auto everything = [&] {
    ik.solve(target, seed, one);
    ik.solve(far, seed, one);
    ik.solve(target, IkTask::free_spin(), seed, one);
    ik.track(target, q, one);
    ik.track(target, beside, one);
    ik.solve_all(target, seed, all);
    ik.solve_batch(targets, {}, found);
    going.solve(target, seed, one);
  };
  everything();
  const test::RealtimeGuard guard;
  everything();
  EXPECT_EQ(guard.violations(), "");
}

TEST(NumericIk, DescentsAreTheSameWithEverySetOfInstructions) {
  for (const auto& model : all_kinds()) {
    const Chain chain = test::chain_of(model);
    const NumericCore core(chain, {});
    Random random(40);
    for (int i = 0; i < 50; ++i) {
      NumericQuestion question;
      const IkTask task = IkTask::free_spin();
      ASSERT_TRUE(core.read(chain.forward(test::random_state(chain, random)), i % 2 ? &task : nullptr,
                            test::random_state(chain, random), question));
      Descents here;
      for (std::size_t lane = 0; lane < kDescents; ++lane) {
        core.set_target(question, lane, here);
        core.set_state(question.seed.data(), lane, here);
      }
      const Descents start = here;
      DescentRules rules = core.rules;
      rules.steps = 1;
      const DescentTask* what = core.task_of(question);
      const int steps = descend(fastest_instructions(), core.arm, rules, what, here);
      for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2}) {
        Descents there = start;
        EXPECT_EQ(descend(supported(set), core.arm, rules, what, there), steps) << name(set);
        for (std::size_t k = 0; k < core.arm.joints; ++k)
          for (std::size_t lane = 0; lane < kDescents; ++lane)
            EXPECT_NEAR(here.x[k][lane], there.x[k][lane], 1e-6 * (1 + std::abs(here.x[k][lane])));
      }
    }
  }
}

/// A question whose seed is beside a state that has its pose.
NumericQuestion question_beside(const NumericCore& core, std::span<const double> q, double far,
                                Random& random) {
  NumericQuestion out;
  const auto seed = test::nearby_state(core.chain, q, far, random);
  EXPECT_TRUE(core.read(core.chain.forward(q), nullptr, seed, out));
  return out;
}

TEST(NumericIk, OneDescentAloneLeadsToThePoseWithEverySetOfInstructions) {
  int arms = 0;
  for (const auto& model : all_kinds()) {
    SCOPED_TRACE(model.name);
    const Chain chain = test::chain_of(model);
    const NumericCore core(chain, {});
    if (!core.arm.single.possible) continue;
    ++arms;
    Random random(41);
    DescentRules rules = core.rules;
    rules.steps = 6;
    int led = 0;
    for (int i = 0; i < 500; ++i) {
      const auto q = test::random_state(chain, random);
      const NumericQuestion question = question_beside(core, q, 0.01, random);
      SingleDescent here;
      std::copy_n(question.seed.begin(), core.arm.joints, here.x);
      const SingleDescent start = here;
      const bool there = descend_alone(fastest_instructions(), core.arm, rules, question.target.data(), here);
      led += there;
      for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2}) {
        SingleDescent other = start;
        EXPECT_EQ(descend_alone(supported(set), core.arm, rules, question.target.data(), other), there);
        for (std::size_t k = 0; k < core.arm.joints; ++k) EXPECT_NEAR(here.x[k], other.x[k], 1e-6);
      }
      if (!there) {
        EXPECT_EQ(here.x[0], start.x[0]);
        continue;
      }
      NumericPlace at{.position2 = here.position2, .orientation2 = here.orientation2};
      std::copy_n(here.x, core.arm.joints, at.x.begin());
      IkSolution found;
      core.write(at, q, found);
      expect_there(chain, chain.forward(q), found);
    }
    EXPECT_GT(led, 475);
  }
  EXPECT_EQ(arms, 4) << "turning and sliding, of four to seven axes; not with followers, nor of twelve";
}

TEST(NumericIk, WhatAStepAloneLeavesIsOfThirdOrder) {
  const Chain chain = test::chain_of(test::ur3());
  const NumericCore core(chain, {});
  DescentRules rules = core.rules;
  rules.steps = 1;
  std::vector<double> ratios;
  for (std::uint64_t i = 0; i < 400; ++i) {
    double left[2] = {};
    for (const std::size_t half : {0, 1}) {
      Random random(i);
      const auto q = test::random_state(chain, random);
      const NumericQuestion question = question_beside(core, q, half ? 0.005 : 0.01, random);
      SingleDescent one;
      std::copy_n(question.seed.begin(), 6, one.x);
      rules.position2 = rules.orientation2 = 1e-6;
      if (descend_alone(core.arm, rules, question.target.data(), one))
        left[half] = std::sqrt(one.position2 + one.orientation2);
    }
    if (left[0] > 0 && left[1] > 0) ratios.push_back(left[0] / left[1]);
  }
  ASSERT_GT(ratios.size(), 300U);
  std::nth_element(ratios.begin(), ratios.begin() + 150, ratios.end());
  EXPECT_NEAR(ratios[150], 8, 1);
}

}  // namespace
}  // namespace polyarm::kinematics
