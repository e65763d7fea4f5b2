#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/controllers/types.hpp"
#include "tests/controllers/joint_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

/// A controller by the name of its type, on one or two joints.
struct Made {
  controllers::Parameters implied;
  std::unique_ptr<Controller> controller;
  JointRig rig;
  explicit Made(const std::string& type, std::vector<std::string> joints = {"j1"})
      : controller(make_controller(type, implied)), rig(*controller, joints) {
    rig.context.parameters = implied;
  }
};

TEST(JointPid, AnEffortBringsAMassToItsPositionAndHoldsItAgainstItsWeight) {
  Made m("effort_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"400"});
  m.rig.set("pid.i", {"200"});
  m.rig.set("pid.d", {"40"});
  m.rig.start();
  m.rig.controller.receive("command", Numbers{{1.0}}, false);
  for (int k = 0; k < 2000; ++k) {
    m.rig.step();
    double& v = m.rig.state("arm/j1/velocity");
    v += (m.rig.command("arm/j1/effort") - 9.81) * 0.01;
    m.rig.state("arm/j1/position") += v * 0.01;
  }
  EXPECT_NEAR(m.rig.state("arm/j1/position"), 1, 1e-3);
}

TEST(JointPid, HoldsWhereTheJointIsWhenItStartsAndAfterAStop) {
  Made m("velocity_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"10"});
  ASSERT_EQ(m.rig.configure(), CallbackReturn::success);
  m.rig.state("arm/j1/position") = 0.7;
  m.controller->on_activate(m.rig.cycle);
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 0);
  m.controller->receive("command", Numbers{{1.7}}, false);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/velocity"), 10, 1e-9);
  m.rig.verdict.speed = 0;
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/velocity"), 0, 1e-9);
  m.rig.verdict.speed = 1;
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/velocity"), 0, 1e-9)
      << "what was asked for before the stop does not come back";
  m.controller->on_deactivate(m.rig.cycle);
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 0);
}

TEST(JointPid, AVelocityIsHeldByAnEffort) {
  Made m("effort_controllers/JointVelocityController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"5"});
  m.rig.set("pid.i", {"20"});
  m.rig.start();
  m.controller->receive("command", Numbers{{2.0}}, false);
  for (int k = 0; k < 1000; ++k) {
    m.rig.step();
    double& v = m.rig.state("arm/j1/velocity");
    v += (m.rig.command("arm/j1/effort") - 3 * v) * 0.01;
  }
  EXPECT_NEAR(m.rig.state("arm/j1/velocity"), 2, 1e-3);
}

TEST(JointPid, GroupsHaveGainsForEachJoint) {
  Made m("effort_controllers/JointGroupPositionController", {"j1", "j2"});
  m.rig.set("joints", {"j1", "j2"});
  m.rig.set("j1.pid.p", {"1"});
  m.rig.set("gains.j2.p", {"2"});
  m.rig.start();
  m.controller->receive("commands", Numbers{{1, 1}}, false);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 1, 1e-12);
  EXPECT_NEAR(m.rig.command("arm/j2/effort"), 2, 1e-12);
  EXPECT_THROW(m.controller->receive("commands", Numbers{{1}}, false), Error);
}

TEST(JointPid, AContinuousJointTurnsTheShorterWay) {
  Made m("velocity_controllers/JointPositionController");
  m.rig.context.joints[0].continuous = true;
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"1"});
  m.rig.start();
  m.controller->receive("command", Numbers{{6.0}}, false);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/velocity"), 6.0 - 2 * M_PI, 1e-9);
}

TEST(JointPid, GainsAreCheckedBeforeTheyChange) {
  Made m("velocity_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"1"});
  m.rig.start();
  const Parameters& p = m.rig.context.parameters;
  EXPECT_NE(m.controller->refuse_changes({p.change("pid.i_clamp_min", "0.5")}), "");
  const ParameterChange change = p.change("pid.p", "3");
  EXPECT_EQ(m.controller->refuse_changes({change}), "");
  change.apply();
  m.controller->on_parameters_changed();
  m.controller->receive("command", Numbers{{1}}, false);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/velocity"), 3, 1e-9);
}

TEST(ForwardControllers, AGainThatHasNoEffectIsTold) {
  Made m("effort_controllers/JointEffortController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"100"});
  m.rig.set("pid.i", {"10"});
  m.rig.start();
  m.rig.context.parameters.finish("c");
  ASSERT_EQ(m.rig.context.parameters.problems().list().size(), 1u);
  const Problem& told = m.rig.context.parameters.problems().list().front();
  EXPECT_EQ(told.code, "no-effect");
  EXPECT_EQ(told.where.line, 3);
  EXPECT_NE(told.advice.find("JointPositionController"), std::string::npos);
}

// --- the chainable PID ------------------------------------------------------------------------------------

Made chainable() {
  Made m("pid_controller/PidController");
  m.rig.set("dof_names", {"j1"});
  m.rig.set("command_interface", {"effort"});
  m.rig.set("reference_and_state_interfaces", {"position", "velocity"});
  m.rig.set("gains.j1.p", {"10"});
  m.rig.set("gains.j1.d", {"2"});
  m.rig.set("gains.j1.feedforward_gain", {"0.5"});
  return m;
}

TEST(PidController, OffersReferencesAndBeginsWhereItIs) {
  Made m = chainable();
  ASSERT_EQ(m.rig.configure(), CallbackReturn::success);
  EXPECT_EQ(m.controller->reference_interfaces(),
            (std::vector<std::string>{"pid/j1/position", "pid/j1/velocity"}));
  EXPECT_EQ(m.controller->exported_states(), std::vector<std::string>{"pid/j1/pid_error"});
  m.rig.state("arm/j1/position") = 2;
  m.controller->on_activate(m.rig.cycle);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 0.5 * 2, 1e-12) << "no error, only the feed forward";
}

TEST(PidController, TakesReferencesFromMessagesUnlessItIsChained) {
  Made m = chainable();
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1", "j1/dot"}, {1, 0.25}}, false);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 10 * 1 + 2 * 0.25 + 0.5 * 1, 1e-12);
  EXPECT_NEAR(m.rig.state("pid/j1/pid_error"), 1, 1e-12);
  m.controller->set_chained(true);
  m.controller->receive("reference", NamedValues{{"j1"}, {9}}, false);
  m.rig.command("pid/j1/position") = 3;
  m.rig.step();
  EXPECT_NEAR(m.rig.state("pid/j1/pid_error"), 3, 1e-12);
  EXPECT_THROW(m.controller->receive("reference", NamedValues{{"elbow"}, {9}}, false), Error);
}

// --- grippers ---------------------------------------------------------------------------------------------

struct Gripper : Made {
  std::vector<GoalEvent> events;
  Gripper() : Made("parallel_gripper_action_controller/GripperActionController") { rig.set("joint", {"j1"}); }
  void run(double seconds, double stop_at = 100) {
    for (int k = 0; k < std::lround(seconds * 100); ++k) {
      rig.step();
      double& p = rig.state("arm/j1/position");
      const double before = p;
      p += std::clamp(rig.command("arm/j1/position") - p, -0.01, 0.01);
      p = std::min(p, stop_at);
      rig.state("arm/j1/velocity") = (p - before) / 0.01;
      while (auto event = controller->next_goal_event()) events.push_back(*event);
    }
  }
};

TEST(Gripper, ReachesItsGoal) {
  Gripper g;
  g.rig.start();
  g.controller->receive("gripper_cmd", GripperCommand{0.5}, true);
  g.run(2);
  ASSERT_EQ(g.events.size(), 2u);
  EXPECT_EQ(g.events[1].outcome, GoalOutcome::succeeded);
}

TEST(Gripper, AStallIsAFailureUnlessItIsAllowed) {
  for (const bool allowed : {false, true}) {
    Gripper g;
    g.rig.set("allow_stalling", {allowed ? "true" : "false"});
    g.rig.start();
    g.controller->receive("gripper_cmd", GripperCommand{0.5}, true);
    g.run(1.0, 0.1);
    EXPECT_EQ(g.events.size(), 1u) << "not before the time is up";
    g.run(1, 0.1);
    ASSERT_EQ(g.events.size(), 2u);
    EXPECT_EQ(g.events[1].outcome, allowed ? GoalOutcome::succeeded : GoalOutcome::aborted);
  }
}

TEST(Gripper, ACancelHoldsAndANewGoalReplaces) {
  Gripper g;
  g.rig.start();
  const auto first = g.controller->receive("gripper_cmd", GripperCommand{0.5}, true);
  g.run(0.2);
  EXPECT_TRUE(g.controller->cancel(first));
  g.run(0.2);
  EXPECT_EQ(g.events.back().outcome, GoalOutcome::canceled);
  EXPECT_LT(g.rig.state("arm/j1/position"), 0.3);
  g.controller->receive("gripper_cmd", GripperCommand{0.5}, true);
  g.run(0.05);
  g.controller->receive("gripper_cmd", GripperCommand{0.0}, true);
  g.run(2);
  EXPECT_EQ(g.events[3].outcome, GoalOutcome::aborted);
  EXPECT_EQ(g.events.back().outcome, GoalOutcome::succeeded);
  EXPECT_NEAR(g.rig.state("arm/j1/position"), 0, 0.011);
}

TEST(JointControllers, AllocateAndWaitForNothing) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Made pid("effort_controllers/JointPositionController");
  pid.rig.set("joint", {"j1"});
  pid.rig.set("pid.p", {"1"});
  pid.rig.start();
  pid.controller->find_output("state")->fetch();
  Made chain = chainable();
  chain.rig.start();
  Gripper gripper;
  gripper.rig.start();
  Made forward("forward_command_controller/ForwardCommandController");
  forward.rig.set("joints", {"j1"});
  forward.rig.start();
  std::string done;
  for (int k = 0; k < 100; ++k) {
    pid.controller->receive("command", Numbers{{0.1 * k}}, false);
    chain.controller->receive("reference", NamedValues{{"j1"}, {0.1 * k}}, false);
    gripper.controller->receive("gripper_cmd", GripperCommand{0.01 * k}, true);
    forward.controller->receive("commands", Numbers{{0.01 * k}}, false);
    const test::RealtimeGuard guard;
    for (Made* made : std::initializer_list<Made*>{&pid, &chain, &gripper, &forward})
      made->controller->update(made->rig.cycle, made->rig.verdict);
    done += guard.violations();
  }
  EXPECT_EQ(done, "");
}

}  // namespace
}  // namespace polyarm::controllers
