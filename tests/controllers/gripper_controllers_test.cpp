#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/controllers/made_controller.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

struct Gripper : Made {
  std::vector<GoalEvent> events;
  explicit Gripper(const std::string& type = "parallel_gripper_action_controller/GripperActionController")
      : Made(type) {
    rig.set("joint", {"j1"});
  }
  std::uint64_t go(double position) {
    return controller->receive("gripper_cmd", GripperCommand{position}, true);
  }
  void collect() {
    while (auto event = controller->next_goal_event()) events.push_back(*event);
  }
  void run(double seconds, double stop_at = 100) {
    for (int k = 0; k < std::lround(seconds * 100); ++k) {
      rig.step();
      double& p = rig.state("arm/j1/position");
      const double before = p;
      p += std::clamp(rig.command("arm/j1/position") - p, -0.01, 0.01);
      p = std::min(p, stop_at);
      rig.state("arm/j1/velocity") = (p - before) / 0.01;
      collect();
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
  EXPECT_EQ(g.events[3].outcome, GoalOutcome::canceled) << "preempted";
  EXPECT_EQ(g.events.back().outcome, GoalOutcome::succeeded);
  EXPECT_NEAR(g.rig.state("arm/j1/position"), 0, 0.011);
}

TEST(Gripper, SaysWhereItIsHowHardItPushesAndWhyItEnded) {
  Gripper g;
  g.rig.set("max_effort", {"7"});
  g.rig.start();
  Output& told = *g.controller->find_output("gripper_state");
  told.fetch();
  EXPECT_EQ(g.controller->inputs()[0].feedback, told.name());
  g.go(0.5);
  g.run(0.1);
  ASSERT_TRUE(told.fetch());
  const std::vector<std::string> first(told.fields().begin(), told.fields().begin() + 4);
  EXPECT_EQ(first, (std::vector<std::string>{"position", "effort", "stalled", "reached_goal"}));
  EXPECT_GT(told.value().values[0], 0.05);
  EXPECT_EQ(told.value().values[1], 7);
  EXPECT_EQ(told.value().values[3], 0);
  g.run(1);
  ASSERT_TRUE(g.events.back().gripper);
  EXPECT_NEAR(g.events.back().gripper->position, 0.5, 0.011);
  EXPECT_EQ(g.events.back().gripper->effort, 7);
  EXPECT_TRUE(g.events.back().gripper->reached_goal);
  EXPECT_FALSE(g.events.back().gripper->stalled);
  ASSERT_TRUE(told.fetch());
  EXPECT_EQ(told.value().values[3], 1);
  g.controller->receive("gripper_cmd", GripperCommand{0.9, {}, 3.0}, true);
  g.run(2, 0.6);
  ASSERT_TRUE(g.events.back().gripper);
  EXPECT_EQ(g.events.back().gripper->position, 0.6);
  EXPECT_EQ(g.events.back().gripper->effort, 3);
  EXPECT_TRUE(g.events.back().gripper->stalled);
  EXPECT_FALSE(g.events.back().gripper->reached_goal);
}

TEST(Gripper, ACancelInTheCycleOfItsGoalIsNotLost) {
  Gripper g;
  g.rig.start();
  const auto goal = g.go(0.5);
  EXPECT_TRUE(g.controller->cancel(goal));
  g.run(0.5);
  ASSERT_EQ(g.events.size(), 2u);
  EXPECT_EQ(g.events[1].outcome, GoalOutcome::canceled);
  EXPECT_EQ(g.rig.command("arm/j1/position"), 0);
  EXPECT_FALSE(g.controller->cancel(goal)) << "it has ended";
  EXPECT_FALSE(g.controller->cancel(0));
  EXPECT_FALSE(g.controller->cancel(goal + 1)) << "there is none";
}

TEST(Gripper, OfSeveralGoalsInOneCycleTheLastIsFollowedAndEachIsAnswered) {
  Gripper g;
  g.rig.start();
  const std::uint64_t first = g.go(0.5), second = g.go(0.3);
  g.run(2);
  ASSERT_EQ(g.events.size(), 4u);
  EXPECT_EQ(g.events[1].goal, first);
  EXPECT_EQ(g.events[1].outcome, GoalOutcome::canceled);
  EXPECT_EQ(g.events[3].goal, second);
  EXPECT_EQ(g.events[3].outcome, GoalOutcome::succeeded);
  EXPECT_EQ(g.rig.command("arm/j1/position"), 0.3);
}

TEST(Gripper, GoalsThatWaitWhenItStartsOrStopsAreAnswered) {
  Gripper g;
  ASSERT_EQ(g.rig.configure(), CallbackReturn::success);
  const auto early = g.go(0.5);
  g.controller->on_activate(g.rig.cycle);
  g.run(0.1);
  ASSERT_EQ(g.events.size(), 1u);
  EXPECT_EQ(g.events[0].goal, early);
  EXPECT_EQ(g.events[0].outcome, GoalOutcome::aborted);
  EXPECT_EQ(g.events[0].code, -1);
  EXPECT_EQ(g.rig.command("arm/j1/position"), 0);
  const auto running = g.go(0.5);
  g.run(0.1);
  const auto late = g.go(0.2);
  g.controller->on_deactivate(g.rig.cycle);
  g.collect();
  ASSERT_EQ(g.events.size(), 4u);
  EXPECT_EQ(g.events[2].goal, running);
  EXPECT_EQ(g.events[2].outcome, GoalOutcome::canceled);
  EXPECT_EQ(g.events[3].goal, late);
  EXPECT_EQ(g.events[3].outcome, GoalOutcome::aborted);
  EXPECT_FALSE(g.controller->cancel(late));
}

TEST(Gripper, AGoalBeyondTheLimitsIsRefusedBeforeItMoves) {
  Gripper g;
  g.rig.context.joints.edit()[0].upper = 0.3;
  g.rig.start();
  EXPECT_THROW(g.go(0.8), Error);
  g.run(0.2);
  EXPECT_TRUE(g.events.empty());
  EXPECT_EQ(g.rig.command("arm/j1/position"), 0);
  g.go(0.30005);  // rounded
  g.run(1);
  EXPECT_EQ(g.rig.command("arm/j1/position"), 0.3);
  ASSERT_EQ(g.events.size(), 2u);
  EXPECT_EQ(g.events[1].outcome, GoalOutcome::succeeded);
}

TEST(Gripper, DuringAStopNothingBegins) {
  Gripper g;
  g.rig.start();
  g.go(0.5);
  g.run(0.2);
  EXPECT_FALSE(g.controller->standing());
  g.rig.verdict.speed = 0;
  g.run(0.02);
  const double at = g.rig.command("arm/j1/position");
  EXPECT_EQ(g.events.back().outcome, GoalOutcome::aborted);
  EXPECT_LT(at, 0.25);
  g.go(0.9);
  g.run(0.2);
  EXPECT_EQ(g.events.back().outcome, GoalOutcome::aborted);
  EXPECT_EQ(g.rig.command("arm/j1/position"), at);
  EXPECT_TRUE(g.controller->standing());
  g.rig.verdict.speed = 1;
  g.run(0.2);
  EXPECT_EQ(g.rig.command("arm/j1/position"), at);
}

/// A finger of 1 kg that is pushed, with a hard stop.
struct EffortGripper : Gripper {
  EffortGripper() : Gripper("effort_controllers/GripperActionController") {
    rig.set("gains.j1.p", {"200"});
    rig.set("gains.j1.d", {"30"});
  }
  double most = 0;
  void push(double seconds, double stop_at = 100) {
    for (int k = 0; k < std::lround(seconds * 100); ++k) {
      rig.step();
      double &p = rig.state("arm/j1/position"), &v = rig.state("arm/j1/velocity");
      most = std::max(most, std::abs(rig.command("arm/j1/effort")));
      v += rig.command("arm/j1/effort") * 0.01;
      p += v * 0.01;
      if (p >= stop_at) p = stop_at, v = 0;
      collect();
    }
  }
};

TEST(EffortGripper, APidBringsItToItsGoal) {
  EffortGripper g;
  g.rig.start();
  EXPECT_EQ(g.controller->command_interfaces(), std::vector<std::string>{"arm/j1/effort"});
  EXPECT_EQ(g.rig.command("arm/j1/effort"), 0);
  g.go(0.5);
  g.push(3);
  ASSERT_EQ(g.events.size(), 2u);
  EXPECT_EQ(g.events[1].outcome, GoalOutcome::succeeded);
  EXPECT_NEAR(g.rig.state("arm/j1/position"), 0.5, 0.01);
  EXPECT_NEAR(g.most, 100, 1e-9) << "no goal and no parameter limits the effort";
  g.controller->on_deactivate(g.rig.cycle);
  EXPECT_EQ(g.rig.command("arm/j1/effort"), 0);
}

TEST(EffortGripper, PushesNoHarderThanTheGoalSays) {
  EffortGripper g;
  g.rig.set("max_effort", {"9"});
  g.rig.start();
  g.controller->receive("gripper_cmd", GripperCommand{0.5, {}, 4.0}, true);
  g.push(4, 0.2);
  EXPECT_EQ(g.most, 4);
  ASSERT_EQ(g.events.size(), 2u);
  EXPECT_EQ(g.events[1].outcome, GoalOutcome::aborted);
  EXPECT_TRUE(g.events[1].gripper->stalled);
  EXPECT_EQ(g.events[1].gripper->effort, 4);
  EXPECT_EQ(g.rig.command("arm/j1/effort"), 4) << "it goes on gripping";
  g.controller->receive("gripper_cmd", GripperCommand{0.5, {}, 0.0}, true);
  g.push(0.1, 0.2);
  EXPECT_EQ(g.most, 9) << "0 is what the parameter says";
}

TEST(EffortGripper, AStopKeepsTheGripAndGainsCanChange) {
  EffortGripper g;
  g.rig.set("max_effort", {"5"});
  g.rig.start();
  g.go(0.5);
  g.push(1, 0.2);
  g.rig.verdict.speed = 0;
  g.push(0.1, 0.2);
  EXPECT_EQ(g.rig.command("arm/j1/effort"), 5);
  change(g, "gains.j1.p", "10");
  g.push(0.01, 0.2);
  EXPECT_NEAR(g.rig.command("arm/j1/effort"), 10 * 0.3, 1e-9);
  EXPECT_THROW(g.rig.context.parameters.change("gains.j1.p", ".inf"), Error);
}

TEST(EffortGripper, NeedsGains) {
  Gripper g("effort_controllers/GripperActionController");
  try {
    g.rig.configure();
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("gains.j1: {p:"), std::string::npos) << e.what();
  }
  EXPECT_EQ(Gripper("position_controllers/GripperActionController").rig.configure(), CallbackReturn::success);
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
  chain.controller->find_output("controller_state")->fetch();
  Made outside = from_outside();
  outside.rig.start();
  Gripper gripper;
  gripper.rig.start();
  gripper.controller->find_output("gripper_state")->fetch();
  EffortGripper pushing;
  pushing.rig.start();
  Made forward("forward_command_controller/ForwardCommandController");
  forward.rig.set("joints", {"j1"});
  forward.rig.start();
  std::string done;
  for (int k = 0; k < 100; ++k) {
    pid.controller->receive("command", Numbers{{0.1 * k}}, false);
    chain.controller->receive("reference", NamedValues{{"j1"}, {0.1 * k}}, false);
    outside.controller->receive("measured_state", NamedValues{{"j2"}, {0.1 * k}}, false);
    gripper.controller->receive("gripper_cmd", GripperCommand{0.01 * k}, true);
    pushing.controller->receive("gripper_cmd", GripperCommand{0.01 * k}, true);
    forward.controller->receive("commands", Numbers{{0.01 * k}}, false);
    const test::RealtimeGuard guard;
    for (Made* made : std::initializer_list<Made*>{&pid, &chain, &outside, &gripper, &pushing, &forward})
      made->controller->update(made->rig.cycle, made->rig.verdict);
    for (Made* made : std::initializer_list<Made*>{&pid, &chain, &pushing})
      made->controller->on_parameters_changed();
    done += guard.violations();
  }
  EXPECT_EQ(done, "");
}

}  // namespace
}  // namespace polyarm::controllers
