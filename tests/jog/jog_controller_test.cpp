#include "polyarm/jog/jog_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/jog/jog_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::jog::jog_controller_test {
namespace {

using controllers::Verdict;
using Kind = JogSetpoint::Kind;

/// The controller with a table of its own, cycle by cycle.
class JogControllerTest : public ::testing::Test {
 protected:
  JogControllerTest()
      : model(description::Catalogue({POLYARM_SOURCE_DIR "/robots"}).load("universal_robots/ur5e")),
        chain(model, model.tool_link()) {
    std::vector<controllers::JointFacts> joints;
    const std::vector<AxisLimits> axes = polyarm::test::axis_limits(model);
    for (std::size_t j = 0; j < axes.size(); ++j) {
      controllers::JointFacts facts{
          "arm/" + chain.names()[j], false,       axes[j].lower, axes[j].upper, axes[j].velocity,
          axes[j].acceleration,      axes[j].jerk};
      context.command_names.push_back(facts.name + "/position");
      context.state_names.push_back(facts.name + "/position");
      joints.push_back(facts);
    }
    context.joints = joints;
    context.robot = "arm";
    controller = std::make_unique<JogController>(chain, joints, moves::Workspace());
    controller->on_configure(context);
    states = {0.3, -1.2, 1.6, -1.9, -1.4, 0.5};
    commands.assign(6, NAN);
    controllers::Bindings bindings;
    bindings.states = states;
    bindings.commands = commands;
    for (std::size_t j = 0; j < 6; ++j) {
      bindings.state.push_back(j);
      bindings.command.push_back(j);
    }
    controller->bind(bindings);
    controller->on_activate(cycle);
  }
  void step() {
    controller->update(cycle, verdict);
    cycle.time += 1'000'000;
    ++cycle.index;
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) step();
  }
  JogCommand joint(double velocity, std::uint32_t session) {
    JogCommand command;
    command.session = session;
    command.stops = verdict.stop_requests;
    command.wish.kind = Kind::joint_velocity;
    command.wish.joints[0] = velocity;
    return command;
  }
  double speed() {
    const double before = commands[0];
    step();
    return (commands[0] - before) / 0.001;
  }

  description::RobotModel model;
  kinematics::Chain chain;
  controllers::ControllerContext context;
  std::unique_ptr<JogController> controller;
  std::vector<double> states, commands;
  hardware::Cycle cycle{0, 1'000'000, 0};
  Verdict verdict;
};

TEST_F(JogControllerTest, BeginsWhereTheJointsAreAndStands) {
  run(0.1);
  EXPECT_EQ(commands, states);
  EXPECT_TRUE(controller->standing());
}

TEST_F(JogControllerTest, SlowsDownWithoutANewCommand) {
  controller->send(joint(0.5, 1));
  run(0.2);
  EXPECT_FALSE(controller->standing());
  controller->send(joint(0.5, 1));
  run(0.2);
  EXPECT_NEAR(speed(), 0.5, 1e-6);
  run(1);
  EXPECT_TRUE(controller->standing());
  EXPECT_EQ(speed(), 0);
}

TEST_F(JogControllerTest, LettingGoNeedsNoQueue) {
  JogCommand command = joint(0.5, 7);
  command.hold = 10'000'000'000;
  controller->send(command);
  run(0.5);
  controller->release_now(7);
  run(0.5);
  EXPECT_TRUE(controller->standing());
  controller->send(command);
  run(0.5);
  EXPECT_TRUE(controller->standing()) << "what was let go of is over";
  command.session = 8;
  controller->send(command);
  run(0.5);
  EXPECT_FALSE(controller->standing());
}

/// Every cause of a stop, in running and in held; and an order from before the stop that comes late.
TEST_F(JogControllerTest, EveryStopEndsTheSession) {
  std::uint32_t session = 0;
  const auto moves = [&] {
    JogCommand command = joint(0.4, ++session);
    command.hold = 10'000'000'000;
    controller->send(command);
    run(0.3);
    EXPECT_FALSE(controller->standing());
  };
  const auto stands = [&] {
    run(0.6);
    EXPECT_TRUE(controller->standing());
    EXPECT_EQ(controller->status().ended, session);
  };
  moves();
  verdict.speed = 0;  // stopping
  ++verdict.stop_requests, ++verdict.stops;
  stands();
  verdict.held = true;
  run(0.5);
  EXPECT_TRUE(controller->standing()) << "the session that was stopped does not go on";
  moves();  // a new one does, while the loop is held
  ++verdict.stop_requests, ++verdict.stops;
  stands();
  moves();
  ++verdict.stops;  // a gap in time, a silent cell thread
  stands();
  JogCommand late = joint(0.4, ++session);
  ++verdict.stop_requests, ++verdict.stops;
  controller->send(late);
  run(0.5);
  EXPECT_TRUE(controller->standing());
  moves();
  verdict.held = false;  // a fault
  verdict.immediate = true;
  stands();
}

TEST_F(JogControllerTest, StepsAddUpAndAreDoneOnce) {
  JogCommand command = joint(0.05, 1);
  command.wish.kind = Kind::joint_target;
  command.by = true;
  command.hold = 10'000'000'000;
  command.step = 1;
  controller->send(command);
  run(0.05);
  command.step = 2;
  controller->send(command);
  run(2);
  EXPECT_NEAR(commands[0], 0.4, 1e-9);
  EXPECT_EQ(controller->status().step, 2u);
  controller->send(command);  // a renewal
  run(1);
  EXPECT_NEAR(commands[0], 0.4, 1e-9);
  command.step = 3;
  command.wish.joints[0] = 100;
  controller->send(command);
  run(8);
  EXPECT_EQ(controller->status().step, 3u);
  EXPECT_EQ(controller->status().step_hold, JogHold::joint_limit);
  EXPECT_EQ(controller->status().step_which, 0);
}

TEST_F(JogControllerTest, AllocatesAndLocksNothing) {
  const Pose there = chain.forward(std::vector<double>{0.2, -1.1, 1.5, -1.9, -1.4, 0.5});
  const polyarm::test::RealtimeGuard guard;
  for (std::uint32_t session = 1; session < 40; ++session) {
    JogCommand command = joint(0.3, session);
    command.wish.kind = static_cast<Kind>(session % 5);
    command.wish.twist = {0.1, -0.05, 0.02, 0.1, 0, 0.2};
    command.wish.target = there;
    command.wish.tool_frame = session % 2 == 0;
    command.by = session % 3 == 0;
    command.step = session;
    controller->send(command);
    run(0.25);
  }
  EXPECT_EQ(guard.violations(), "");
}

}  // namespace
}  // namespace polyarm::jog::jog_controller_test
