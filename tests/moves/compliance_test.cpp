#include "polyarm/force/compliance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "polyarm/controllers/controller_rig.hpp"
#include "polyarm/moves/robot_motion.hpp"
#include "tests/moves/arm_moves.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::moves::compliance_test {
namespace {

using controllers::ControllerRig;
using controllers::JointTrajectoryController;
using controllers::SixVector;
using test::Arm;
using test::bent;
using test::line;
using test::shifted;
using test::Values;

/// An arm whose tool touches a springy plane that is `gap` ahead of it. The wrench comes every second cycle.
struct Rig {
  Arm arm{"universal_robots/ur5e"};
  Values from = bent(arm);
  ControllerRig controller;
  std::unique_ptr<RobotMotion> motion;
  double stiffness = 0, gap = 0;  ///< N/m, m
  SixVector pull{};               ///< what else acts on the tool
  double felt = 0;                ///< N, of the plane
  std::vector<Values> trace;
  double fastest = 0, jump = 0;  ///< rad/s, and its change within one cycle
  bool fed = true;

  Rig()
      : controller(std::make_unique<JointTrajectoryController>(), arm.chain().names(),
                   {{"joints", arm.chain().names()},
                    {"command_interfaces", {"position"}},
                    {"state_interfaces", {"position"}}}) {
    for (controllers::JointFacts& facts : controller.context().joints.edit())
      facts.velocity = 3, facts.acceleration = 12, facts.jerk = 120;
    EXPECT_EQ(controller.configure(), controllers::CallbackReturn::success);
    for (std::size_t j = 0; j < from.size(); ++j)
      controller.state(name(j)) = controller.command(name(j)) = from[j];
    EXPECT_EQ(controller.activate(), controllers::CallbackReturn::success);
    motion = std::make_unique<RobotMotion>(*arm.facts,
                                           dynamic_cast<JointTrajectoryController&>(controller.controller()),
                                           [](std::function<void()> job) { job(); });
    motion->set_planned(from);
  }
  std::string name(std::size_t j) const { return arm.chain().names()[j] + "/position"; }
  Values commanded() {
    Values q;
    for (std::size_t j = 0; j < from.size(); ++j) q.push_back(controller.command(name(j)));
    return q;
  }
  Pose tcp() { return arm.chain().forward(commanded()); }
  Pose start() const { return arm.chain().forward(from); }
  /// The way of the TCP along the axes of the tool at the start.
  Vec3 gone() { return inverse(start().rotation) * (tcp().position - start().position); }
  void feed() {
    felt = stiffness * std::max(0.0, gone().z - gap);
    SixVector wrench = pull;
    wrench[2] -= felt;
    motion->feed_wrench(wrench, controller.time());
  }
  void step() {
    if (fed && trace.size() % 2 == 0) feed();
    motion->tick(controller.time());
    controller.update();
    trace.push_back(commanded());
    if (trace.size() < 3) return;
    const std::size_t k = trace.size() - 1;
    for (std::size_t j = 0; j < from.size(); ++j) {
      const double now = (trace[k][j] - trace[k - 1][j]) / 1e-3;
      fastest = std::max(fastest, std::abs(now));
      jump = std::max(jump, std::abs(now - (trace[k - 1][j] - trace[k - 2][j]) / 1e-3));
    }
  }
  void run(double time) {
    for (int i = 0; i < static_cast<int>(time * 1e3); ++i) step();
  }
  void begin(ComplianceSettings settings) {
    feed();
    motion->begin_compliance(settings);
  }
};

ComplianceSettings along(std::size_t axis, double push = 0, double stiffness = 0) {
  ComplianceSettings out;
  out.axes[axis] = true;
  out.push[axis] = push;
  out.stiffness = stiffness;
  return out;
}

TEST(Compliance, AForceMovesTheToolByForceOverStiffness) {
  for (const std::size_t axis : {0u, 1u, 2u}) {
    Rig rig;
    rig.begin(along(axis, 0, 2000));
    rig.pull[axis] = 10;
    rig.run(4);
    const Vec3 gone = rig.gone();
    const double ways[] = {gone.x, gone.y, gone.z};
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(ways[i], i == axis ? 5e-3 : 0, 1e-4) << axis << ' ' << i;
    EXPECT_LT(rig.jump, 0.05) << "it begins without a jump";
  }
}

TEST(Compliance, TheToolPressesWithTheForceOnContactsOfAnyStiffness) {
  for (const double stiffness : {1e3, 1e4, 1e5}) {
    SCOPED_TRACE(stiffness);
    Rig rig;
    rig.stiffness = stiffness, rig.gap = 1e-3;
    ComplianceSettings settings = along(2, 20);
    settings.reach = 0.05;
    rig.begin(settings);
    double most = 0;
    int settled = 0;  // ms
    for (int i = 0; i < 6000; ++i) {
      rig.step();
      most = std::max(most, rig.felt);
      if (std::abs(rig.felt - 20) > 1) settled = i;
    }
    EXPECT_NEAR(rig.felt, 20, 0.2);
    EXPECT_LT(most, 40);
    const std::string of = "at_" + std::to_string(static_cast<int>(stiffness));
    RecordProperty("most_N_" + of, std::to_string(most));
    RecordProperty("settled_ms_" + of, settled);
  }
}

TEST(Compliance, TheForceStaysTheSameWhileThePathGoesIntoTheSurface) {
  Rig rig;
  rig.stiffness = 5e3;
  ComplianceSettings settings = along(2, 20);
  settings.damping = 500;
  rig.begin(settings);
  rig.run(2);
  Move into = line(shifted(rig.start(), rig.start().rotation * Vec3{0.03, 0, 0.005}), "into it");
  into.speed = 0.02;
  rig.motion->queue(into);
  rig.motion->close();
  double least = 1e9, most = 0;
  for (int i = 0; i < 6000; ++i)
    rig.step(), least = std::min(least, rig.felt), most = std::max(most, rig.felt);
  EXPECT_TRUE(rig.motion->at_end());
  EXPECT_NEAR(rig.gone().x, 0.03, 1e-4);
  EXPECT_GT(least, 15);
  EXPECT_LT(most, 30);
}

TEST(Compliance, ItEndsWhereTheToolIs) {
  Rig rig;
  rig.begin(along(2));
  rig.pull[2] = 10;
  rig.run(0.5);
  rig.motion->end_compliance();
  for (int i = 0; i < 500 && rig.motion->complying(); ++i) rig.step();
  EXPECT_TRUE(rig.motion->idle());
  EXPECT_EQ(rig.motion->planned(), rig.commanded());
  EXPECT_GT(rig.gone().z, 3e-3);
  EXPECT_LT(rig.jump, 0.05);
  const Values held = rig.commanded();
  rig.run(0.1);
  EXPECT_EQ(rig.commanded(), held) << "the force moves it no more";
  rig.motion->queue(line(rig.start(), "back"));
  rig.motion->close();
  rig.run(2);
  EXPECT_LT(norm(rig.gone()), 1e-6);
}

TEST(Compliance, TheToolStaysWithinItsReach) {
  Rig rig;
  ComplianceSettings settings = along(2);
  settings.reach = 0.01;
  rig.begin(settings);
  rig.pull[2] = 60;
  rig.run(3);
  EXPECT_NEAR(rig.gone().z, 0.01, 5e-4);
  EXPECT_LT(rig.jump, 0.08) << "it stops there without a jump";
  EXPECT_TRUE(rig.motion->compliance().at_bound());
  rig.pull[2] = -30;
  rig.run(1);
  EXPECT_LT(rig.gone().z, 0) << "it comes back from the bound";
}

TEST(Compliance, TheToolTurnsWithinItsReach) {
  Rig rig;
  rig.begin(along(3));
  rig.pull[3] = 5;
  rig.run(3);
  EXPECT_NEAR(angle_between(rig.tcp().rotation, rig.start().rotation), 0.2, 0.01);
  EXPECT_TRUE(rig.motion->compliance().at_bound());
}

TEST(Compliance, FastYieldingIsBoundedWithoutJumps) {
  Rig rig;
  ComplianceSettings settings = along(2);
  settings.damping = 50;
  settings.reach = 0.1;
  rig.begin(settings);
  rig.pull[2] = 40;
  rig.run(0.3);
  EXPECT_LT(rig.gone().z, 0.25 * 0.3);
  EXPECT_LT(rig.jump, 0.08);
  rig.controller.verdict.speed = 0;
  const double at = rig.gone().z;
  rig.run(0.4);
  EXPECT_LT(rig.gone().z, at + 0.01) << "a stop lasts as long as with any damping";
  EXPECT_LT(rig.jump, 0.08);
  EXPECT_TRUE(rig.controller.controller().standing());
}

TEST(Compliance, AHeldRobotDoesNotYield) {
  Rig rig;
  rig.begin(along(2));
  rig.pull[2] = 10;
  rig.run(0.3);
  rig.controller.verdict.speed = 0;
  rig.run(0.3);
  EXPECT_TRUE(rig.controller.controller().standing());
  const double at = rig.gone().z;
  rig.run(0.5);
  EXPECT_NEAR(rig.gone().z, at, 1e-5);
  rig.controller.verdict.speed = 1;
  rig.run(0.3);
  EXPECT_GT(rig.gone().z, at + 1e-3);
}

TEST(Compliance, WithoutNewsFromTheSensorItStands) {
  Rig rig;
  rig.begin(along(2));
  rig.pull[2] = 10;
  rig.run(0.3);
  rig.fed = false;
  rig.run(0.3);
  EXPECT_TRUE(rig.motion->compliance().stale());
  const double at = rig.gone().z;
  rig.run(0.3);
  EXPECT_NEAR(rig.gone().z, at, 1e-5);
}

TEST(Compliance, ACycleAllocatesAndWaitsForNothing) {
  if (!polyarm::test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers replace the same functions";
  Rig rig;
  rig.begin(along(2, 5));
  rig.run(0.02);
  for (int i = 0; i < 500; ++i) {
    rig.feed();
    rig.motion->tick(rig.controller.time());
    const polyarm::test::RealtimeGuard guard;
    rig.controller.update();
    ASSERT_EQ(guard.violations(), "");
  }
}

}  // namespace
}  // namespace polyarm::moves::compliance_test
