#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/controllers/trajectory_rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

void expect_commands(const TrajectoryRig& rig, const std::vector<double>& wanted, double tolerance = 1e-8) {
  for (std::size_t j = 0; j < wanted.size(); ++j)
    EXPECT_NEAR(rig.commanded(j), wanted[j], tolerance) << "joint " << j + 1;
}

std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.problems().front().code;
  }
  return "none";
}

TEST(JointTrajectory, HoldsWhereItFindsTheJoints) {
  TrajectoryRig rig;
  rig.start();
  rig.run(0.5);
  expect_commands(rig, {1.1, 2.1, 3.1});
}

TEST(JointTrajectory, BeginsAtTheLastCommandSoThatNothingSags) {
  TrajectoryRig rig;
  rig.configure();
  rig.commands.assign(3, 1.5);  // left by the controller before it; the joints hang a little below
  rig.activate();
  rig.step();
  expect_commands(rig, {1.5, 1.5, 1.5});
  TrajectoryRig measured;
  measured.set("set_last_command_interface_value_as_state_on_activation", {"false"});
  measured.configure();
  measured.commands.assign(3, 1.5);
  measured.activate();
  expect_commands(measured, {1.1, 2.1, 3.1});
}

TEST(JointTrajectory, PositionsAloneAreJoinedByLines) {
  TrajectoryRig rig({0});
  rig.start();
  rig.send({point(1, {1}), point(2, {2}), point(3, {3})});
  rig.run(0.5);
  expect_commands(rig, {0.5});
  rig.run(1.0);
  expect_commands(rig, {1.5});
  rig.run(1.0);
  expect_commands(rig, {2.5});
  rig.run(2.0);
  expect_commands(rig, {3});
}

TEST(JointTrajectory, VelocitiesMakeCubicsAndAccelerationsQuintics) {
  TrajectoryRig rig({0});
  rig.set("command_interfaces", {"position", "velocity", "acceleration"});
  rig.set("state_interfaces", {"position", "velocity"});
  rig.start();
  rig.send({point(1, {2}, {0}, {0})});
  rig.run(0.5);
  EXPECT_NEAR(rig.commanded(0), 1, 1e-9);
  EXPECT_NEAR(rig.commanded(0, "velocity"), 2 * 15.0 / 8, 1e-9)
      << "the middle of a quintic from rest to rest";
  EXPECT_NEAR(rig.commanded(0, "acceleration"), 0, 1e-9);
  rig.run(1);
  rig.send({point(1, {0}, {0})});
  rig.run(0.5);
  EXPECT_NEAR(rig.commanded(0, "velocity"), -3, 1e-9) << "the middle of a cubic from rest to rest";
}

TEST(JointTrajectory, WithoutInterpolationItGoesInSteps) {
  TrajectoryRig rig({0});
  rig.set("interpolation_method", {"none"});
  rig.start();
  rig.send({point(1, {1}), point(2, {2}), point(3, {3})});
  rig.run(0.9);
  expect_commands(rig, {0});
  rig.run(0.3);
  expect_commands(rig, {2});
  rig.run(1);
  expect_commands(rig, {3});
}

TEST(JointTrajectory, TakesJointsInAnyOrder) {
  TrajectoryRig rig;
  rig.start();
  rig.send({point(0.25, {3, 2, 1})}, {"j3", "j2", "j1"});
  rig.run(0.3);
  expect_commands(rig, {1, 2, 3});
}

TEST(JointTrajectory, APartialGoalLetsTheOthersHold) {
  TrajectoryRig rig;
  rig.set("allow_partial_joints_goal", {"true"});
  rig.start();
  rig.send({point(0.25, {2, 3, 4})});
  rig.run(0.5);
  expect_commands(rig, {2, 3, 4});
  rig.send({point(0.25, {1.5})}, {"j1"});
  rig.run(0.5);
  expect_commands(rig, {1.5, 3, 4});
}

TEST(JointTrajectory, APartialGoalMustBeAllowed) {
  TrajectoryRig rig;
  rig.start();
  EXPECT_EQ(refusal([&] { rig.send({point(0.25, {1.5})}, {"j1"}); }), "missing-joint");
}

TEST(JointTrajectory, WhatBeginsLaterLeavesTheOldOneUntilThen) {
  TrajectoryRig rig;
  rig.set("allow_partial_joints_goal", {"true"});
  rig.start();
  rig.send({point(1, {4, 6, 8})});
  TrajectoryMessage later = rig.message({point(0.5, {-2, -4})}, {"j1", "j2"});
  later.start = 2'000'000'000;
  rig.jtc.receive("joint_trajectory", later, false);
  rig.run(1.5);
  expect_commands(rig, {4, 6, 8});
  rig.run(1.2);
  expect_commands(rig, {-2, -4, 8});
}

TEST(JointTrajectory, WhatLeavesJointsOutLetsTheirOldOneGoOn) {
  TrajectoryRig rig;
  rig.set("allow_partial_joints_goal", {"true"});
  rig.start();
  rig.send({point(1, {2.1, 3.1, 4.1})});
  rig.run(0.5);
  rig.send({point(0.2, {0})}, {"j1"});
  rig.run(0.3);
  expect_commands(rig, {0, 2.9, 3.9});
  rig.run(0.5);
  expect_commands(rig, {0, 3.1, 4.1});
}

TEST(JointTrajectory, AReplacementNeverJumpsNorStopsAtOnce) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> somewhere(-2, 2), soon(0.05, 0.9);
  TrajectoryRig rig({0, 0});
  rig.start();
  double before = 0, speed = 0;
  for (int k = 0; k < 200; ++k) {
    std::vector<trajectory::TrajectoryPoint> points;
    const double t = soon(random) + 0.4;
    points.push_back(point(t, {somewhere(random), 0}, {somewhere(random), 0}));
    points.push_back(point(2 * t, {somewhere(random), 0}, {0, 0}));
    rig.send(points);
    for (int i = 0; i < std::lround(soon(random) * 100); ++i) {
      rig.step();
      const double now = rig.commanded(0) - before;
      EXPECT_LT(std::abs(now - speed), 0.02) << "velocity goes on over a replacement";
      speed = now;
      before = rig.commanded(0);
    }
  }
}

TEST(JointTrajectory, WithoutReplacementTheOthersStopAtOnce) {
  TrajectoryRig rig;
  rig.set("allow_partial_joints_goal", {"true"});
  rig.set("allow_trajectory_replacement", {"false"});
  rig.start();
  rig.send({point(1, {2.1, 3.1, 4.1})});
  rig.run(0.5);
  const double held = rig.commanded(1);
  rig.send({point(0.2, {0})}, {"j1"});
  rig.run(0.5);
  expect_commands(rig, {0, held, rig.commanded(2)});
  EXPECT_LT(held, 2.7);
}

TEST(JointTrajectory, ATrajectoryThatIsOverAlreadyIsRefusedAndTheOldOneGoesOn) {
  TrajectoryRig rig({0});
  rig.start();
  rig.run(3);
  rig.send({point(1, {1})});
  rig.run(0.5);
  TrajectoryMessage past = rig.message({point(0.5, {9})});
  past.start = 1'000'000'000;
  EXPECT_EQ(refusal([&] { rig.jtc.receive("joint_trajectory", past, false); }), "in-the-past");
  rig.run(0.6);
  expect_commands(rig, {1});
}

TEST(JointTrajectory, OneThatHasBegunAlreadyIsTakenUpOnItsWay) {
  TrajectoryRig rig({0});
  rig.start();
  rig.run(3);
  TrajectoryMessage begun = rig.message({point(0.5, {9}), point(2, {1})});
  begun.start = 2'000'000'000;
  rig.jtc.receive("joint_trajectory", begun, false);
  rig.run(0.5);
  EXPECT_GT(rig.commanded(0), 0.3);
  EXPECT_LT(rig.commanded(0), 0.7);
  rig.run(0.6);
  expect_commands(rig, {1});
}

TEST(JointTrajectory, WrongMessagesAreRefusedByName) {
  TrajectoryRig rig;
  rig.start();
  const std::vector<double> p{1, 2, 3};
  EXPECT_EQ(refusal([&] { rig.send({}); }), "no-points");
  EXPECT_EQ(refusal([&] { rig.send({point(1, p)}, {"j1", "j2", "elbow"}); }), "unknown-joint");
  EXPECT_EQ(refusal([&] { rig.send({point(1, {1, 2, 3})}, {"j1", "j2", "j2"}); }), "unknown-joint");
  EXPECT_EQ(refusal([&] { rig.send({point(1, p), point(1, p)}); }), "bad-time");
  EXPECT_EQ(refusal([&] { rig.send({point(2, p), point(1, p)}); }), "bad-time");
  EXPECT_EQ(refusal([&] { rig.send({point(1, {1, 2})}); }), "wrong-size");
  EXPECT_EQ(refusal([&] { rig.send({point(1, p, {0, 0})}); }), "wrong-size");
  EXPECT_EQ(refusal([&] { rig.send({point(1, p, {0, 0, 0.1})}); }), "moves-at-end");
  EXPECT_EQ(refusal([&] { rig.send({point(1, {}, {1, 1, 0})}); }), "no-positions");
  EXPECT_EQ(refusal([&] { rig.jtc.receive("joint_trajectory", Numbers{{1}}, false); }), "wrong-message");
  TrajectoryMessage effort = rig.message({point(1, p)});
  effort.points[0].effort = {1, 1, 1};
  EXPECT_EQ(refusal([&] { rig.jtc.receive("joint_trajectory", effort, false); }), "no-effort");
  TrajectoryMessage nameless;
  nameless.points = {point(1, p)};
  EXPECT_EQ(refusal([&] { rig.jtc.receive("joint_trajectory", nameless, false); }), "no-joints");
  rig.run(1.5);
  expect_commands(rig, {1.1, 2.1, 3.1});
}

TEST(JointTrajectory, AVelocityAtTheEndMustBeAllowed) {
  TrajectoryRig rig({0});
  rig.set("allow_nonzero_velocity_at_trajectory_end", {"true"});
  rig.start();
  EXPECT_NO_THROW(rig.send({point(1, {1}, {0.5})}));
}

TEST(JointTrajectory, VelocitiesAloneAreIntegratedWhereAllowed) {
  TrajectoryRig rig({10});
  rig.set("allow_integration_in_goal_trajectories", {"true"});
  rig.set("allow_nonzero_velocity_at_trajectory_end", {"true"});
  rig.start();
  rig.send({point(1, {}, {1}), point(2, {}, {2}), point(3, {}, {1})});
  rig.run(0.5);
  expect_commands(rig, {10.125});
  rig.run(0.5);
  expect_commands(rig, {10.5});
  rig.run(0.5);
  expect_commands(rig, {11.125});
  rig.run(1.5);
  expect_commands(rig, {13.5});
}

TEST(JointTrajectory, AContinuousJointTurnsTheShorterWay) {
  TrajectoryRig rig({0});
  rig.context.joints.edit()[0].continuous = true;
  rig.start();
  rig.send({point(1, {1.5 * M_PI})});
  rig.run(1.1);
  expect_commands(rig, {-0.5 * M_PI});
}

TEST(JointTrajectory, ChunksOfPositionsBecomeASmoothCurve) {
  TrajectoryRig rig({0});
  rig.set("command_interfaces", {"position", "velocity"});
  rig.set("positions_upsampling.enable", {"true"});
  rig.set("positions_upsampling.policy_frequency", {"10"});
  rig.start();
  rig.send({point(0.1, {0}), point(0.2, {.1}), point(0.3, {.3})});
  rig.run(0.2);
  EXPECT_NEAR(rig.commanded(0), .1, 1e-9);
  EXPECT_NEAR(rig.commanded(0, "velocity"), 2.25, 1e-9);
}

// --- goals ------------------------------------------------------------------------------------------------

TEST(JointTrajectoryAction, SucceedsAtTheEnd) {
  TrajectoryRig rig;
  rig.start();
  const auto id = rig.send_goal(rig.message({point(0.5, {1, 2, 3})}));
  rig.run(0.4);
  ASSERT_EQ(rig.events.size(), 1u);
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::accepted);
  rig.run(0.3);
  ASSERT_EQ(rig.events.size(), 2u);
  EXPECT_EQ(rig.last()->goal, id);
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::succeeded);
  EXPECT_EQ(rig.last()->code, 0);
}

TEST(JointTrajectoryAction, FarFromItsPathItEndsAndHoldsWhereTheJointsAre) {
  TrajectoryRig rig;
  rig.set("constraints.j1.trajectory", {"0.0001"});
  rig.start();
  rig.follows = false;  // states stay where they are
  rig.send_goal(rig.message({point(0.5, {4, 5, 6})}));
  rig.run(0.2);
  ASSERT_EQ(rig.events.size(), 2u);
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::aborted);
  EXPECT_EQ(rig.last()->code, -4);
  EXPECT_EQ(rig.last()->joint, 0);
  expect_commands(rig, {1.1, 2.1, 3.1});
}

TEST(JointTrajectoryAction, FarFromItsGoalItEndsWhenTheTimeIsUp) {
  TrajectoryRig rig;
  for (const char* joint : {"j1", "j2", "j3"})
    rig.set(std::string("constraints.") + joint + ".goal", {"0.1"});
  rig.set("constraints.goal_time", {"0.000001"});
  rig.start();
  rig.follows = false;
  rig.send_goal(rig.message({point(0.5, {4, 5, 6})}));
  rig.run(0.7);
  ASSERT_EQ(rig.events.size(), 2u);
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::aborted);
  EXPECT_EQ(rig.last()->code, -5);
  expect_commands(rig, {1.1, 2.1, 3.1});
}

TEST(JointTrajectoryAction, FarFromItsGoalWithoutTolerancesItSucceedsAndNamesTheJoint) {
  TrajectoryRig rig;
  rig.start();
  rig.follows = false;
  rig.send_goal(rig.message({point(0.5, {1.1, 2.197, 3.1})}));
  rig.run(0.7);
  ASSERT_EQ(rig.events.size(), 2u);
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::succeeded);
  EXPECT_EQ(rig.last()->joint, 1);
  EXPECT_NEAR(rig.last()->error, 0.097, 1e-9);
  EXPECT_EQ(rig.last()->tolerance, 0);
}

TEST(JointTrajectoryAction, WithoutAGoalTimeItWaits) {
  TrajectoryRig rig({0});
  rig.set("constraints.j1.goal", {"0.1"});
  rig.start();
  rig.follows = false;
  rig.send_goal(rig.message({point(0.5, {4})}));
  rig.run(20);
  EXPECT_EQ(rig.events.size(), 1u);
  rig.positions[0] = 3.95;
  rig.run(0.1);
  ASSERT_EQ(rig.events.size(), 2u);
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::succeeded);
}

TEST(JointTrajectoryAction, TolerancesOfTheGoalTakeTheDefaultsPlace) {
  const auto outcome = [](std::vector<JointTolerance> path) {
    TrajectoryRig rig({0});
    rig.set("constraints.j1.trajectory", {"0.5"});
    rig.start();
    rig.follows = false;
    TrajectoryMessage message = rig.message({point(1, {0.3})});
    message.path_tolerance = std::move(path);
    rig.send_goal(message);
    rig.run(1.5);
    return rig.last()->outcome;
  };
  EXPECT_EQ(outcome({}), GoalOutcome::succeeded) << "the default is 0.5";
  EXPECT_EQ(outcome({{"j1", 0.1}}), GoalOutcome::aborted) << "a value above 0 counts";
  EXPECT_EQ(outcome({{"j1", 0}}), GoalOutcome::succeeded) << "0 takes the default";
  EXPECT_EQ(outcome({{"j1", -1}}), GoalOutcome::succeeded) << "-1 switches off";
  EXPECT_EQ(outcome({{"j1", 0.1}, {"other", 0.1}}), GoalOutcome::succeeded)
      << "an unknown joint: all defaults";
  EXPECT_EQ(outcome({{"j1", 0.1, -5}}), GoalOutcome::succeeded) << "another negative value: all defaults";
}

TEST(JointTrajectoryAction, ANewGoalEndsTheOldOne) {
  TrajectoryRig rig({0});
  rig.start();
  const auto first = rig.send_goal(rig.message({point(1, {1})}));
  rig.run(0.3);
  const auto second = rig.send_goal(rig.message({point(1, {2})}));
  rig.run(2);
  ASSERT_EQ(rig.events.size(), 4u);
  EXPECT_EQ(rig.events[1].goal, first);
  EXPECT_EQ(rig.events[1].outcome, GoalOutcome::aborted);
  EXPECT_EQ(rig.events[1].code, -1);
  EXPECT_EQ(rig.events[3].goal, second);
  EXPECT_EQ(rig.events[3].outcome, GoalOutcome::succeeded);
}

TEST(JointTrajectoryAction, ATopicReplacesTheTrajectoryAndNotTheGoal) {
  TrajectoryRig rig({0});
  rig.start();
  rig.send_goal(rig.message({point(1, {1})}));
  rig.run(0.3);
  rig.send({point(0.5, {-1})});
  rig.run(1);
  expect_commands(rig, {-1});
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::succeeded);
}

TEST(JointTrajectoryAction, ACancelHoldsAtOnce) {
  TrajectoryRig rig({0});
  rig.start();
  const auto id = rig.send_goal(rig.message({point(1, {1})}));
  rig.run(0.5);
  EXPECT_TRUE(rig.jtc.cancel(id));
  const double at = rig.commanded(0);
  rig.run(0.5);
  EXPECT_NEAR(rig.commanded(0), at, 1e-9);
  EXPECT_EQ(rig.last()->outcome, GoalOutcome::canceled);
  EXPECT_EQ(rig.last()->code, 0);
}

TEST(JointTrajectoryAction, ACancelSlowsEachJointDownInItsOwnTime) {
  TrajectoryRig rig({0, 0, 0});
  rig.set("constraints.decelerate_on_cancel", {"true"});
  for (const char* joint : {"j1", "j2", "j3"})
    rig.set(std::string("constraints.") + joint + ".max_deceleration_on_cancel", {"10"});
  rig.start();
  const auto id = rig.send_goal(rig.message({point(1, {1, 1, 1})}));
  rig.run(0.5);
  rig.follows = false;
  rig.positions = {0.5, 0.5, 0.5};
  rig.velocities = {0.2, -0.1, 0};
  rig.jtc.cancel(id);
  rig.run(1);
  expect_commands(rig, {0.5 + 0.002, 0.5 - 0.0005, 0.5});
}

TEST(JointTrajectoryAction, DeactivationEndsAGoal) {
  TrajectoryRig rig({0});
  rig.start();
  rig.send_goal(rig.message({point(1, {1})}));
  rig.run(0.5);
  rig.jtc.on_deactivate(rig.cycle);
  const auto event = rig.jtc.next_goal_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->outcome, GoalOutcome::aborted);
  EXPECT_EQ(event->code, -1);
}

// --- speed ------------------------------------------------------------------------------------------------

TEST(JointTrajectory, ScalingSlowsTimeDown) {
  TrajectoryRig rig({0});
  rig.start();
  rig.jtc.receive("speed_scaling_input", Numbers{{0.5}}, false);
  rig.send({point(1, {1})});
  rig.run(1);
  EXPECT_NEAR(rig.commanded(0), 0.5, 1e-9);
  rig.run(1);
  EXPECT_NEAR(rig.commanded(0), 1, 1e-9);
  EXPECT_EQ(refusal([&] { rig.jtc.receive("speed_scaling_input", Numbers{{-1}}, false); }), "bad-value");
}

TEST(JointTrajectory, ABlendUnderScalingDoesNotJump) {
  TrajectoryRig rig({0});
  rig.start();
  rig.jtc.receive("speed_scaling_input", Numbers{{0.3}}, false);
  rig.send({point(1, {1}, {0})});
  rig.run(1.5);
  const double before = rig.commanded(0);
  rig.step();
  const double speed = rig.commanded(0) - before;
  rig.send({point(1, {-1}, {0})});
  const double at = rig.commanded(0);
  rig.step();
  EXPECT_NEAR(rig.commanded(0) - at, speed, 0.4 * std::abs(speed));
}

TEST(JointTrajectory, AStopStaysOnThePathAndEndsInAHold) {
  TrajectoryRig rig({0, 0});
  rig.start();
  rig.send({point(2, {1, 2}, {0, 0})});
  rig.run(0.5);
  rig.verdict.speed = 0;
  rig.run(5);
  EXPECT_TRUE(rig.jtc.standing());
  const double held = rig.commanded(0);
  EXPECT_NEAR(rig.commanded(1), 2 * held, 1e-9);
  rig.verdict.speed = 1;
  rig.run(5);
  expect_commands(rig, {1, 2});
}

// --- closed loops -----------------------------------------------------------------------------------------

TEST(JointTrajectory, VelocityAloneGoesThroughThePid) {
  TrajectoryRig rig({0});
  rig.set("command_interfaces", {"velocity"});
  rig.set("gains.j1.p", {"10"});
  rig.set("gains.j1.ff_velocity_scale", {"1"});
  rig.start();
  rig.follows = false;
  rig.send({point(1, {1}, {0})});
  for (int k = 0; k < 300; ++k) {
    rig.step();
    rig.velocities[0] = rig.commanded(0, "velocity");
    rig.positions[0] += rig.velocities[0] * 0.01;
  }
  EXPECT_NEAR(rig.positions[0], 1, 1e-3);
  EXPECT_NEAR(rig.velocities[0], 0, 1e-2);
}

TEST(JointTrajectory, EffortHoldsAMassAgainstItsWeight) {
  TrajectoryRig rig({0});
  rig.set("command_interfaces", {"effort"});
  rig.set("gains.j1.p", {"400"});
  rig.set("gains.j1.i", {"200"});
  rig.set("gains.j1.d", {"40"});
  rig.start();
  rig.follows = false;
  rig.send({point(1, {1}, {0})});
  for (int k = 0; k < 2000; ++k) {
    rig.step();
    rig.velocities[0] += (rig.commanded(0, "effort") - 9.81) * 0.01;
    rig.positions[0] += rig.velocities[0] * 0.01;
  }
  EXPECT_NEAR(rig.positions[0], 1, 1e-3);
}

TEST(JointTrajectory, WhatPushesStopsPushingWhenItEnds) {
  TrajectoryRig rig({0});
  rig.set("command_interfaces", {"effort"});
  rig.set("gains.j1.p", {"400"});
  rig.start();
  rig.follows = false;
  rig.positions[0] = 0.5;
  rig.run(0.1);
  EXPECT_NE(rig.commanded(0, "effort"), 0);
  rig.jtc.on_deactivate(rig.cycle);
  EXPECT_EQ(rig.commanded(0, "effort"), 0);
}

TEST(JointTrajectory, ImpossibleInterfacesAreRefused) {
  const auto commanding = [](std::vector<std::string> commands, std::vector<std::string> states) {
    TrajectoryRig rig({0});
    rig.set("command_interfaces", std::move(commands));
    rig.set("state_interfaces", std::move(states));
    return refusal([&] { rig.configure(); });
  };
  EXPECT_EQ(commanding({"position"}, {"position"}), "none");
  EXPECT_EQ(commanding({"position", "velocity", "acceleration"}, {"position", "velocity"}), "none");
  EXPECT_EQ(commanding({"position", "effort"}, {"position", "velocity"}), "none");
  EXPECT_EQ(commanding({"velocity"}, {"position"}), "unsupported-interface");
  EXPECT_EQ(commanding({"effort"}, {"position"}), "unsupported-interface");
  EXPECT_EQ(commanding({"acceleration"}, {"position", "velocity"}), "unsupported-interface");
  EXPECT_EQ(commanding({"velocity", "effort"}, {"position", "velocity"}), "unsupported-interface");
}

TEST(JointTrajectory, GainsChangeWhileItRuns) {
  TrajectoryRig rig({0});
  rig.set("command_interfaces", {"velocity"});
  rig.set("gains.j1.p", {"1"});
  rig.start();
  rig.follows = false;
  rig.positions[0] = -1;  // one away from what it holds
  rig.step();
  EXPECT_NEAR(rig.commanded(0, "velocity"), 1, 1e-9);
  const ParameterChange change = rig.context.parameters.change("gains.j1.p", "5");
  EXPECT_EQ(rig.jtc.refuse_changes({change}), "");
  change.apply();
  rig.jtc.on_parameters_changed();
  rig.step();
  EXPECT_NEAR(rig.commanded(0, "velocity"), 5, 1e-9);
  EXPECT_NE(rig.jtc.refuse_changes({rig.context.parameters.change("gains.j1.i_clamp_min", "1")}), "");
  EXPECT_EQ(refusal([&] { rig.context.parameters.change("joints", "x"); }), "not-changeable");
  EXPECT_EQ(refusal([&] { rig.context.parameters.change("gains.j1.pp", "1"); }), "unknown-parameter");
}

TEST(JointTrajectory, UnknownAndOldKeysAreTold) {
  TrajectoryRig rig({0});
  rig.set("constraints.j1.goall", {"0.1"});
  rig.set("state_publish_rate", {"50"});
  rig.configure();
  rig.context.parameters.finish("jtc");
  std::string told;
  for (const Problem& problem : rig.context.parameters.problems().list()) told += problem.text() + "\n";
  EXPECT_NE(told.find("controllers.yaml:7"), std::string::npos) << told;
  EXPECT_NE(told.find("did you mean 'constraints.j1.goal'"), std::string::npos) << told;
  EXPECT_NE(told.find("state_publish_rate"), std::string::npos) << told;
}

TEST(JointTrajectory, AllocatesAndWaitsForNothing) {
  TrajectoryRig rig({0, 0, 0, 0, 0, 0});
  rig.set("command_interfaces", {"velocity"});
  for (int j = 1; j <= 6; ++j) rig.set("gains.j" + std::to_string(j) + ".p", {"2"});
  rig.set("constraints.j1.trajectory", {"50"});
  rig.start();
  rig.jtc.find_output("controller_state")->fetch();
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  std::string done;
  for (int k = 0; k < 20; ++k) {
    rig.send_goal(rig.message({point(0.1, std::vector<double>(6, 0.1 * k), std::vector<double>(6, 0.0))}));
    rig.measure();
    const test::RealtimeGuard guard;
    for (int i = 0; i < 15; ++i) {
      rig.jtc.update(rig.cycle, rig.verdict);
      rig.cycle.time += TrajectoryRig::kPeriod;
    }
    done += guard.violations();
  }
  EXPECT_EQ(done, "");
}

}  // namespace
}  // namespace polyarm::controllers
