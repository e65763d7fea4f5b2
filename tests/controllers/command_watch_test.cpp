/// What becomes of streamed commands when nothing new comes.
#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/plugins/types.hpp"
#include "tests/controllers/joint_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

/// A controller by the name of its type on two joints; ten milliseconds a cycle.
struct Streamed {
  Parameters implied;
  std::unique_ptr<Controller> controller;
  JointRig rig;
  explicit Streamed(const std::string& type, const std::string& timeout = "0.1")
      : controller(make_controller(type, implied)), rig(*controller, {"j1", "j2"}) {
    rig.context.parameters = implied;
    if (!timeout.empty()) rig.set("command_timeout", {timeout});
  }
  void send(std::vector<double> values) {
    controller->receive("commands", Numbers{std::move(values)}, false);
  }
  void cycles(int count) {
    for (int k = 0; k < count; ++k) rig.step();
  }
  bool stale() const { return controller->command_watch().stale(); }
  bool told() { return controller->command_watch().take_reports(); }
};

TEST(CommandTimeout, IsOffUnlessItIsStated) {
  Streamed m("velocity_controllers/JointGroupVelocityController", "");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.send({1, 2});
  m.cycles(100'000);
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 1);
  EXPECT_FALSE(m.stale());
  EXPECT_FALSE(m.told());
}

TEST(CommandTimeout, AVelocityBecomesZeroAndIsToldOnce) {
  Streamed m("velocity_controllers/JointGroupVelocityController");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.cycles(50);
  EXPECT_FALSE(m.stale()) << "what nobody has begun to send does not grow old";
  m.send({1, 2});
  m.cycles(11);
  EXPECT_EQ(m.rig.command("arm/j2/velocity"), 2) << "0.1 s is not longer than 0.1 s";
  m.cycles(1);
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 0);
  EXPECT_EQ(m.rig.command("arm/j2/velocity"), 0);
  EXPECT_TRUE(m.stale());
  EXPECT_TRUE(m.told());
  m.cycles(100);
  EXPECT_FALSE(m.told());
  m.send({0.5, 0.5});
  m.cycles(1);
  EXPECT_FALSE(m.stale());
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 0.5);
}

TEST(CommandTimeout, WhatAskedForNothingEndsWithoutAWord) {
  Streamed m("velocity_controllers/JointGroupVelocityController");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.send({0, 0});
  m.cycles(50);
  EXPECT_TRUE(m.stale());
  EXPECT_FALSE(m.told());
}

TEST(CommandTimeout, AStreamThatGoesOnIsNeverStale) {
  Streamed m("velocity_controllers/JointGroupVelocityController");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  for (int k = 0; k < 100; ++k) {
    m.send({1, 1});
    m.cycles(9);
    EXPECT_EQ(m.rig.command("arm/j1/velocity"), 1);
  }
  EXPECT_FALSE(m.told());
}

TEST(CommandTimeout, AnEffortBecomesZero) {
  Streamed m("effort_controllers/JointGroupEffortController");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.send({3, -4});
  m.cycles(12);
  EXPECT_EQ(m.rig.command("arm/j1/effort"), 0);
  EXPECT_EQ(m.rig.command("arm/j2/effort"), 0);
  EXPECT_TRUE(m.told());
}

TEST(CommandTimeout, APositionHoldsWhereItHasBeenCommandedSoFar) {
  Streamed m("position_controllers/JointGroupPositionController");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.send({2, 0.5});
  m.cycles(1);
  for (int k = 1; k < 12; ++k) {
    m.rig.command("arm/j1/position") = 0.1;  // a limit of velocity has let through so much
    m.cycles(1);
  }
  EXPECT_EQ(m.rig.command("arm/j1/position"), 0.1);
  EXPECT_EQ(m.rig.command("arm/j2/position"), 0.5);
  m.cycles(10);
  EXPECT_EQ(m.rig.command("arm/j1/position"), 0.1) << "it does not go on to what it was sent last";
  EXPECT_TRUE(m.stale());
}

TEST(CommandTimeout, BelongsToTheSingleControllersOfRos1AndToOthersNumbers) {
  Streamed one("velocity_controllers/JointVelocityController");
  one.rig.set("joint", {"j1"});
  one.rig.start();
  one.send({1});
  one.cycles(12);
  EXPECT_EQ(one.rig.command("arm/j1/velocity"), 0);
  Streamed mixed("forward_command_controller/MultiInterfaceForwardCommandController");
  mixed.rig.set("joint", {"j2"});
  mixed.rig.set("interface_names", {"position", "velocity", "effort"});
  mixed.rig.start();
  mixed.send({0.4, 1, 5});
  mixed.cycles(12);
  EXPECT_EQ(mixed.rig.command("arm/j2/position"), 0.4);
  EXPECT_EQ(mixed.rig.command("arm/j2/velocity"), 0);
  EXPECT_EQ(mixed.rig.command("arm/j2/effort"), 0);
}

TEST(CommandTimeout, ThroughAPidAPositionHoldsAndAVelocityEnds) {
  Streamed position("velocity_controllers/JointPositionController");
  position.rig.set("joint", {"j1"});
  position.rig.set("pid.p", {"10"});
  position.rig.start();
  position.send({1});
  position.cycles(11);
  EXPECT_NEAR(position.rig.command("arm/j1/velocity"), 10, 1e-9);
  position.rig.state("arm/j1/position") = 0.3;
  position.cycles(2);
  EXPECT_NEAR(position.rig.command("arm/j1/velocity"), 0, 1e-9) << "held where it is";
  EXPECT_TRUE(position.told());
  Streamed velocity("effort_controllers/JointVelocityController");
  velocity.rig.set("joint", {"j1"});
  velocity.rig.set("pid.p", {"10"});
  velocity.rig.start();
  velocity.send({1});
  velocity.cycles(12);
  EXPECT_NEAR(velocity.rig.command("arm/j1/effort"), 0, 1e-9);
  EXPECT_TRUE(velocity.stale());
}

TEST(CommandTimeout, ChangesWhileItRuns) {
  Streamed m("velocity_controllers/JointGroupVelocityController", "");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.send({1, 1});
  m.cycles(100);
  m.rig.context.parameters.change("command_timeout", "0.2").apply();
  m.cycles(1);
  EXPECT_TRUE(m.stale());
  EXPECT_THROW(m.rig.context.parameters.change("command_timeout", "-1"), Error);
}

TEST(CommandTimeout, ANewStartForgetsWhatGrewOld) {
  Streamed m("velocity_controllers/JointGroupVelocityController");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.send({1, 1});
  m.cycles(20);
  EXPECT_TRUE(m.stale());
  m.controller->on_deactivate(m.rig.cycle);
  m.controller->on_activate(m.rig.cycle);
  EXPECT_FALSE(m.stale());
}

TEST(CommandTimeout, AllocatesAndWaitsForNothing) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Streamed m("velocity_controllers/JointGroupVelocityController");
  m.rig.set("joints", {"j1", "j2"});
  m.rig.start();
  m.send({1, 1});
  const test::RealtimeGuard guard;
  for (int k = 0; k < 100; ++k) {
    m.controller->update(m.rig.cycle, m.rig.verdict);
    m.rig.cycle.time += JointRig::kPeriod;
  }
  m.controller->command_watch().take_reports();
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::controllers
