/// The joint trajectory controller on a planned path: at any speed, through holds and stops, on the path and
/// within the limits it was planned with.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/paths/joint_path.hpp"
#include "polyarm/timing/timing.hpp"
#include "tests/controllers/trajectory_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

constexpr double kDt = 1e-3;
constexpr std::size_t kJoints = 3;
const std::vector<trajectory::MotionLimits> kLimits(kJoints, trajectory::MotionLimits::symmetric(2, 8, 100));

/// Through a corner that is rounded.
timing::TimedPath planned_path(const std::vector<double>& from = {0, 0, 0}) {
  const std::vector<paths::JointWaypoint> points{{from}, {{0.8, 0.2, -0.3}, 0.2}, {{0.9, 1.0, 0.5}}};
  std::shared_ptr<const paths::Path> path = std::move(paths::joint_lines(points).sections.front());
  return timing::timed(path, kLimits);
}

struct PathRig : TrajectoryRig {
  timing::TimedPath path;
  std::vector<double> at, speed, hardest;
  double fastest = 0;

  PathRig() : TrajectoryRig(std::vector<double>(kJoints, 0.0)) {
    context.period = 1'000'000;
    for (JointFacts& joint : context.joints.edit())
      joint.velocity = 2, joint.acceleration = 8, joint.jerk = 100;
    set("command_interfaces", {"position", "velocity", "acceleration"});
    look_again_now();
  }
  void look_again_now() {
    hardest.assign(n, 0.0);
    fastest = 0;
  }
  std::uint64_t follow(timing::TimedPath along, double period = kDt) {
    path = along;
    auto goal = std::make_unique<TrajectoryGoal>();
    goal->id = jtc.new_goal_id();
    const std::uint64_t id = goal->id;
    goal->planned = std::make_unique<timing::PathFollower>(std::move(along), std::vector(kLimits), period);
    EXPECT_TRUE(jtc.follow(goal));
    return id;
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) {
      const std::vector<double> was = at, came = speed;
      cycle.period = 1'000'000;
      step();
      at.resize(n), speed.resize(n);
      for (std::size_t j = 0; j < n; ++j) at[j] = commanded(j);
      for (std::size_t j = 0; j < n && was.size() == n; ++j) {
        speed[j] = (at[j] - was[j]) / kDt;
        fastest = std::max(fastest, std::abs(speed[j]));
        if (came.size() == n) hardest[j] = std::max(hardest[j], std::abs(speed[j] - came[j]) / kDt);
      }
      if (jtc.status().active.load() != 0 && !path.empty()) expect_on_path();
    }
  }
  void expect_on_path() {
    std::vector<double> on(n);
    std::size_t hint = 0;
    path.sample(jtc.status().time.load(), on, {}, {}, {}, hint);
    for (std::size_t j = 0; j < n; ++j) EXPECT_EQ(at[j], on[j]) << "it left its path";
  }
  double hardest_of_all() const { return *std::max_element(hardest.begin(), hardest.end()); }
  int until_standing(int most) {
    for (int i = 0; i < most; ++i) {
      if (jtc.standing()) return i;
      cycles(1);
    }
    ADD_FAILURE() << "does not stand after " << most << " cycles";
    return most;
  }
};

TEST(PathFollowing, EndsExactlyAtThePathsEndWhenThePlanSays) {
  PathRig rig;
  rig.start();
  const std::uint64_t id = rig.follow(planned_path());
  const int planned = static_cast<int>(std::ceil(rig.path.duration() / kDt));
  rig.cycles(planned - 2);
  EXPECT_EQ(rig.jtc.status().finished.load(), 0u);
  rig.cycles(4);
  EXPECT_EQ(rig.jtc.status().finished.load(), id);
  EXPECT_TRUE(rig.jtc.standing());
  const std::vector<double> end{0.9, 1.0, 0.5};
  std::vector<double> of_path(kJoints);
  rig.path.path().at(rig.path.path().length(), {of_path, {}, {}, {}});
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_EQ(rig.commanded(j), of_path[j]);
    EXPECT_NEAR(rig.commanded(j), end[j], 1e-12);
    EXPECT_EQ(rig.commanded(j, "velocity"), 0);
    EXPECT_EQ(rig.commanded(j, "acceleration"), 0);
  }
  EXPECT_LE(rig.hardest_of_all(), 8 * (1 + 1e-6));
}

TEST(PathFollowing, AtAnyOverrideAndThroughHoldsItStaysOnThePathWithinTheLimits) {
  PathRig rig;
  rig.start();
  const std::uint64_t id = rig.follow(planned_path());
  for (const double speed : {1.0, 0.3, 0.0, 1.0, 0.7, 0.0, 0.05, 1.0}) {
    rig.verdict.speed = speed;
    if (speed > 0)
      rig.cycles(150);
    else
      rig.until_standing(600);
  }
  EXPECT_EQ(rig.jtc.status().finished.load(), 0u) << "nothing was held on the way";
  rig.cycles(3000);
  EXPECT_EQ(rig.jtc.status().finished.load(), id);
  EXPECT_LE(rig.hardest_of_all(), 8 * (1 + 1e-6));
  EXPECT_LE(rig.fastest, 2 * (1 + 1e-6));
}

TEST(PathFollowing, SpeedScalingCountsToo) {
  PathRig rig;
  rig.start();
  rig.follow(planned_path());
  rig.jtc.receive("speed_scaling_input", Numbers{{0.5}}, false);
  rig.verdict.speed = 0.5;
  rig.cycles(400);
  EXPECT_NEAR(rig.jtc.status().speed.load(), 0.25, 1e-9);
}

TEST(PathFollowing, HeldItIsDiscardedOnlyAtAStandstill) {
  PathRig rig;
  rig.start();
  const std::uint64_t id = rig.follow(planned_path());
  rig.cycles(300);
  rig.verdict.speed = 0;
  rig.verdict.discard = true;
  rig.cycles(1);
  EXPECT_EQ(rig.jtc.status().discarded.load(), 0u) << "it moves";
  rig.until_standing(500);
  const std::vector<double> held = rig.at;
  rig.cycles(1);
  EXPECT_EQ(rig.jtc.status().discarded.load(), id);
  rig.verdict = {};
  rig.cycles(100);
  EXPECT_EQ(rig.at, held);
}

TEST(PathFollowing, AnImmediateStopBrakesHarderOnThePathAndIsOverWhenItStands) {
  PathRig soft, hard;
  int took[2] = {};
  for (PathRig* rig : {&soft, &hard}) {
    rig->start();
    rig->follow(planned_path());
    rig->cycles(350);
    rig->look_again_now();
    rig->verdict.speed = 0;
    rig->verdict.immediate = rig == &hard;
    took[rig == &hard] = rig->until_standing(600);
  }
  EXPECT_LT(took[1], 0.7 * took[0]);
  EXPECT_LE(soft.hardest_of_all(), 8 * (1 + 1e-6));
  EXPECT_GT(hard.hardest_of_all(), 12);
  EXPECT_LE(hard.hardest_of_all(), 24 * (1 + 1e-6));
  hard.look_again_now();
  hard.verdict = {};
  hard.cycles(3000);
  EXPECT_EQ(hard.jtc.status().finished.load(), 1u);
  EXPECT_LE(hard.hardest_of_all(), 8 * (1 + 1e-6)) << "what follows keeps the limits again";
}

TEST(PathFollowing, ATrajectoryTakesItsJointsOverWithTheirVelocity) {
  PathRig rig;
  rig.start();
  const std::uint64_t id = rig.follow(planned_path());
  rig.verdict.speed = 0.5;
  rig.cycles(500);
  const std::vector<double> moving = rig.speed;
  ASSERT_GT(std::abs(moving[0]), 0.2);
  rig.path = {};
  const std::uint64_t next = rig.send({point(1.0, {0.5, 0.5, 0.5}, {0, 0, 0}, {0, 0, 0})});
  rig.cycles(2);
  EXPECT_EQ(rig.jtc.status().discarded.load(), id);
  EXPECT_EQ(rig.jtc.status().active.load(), next);
  for (std::size_t j = 0; j < kJoints; ++j) EXPECT_NEAR(rig.speed[j], moving[j], 0.05);
  rig.cycles(2500);
  EXPECT_EQ(rig.jtc.status().finished.load(), next);
  EXPECT_NEAR(rig.commanded(0), 0.5, 1e-12);
}

TEST(PathFollowing, ATrajectoryOfOneJointTakesThatJointAlone) {
  PathRig rig;
  rig.set("allow_partial_joints_goal", {"true"});
  rig.start();
  rig.follow(planned_path());
  rig.cycles(300);
  rig.path = {};
  rig.send({point(1.0, {0.1})}, {"j3"});
  rig.cycles(3000);
  EXPECT_EQ(rig.jtc.status().discarded.load(), 0u);
  EXPECT_TRUE(rig.jtc.standing());
  EXPECT_NEAR(rig.commanded(0), 0.9, 1e-12);
  EXPECT_NEAR(rig.commanded(1), 1.0, 1e-12);
  EXPECT_NEAR(rig.commanded(2), 0.1, 1e-12);
}

TEST(PathFollowing, APathFromElsewhereOfAnotherPeriodOrOtherJointsIsRefused) {
  PathRig rig;
  rig.start();
  EXPECT_EQ(rig.follow(planned_path({0.1, 0, 0})), 1u);
  rig.path = {};
  rig.cycles(1);
  EXPECT_EQ(rig.jtc.status().refused.load(), 1u);
  EXPECT_EQ(rig.jtc.status().reason.load(), GoalRefusal::jump);
  rig.follow(planned_path(), 2 * kDt);
  rig.cycles(1);
  EXPECT_EQ(rig.jtc.status().refused.load(), 2u);
  EXPECT_EQ(rig.jtc.status().reason.load(), GoalRefusal::wrong_period);
  auto goal = std::make_unique<TrajectoryGoal>();
  goal->id = rig.jtc.new_goal_id();
  goal->planned =
      std::make_unique<timing::PathFollower>(planned_path(), std::vector(kLimits), rig.jtc.period());
  goal->joints = {0, 1, 2};
  ASSERT_TRUE(rig.jtc.follow(goal));
  rig.cycles(1);
  EXPECT_EQ(rig.jtc.status().refused.load(), 3u);
  EXPECT_EQ(rig.jtc.status().reason.load(), GoalRefusal::wrong_size);
  for (const double p : rig.at) EXPECT_EQ(p, 0) << "nothing moved";
}

TEST(PathFollowing, OneThatArrivesWhileHeldWaitsForTheResume) {
  PathRig rig;
  rig.start();
  rig.verdict.speed = 0;
  rig.cycles(10);
  rig.follow(planned_path());
  rig.cycles(200);
  EXPECT_EQ(rig.at, std::vector<double>(kJoints, 0.0));
  EXPECT_TRUE(rig.jtc.standing());
  rig.verdict = {};
  rig.cycles(3000);
  EXPECT_EQ(rig.jtc.status().finished.load(), 1u);
  EXPECT_LE(rig.hardest_of_all(), 8 * (1 + 1e-6));
}

TEST(PathFollowing, AllocatesAndWaitsForNothing) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  PathRig rig;
  rig.start();
  rig.follow(planned_path());
  rig.path = {};
  rig.cycles(10);
  std::string seen;
  for (int k = 0; k < 3000; ++k) {
    rig.verdict.speed = k / 200 % 2 ? 0 : 0.3;
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
