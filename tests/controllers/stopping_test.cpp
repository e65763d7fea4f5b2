/// How fast the joint trajectory controller comes to a standstill and gets going again, and what its joints
/// have to do for that.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "polyarm/trajectory/joint_move.hpp"
#include "tests/controllers/trajectory_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

constexpr double kCycle = 1e-3;

/// One that follows trajectories at 1 kHz and notes what its joints are made to do.
struct Follower : TrajectoryRig {
  trajectory::Trajectory path;
  std::vector<double> hardest, fastest;  // of each joint since the last look

  Follower(std::size_t joints, double velocity, double acceleration, double deceleration = kUnlimited,
           double jerk = kUnlimited)
      : TrajectoryRig(std::vector<double>(joints, 0.0)) {
    context.period = 1'000'000;
    for (JointFacts& joint : context.joints.edit()) {
      joint.velocity = velocity;
      joint.acceleration = acceleration;
      joint.deceleration = deceleration;
      joint.jerk = jerk;
    }
    look_again_now();
  }
  void look_again_now() { hardest = fastest = std::vector<double>(n, 0.0); }
  void follow(trajectory::Trajectory along) {
    path = along;
    auto goal = std::make_unique<TrajectoryGoal>();
    goal->id = jtc.new_goal_id();
    goal->trajectory = std::move(along);
    ASSERT_TRUE(jtc.follow(goal));
  }
  void cycle_once() {
    const std::vector<double> was = at, came = speed;
    step();
    at.resize(n), speed.resize(n);
    for (std::size_t j = 0; j < n; ++j) {
      at[j] = commanded(j);
      if (was.size() != n) continue;
      speed[j] = (at[j] - was[j]) / kCycle;
      fastest[j] = std::max(fastest[j], std::abs(speed[j]));
      if (came.size() == n) hardest[j] = std::max(hardest[j], std::abs(speed[j] - came[j]) / kCycle);
    }
    if (jtc.status().active.load() == 0 || path.empty()) return;
    std::vector<double> on_path(n);
    std::size_t hint = 0;
    path.sample(jtc.status().time.load(), on_path, {}, {}, hint);
    for (std::size_t j = 0; j < n; ++j) EXPECT_NEAR(at[j], on_path[j], 1e-12) << "it left its path";
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle_once();
  }
  /// Cycles until it stands; it is not to take more than `most`.
  int until_standing(int most) {
    for (int i = 0; i < most; ++i) {
      if (jtc.standing()) return i;
      cycle_once();
    }
    ADD_FAILURE() << "does not stand after " << most << " cycles";
    return most;
  }
  std::vector<double> at, speed;
};

trajectory::Trajectory straight(double to, double velocity, double acceleration, std::size_t joints = 1) {
  const std::vector<trajectory::JointMotionLimits> limits(joints,
                                                          {velocity, acceleration, 10 * acceleration});
  return trajectory::plan_joint_move(std::vector<double>(joints, 0.0), std::vector<double>(joints, to),
                                     limits);
}

TEST(Stopping, FromFullSpeedTakesWhatTheDecelerationNeeds) {
  Follower rig(2, 2, 8);
  rig.start();
  rig.follow(straight(3, 2, 8, 2));
  rig.cycles(700);
  ASSERT_NEAR(rig.speed[0], 2, 1e-6);
  rig.verdict.speed = 0;
  const int cycles = rig.until_standing(500);
  EXPECT_GE(cycles, 250) << "2 rad/s at 8 rad/s²";
  EXPECT_LE(cycles, 250 + 100 + 15) << "and a tenth of a second to reach them and leave them";
  EXPECT_LE(rig.hardest[0], 8 * 1.025);
}

TEST(Stopping, FromASlowMotionTakesAFraction) {
  for (const double slow : {0.2, 0.02}) {
    Follower rig(1, 2, 8);
    rig.start();
    rig.follow(straight(1, slow, 8));
    rig.cycles(700);
    ASSERT_NEAR(rig.speed[0], slow, 1e-6);
    rig.verdict.speed = 0;
    EXPECT_LE(rig.until_standing(500), slow > 0.1 ? 105 : 52);
    EXPECT_LE(rig.hardest[0], 8 * 1.025);
  }
}

TEST(Stopping, WhatStandsOrNearlyDoesStopsAtOnce) {
  Follower idle(1, 2, 8), creeping(1, 2, 8);
  idle.start();
  idle.cycles(10);
  idle.verdict.speed = 0;
  idle.cycles(1);
  EXPECT_EQ(idle.jtc.status().speed.load(), 0) << "what comes now does not begin";
  creeping.start();
  creeping.follow(straight(1, 0.007, 8));
  creeping.cycles(300);
  const double before = creeping.at[0];
  creeping.verdict.speed = 0;
  creeping.cycles(1);
  EXPECT_TRUE(creeping.jtc.standing());
  EXPECT_EQ(creeping.at[0], before) << "7 mrad/s are less than 8 rad/s² take away in one cycle";
  EXPECT_LE(creeping.hardest[0], 8 * 1.025);
}

TEST(Stopping, AtOnceBrakesHarderAndStaysOnThePathAllTheSame) {
  Follower rig(2, 2, 8);
  rig.start();
  rig.follow(straight(3, 2, 8, 2));
  rig.cycles(700);
  rig.verdict.speed = 0;
  rig.verdict.immediate = true;
  const int cycles = rig.until_standing(200);
  EXPECT_LE(cycles, 130);
  EXPECT_GT(rig.hardest[0], 2 * 8);
  EXPECT_LE(rig.hardest[0], 3 * 8 * 1.05);
}

TEST(Stopping, TheDecelerationCountsWhereItIsStated) {
  Follower rig(1, 2, 8, 4);
  rig.start();
  rig.follow(straight(3, 2, 4));
  rig.cycles(900);
  ASSERT_NEAR(rig.speed[0], 2, 1e-6);
  rig.look_again_now();
  rig.verdict.speed = 0;
  EXPECT_GE(rig.until_standing(1000), 500);
  EXPECT_LE(rig.hardest[0], 4 * 1.025);
  rig.look_again_now();
  rig.verdict.speed = 1;
  rig.cycles(450);
  EXPECT_NEAR(rig.speed[0], 2, 1e-6) << "going on again is as fast as its acceleration";
  EXPECT_GT(rig.hardest[0], 7);
  EXPECT_LE(rig.hardest[0], 8 * 1.025);
}

TEST(Stopping, JointsWithoutLimitsStopInTheShortestRamp) {
  Follower rig(1, kUnlimited, kUnlimited);
  rig.start();
  rig.follow(straight(30, 20, 80));
  rig.cycles(700);
  rig.verdict.speed = 0;
  const int cycles = rig.until_standing(100);
  EXPECT_GE(cycles, 45);
  EXPECT_LE(cycles, 55);
}

/// A plan that is always at a limit with some joint leaves a stop nothing but its margin; one that breaks its
/// limits not even that.
TEST(Stopping, APlanThatBreaksItsLimitsIsStoppedAllTheSame) {
  Follower rig(1, 2, 8);
  rig.start();
  trajectory::TrajectoryPoint start;
  start.positions = {0}, start.velocities = {40}, start.accelerations = {-20};
  trajectory::Trajectory braking(1);
  braking.append(2, std::vector<double>{0, 40, -10, 0, 0, 0});  // 2 s at -20 rad/s² where 8 are allowed
  rig.follow(braking);
  rig.cycles(10);
  rig.verdict.speed = 0;
  const int cycles = rig.until_standing(1700);
  EXPECT_GT(cycles, 500) << "first it follows what brakes already";
}

/// Random curves of three joints, limits as tight as the plan: stops, stops at once and resumes at random
/// moments, also while the last change is under way.
TEST(Stopping, OnCurvesEveryJointStaysWithinItsLimits) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  int longest = 0;
  for (int round = 0; round < 40; ++round) {
    trajectory::TrajectoryPoint start;
    start.positions = {0, 0, 0}, start.velocities = start.accelerations = {0, 0, 0};
    std::vector<trajectory::TrajectoryPoint> points;
    for (int k = 1; k <= 8; ++k) {
      std::vector<double> p(3), v(3), a(3);
      for (std::size_t j = 0; j < 3; ++j) p[j] = unit(random), v[j] = 0.5 * unit(random), a[j] = unit(random);
      if (k == 8) v = a = {0, 0, 0};
      points.push_back(point(0.8 * k, p, v, a));
    }
    const trajectory::Trajectory curve = trajectory::interpolate(start, points);
    std::array<double, 3> most_v{}, most_a{};
    std::vector<double> v(3), a(3);
    std::size_t hint = 0;
    for (double t = 0; t < curve.duration(); t += 1e-3) {
      curve.sample(t, {}, v, a, hint);
      for (std::size_t j = 0; j < 3; ++j) {
        most_v[j] = std::max(most_v[j], std::abs(v[j]));
        most_a[j] = std::max(most_a[j], std::abs(a[j]));
      }
    }
    Follower rig(3, 1, 1);
    const bool stated = round % 2 == 0;  // then commands are held to the limit
    for (std::size_t j = 0; j < 3; ++j) {
      rig.context.joints.edit()[j].velocity = most_v[j];
      rig.context.joints.edit()[j].acceleration = most_a[j] * (stated ? 1.02 : 1.0);
      rig.context.joints.edit()[j].states_acceleration = stated;
    }
    rig.start();
    rig.follow(curve);
    for (int change = 0; rig.jtc.status().finished.load() == 0 && change < 20; ++change) {
      rig.verdict = {};
      rig.cycles(static_cast<int>(200 + 190 * unit(random)));
      if (rig.jtc.status().finished.load() != 0) break;
      rig.verdict.speed = 0;
      if (change % 3 == 2) {
        rig.cycles(50);
        continue;  // it goes on before it stands
      }
      longest = std::max(longest, rig.until_standing(1500));
    }
    rig.verdict = {};
    rig.cycles(8000);
    EXPECT_EQ(rig.jtc.status().finished.load(), 1u);
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_LE(rig.hardest[j], most_a[j] * 1.035) << "round " << round << " joint " << j;
      EXPECT_LE(rig.fastest[j], most_v[j] * (1 + 1e-4));
    }
  }
  EXPECT_LT(longest, 700) << "the slowest of all of them; in one ramp for all it was two seconds";
}

TEST(Stopping, AllocatesAndWaitsForNothing) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Follower rig(3, 2, 8);
  rig.start();
  rig.follow(straight(3, 2, 8, 3));
  rig.cycles(10);
  std::string seen;
  for (int k = 0; k < 2000; ++k) {
    rig.verdict.speed = k / 200 % 2 ? 0 : 1;
    rig.verdict.immediate = k / 400 % 2;
    rig.measure();
    const test::RealtimeGuard guard;
    rig.jtc.update(rig.cycle, rig.verdict);
    seen += guard.violations();
  }
  EXPECT_EQ(seen, "");
}

}  // namespace
}  // namespace polyarm::controllers
