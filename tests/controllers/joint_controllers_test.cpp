#include <gtest/gtest.h>

#include <algorithm>
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

void change(Made& m, const std::string& key, const std::string& value) {
  const ParameterChange change = m.rig.context.parameters.change(key, value);
  ASSERT_EQ(m.controller->refuse_changes({change}), "");
  change.apply();
  m.controller->on_parameters_changed();
}

TEST(JointPid, AnEffortBringsAMassToItsPositionAndHoldsItAgainstItsWeight) {
  Made m("effort_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"400"});
  m.rig.set("pid.i", {"200"});
  m.rig.set("pid.i_clamp", {"50"});
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
  m.rig.set("pid.i_clamp", {"50"});
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
  EXPECT_NE(m.controller->refuse_changes({p.change("pid.i", ".inf")}), "");
  EXPECT_NE(m.controller->refuse_changes({p.change("pid.u_clamp_max", "-.inf")}), "");
  const ParameterChange change = p.change("pid.p", "3");
  EXPECT_EQ(m.controller->refuse_changes({change}), "");
  change.apply();
  m.controller->on_parameters_changed();
  m.controller->receive("command", Numbers{{1}}, false);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/velocity"), 3, 1e-9);
}

TEST(JointPid, ThePresentErrorEntersTheIntegralFirst) {
  Made m("effort_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"0"});
  m.rig.set("pid.i", {"100"});
  m.rig.set("pid.i_clamp", {"1.5"});
  m.rig.start();
  m.controller->receive("command", Numbers{{1}}, false);
  const auto effort = [&] { return m.rig.step(), m.rig.command("arm/j1/effort"); };
  EXPECT_NEAR(effort(), 1, 1e-12);
  EXPECT_NEAR(effort(), 1.5, 1e-12) << "clamped";
  m.rig.state("arm/j1/position") = 2;
  EXPECT_NEAR(effort(), 1, 1e-12) << "the integral had grown to 2 behind its clamp";
}

TEST(JointPid, WithAntiWindupTheIntegralDoesNotGrowBehindItsClamp) {
  Made m("effort_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"0"});
  m.rig.set("pid.i", {"100"});
  m.rig.set("pid.i_clamp_max", {"1.5"});
  m.rig.set("pid.i_clamp_min", {"-1"});
  m.rig.set("pid.antiwindup", {"true"});
  m.rig.start();
  m.controller->receive("command", Numbers{{1}}, false);
  m.rig.step();
  m.rig.step();
  m.rig.state("arm/j1/position") = 2;
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 0.5, 1e-12);
}

TEST(JointPid, WithoutAClampTheIntegralHasNoShareAndThatIsAWarning) {
  Made m("effort_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"2"});
  m.rig.set("pid.i", {"100"});
  m.rig.start();
  const std::vector<Problem>& told = m.rig.context.parameters.problems().list();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].severity, Severity::warning);
  EXPECT_NE(told[0].text().find("i_clamp"), std::string::npos) << told[0].text();
  m.controller->receive("command", Numbers{{1}}, false);
  for (int k = 0; k < 10; ++k) m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 2, 1e-12);
}

TEST(JointPid, WithoutGainsItIsNotConfigured) {
  Made m("effort_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.i", {"1"});
  try {
    m.rig.configure();
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("controllers.yaml:3"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("pid: {p:"), std::string::npos) << e.what();
  }
}

TEST(JointPid, OnePidOfAGroupIsChangedForEveryJoint) {
  Made m("effort_controllers/JointGroupPositionController", {"j1", "j2", "j3"});
  m.rig.set("joints", {"j1", "j2", "j3"});
  m.rig.set("pid.p", {"1"});
  m.rig.set("j3.pid.p", {"5"});
  m.rig.start();
  m.controller->receive("commands", Numbers{{1, 1, 1}}, false);
  change(m, "pid.p", "3");
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 3, 1e-12);
  EXPECT_NEAR(m.rig.command("arm/j2/effort"), 3, 1e-12);
  EXPECT_NEAR(m.rig.command("arm/j3/effort"), 5, 1e-12);
}

TEST(JointPid, TellsWhatJointControllerStateHas) {
  Made m("velocity_controllers/JointPositionController");
  m.rig.context.joints[0].continuous = true;
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"2"});
  m.rig.set("pid.i", {"3"});
  m.rig.set("pid.i_clamp", {"4"});
  m.rig.set("pid.antiwindup", {"true"});
  m.rig.start();
  Output& told = *m.controller->find_output("state");
  told.fetch();
  m.controller->receive("command", Numbers{{6}}, false);
  m.rig.state("arm/j1/velocity") = 0.5;
  m.rig.step();
  ASSERT_TRUE(told.fetch());
  const double turn = 6 - 2 * M_PI;
  const std::vector<std::pair<const char*, double>> wanted{{"set_point", 6},
                                                           {"process_value", 0},
                                                           {"process_value_dot", 0.5},
                                                           {"error", turn},
                                                           {"time_step", 0.01},
                                                           {"command", 2 * turn + 3 * turn * 0.01},
                                                           {"p", 2},
                                                           {"i", 3},
                                                           {"d", 0},
                                                           {"i_clamp", 4},
                                                           {"antiwindup", 1}};
  ASSERT_EQ(told.fields().size(), wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    EXPECT_EQ(told.fields()[k], std::string("j1.") + wanted[k].first);
    EXPECT_NEAR(told.value().values[k], wanted[k].second, 1e-12) << wanted[k].first;
  }
}

TEST(JointPid, WhatIsSentDuringAStopIsNotFollowed) {
  Made m("velocity_controllers/JointPositionController");
  m.rig.set("joint", {"j1"});
  m.rig.set("pid.p", {"10"});
  m.rig.start();
  m.rig.verdict.speed = 0;
  m.rig.step();
  m.controller->receive("command", Numbers{{1}}, false);
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 0);
  m.rig.verdict.speed = 1;
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 0);
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

TEST(ForwardControllers, EveryFormOfGainsIsTold) {
  const std::vector<std::pair<std::string, std::string>> forms{
      {"pid.i", "'pid'"},           {"pid.d", "'pid'"},
      {"pid.i_clamp", "'pid'"},     {"pid", "'pid'"},
      {"j1.pid.p", "'j1.pid'"},     {"j1.pid", "'j1.pid'"},
      {"gains.j1.i", "'gains.j1'"}, {"pid.j1.antiwindup", "'pid.j1'"},
      {"gains", "'gains'"}};
  for (const auto& [key, named] : forms) {
    Made m("position_controllers/JointGroupPositionController");
    m.rig.set("joints", {"j1"});
    m.rig.set(key, {"10"});
    m.rig.start();
    m.rig.context.parameters.finish("c");
    ASSERT_EQ(m.rig.context.parameters.problems().list().size(), 1u) << key;
    EXPECT_EQ(m.rig.context.parameters.problems().list()[0].code, "no-effect") << key;
    EXPECT_NE(m.rig.context.parameters.problems().list()[0].what.find(named), std::string::npos) << key;
  }
}

TEST(ForwardControllers, EachBlockOfGainsIsToldOnceWhereItBegins) {
  Made m("effort_controllers/JointGroupEffortController", {"j1", "j2"});
  m.rig.set("joints", {"j1", "j2"});
  for (const char* key : {"j1.pid.i", "j1.pid.p", "j2.pid.d"}) m.rig.set(key, {"1"});
  m.rig.context.parameters.entries["j1.pid.p"].where.line = 2;
  m.rig.start();
  m.rig.context.parameters.finish("c");
  const std::vector<Problem>& told = m.rig.context.parameters.problems().list();
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0].where.line, 2);
  EXPECT_EQ(told[1].where.line, 3);
}

// --- the chainable PID ------------------------------------------------------------------------------------

/// Position and velocity of each joint asked for and measured; an effort is commanded.
Made chainable(const std::vector<std::string>& joints = {"j1"}) {
  Made m("pid_controller/PidController", joints);
  m.rig.set("dof_names", joints);
  m.rig.set("command_interface", {"effort"});
  m.rig.set("reference_and_state_interfaces", {"position", "velocity"});
  for (const std::string& joint : joints) {
    m.rig.set("gains." + joint + ".p", {"10"});
    m.rig.set("gains." + joint + ".d", {"2"});
    m.rig.set("gains." + joint + ".feedforward_gain", {"0.5"});
  }
  return m;
}

TEST(PidController, OffersReferencesAndBeginsWhereItIs) {
  Made m = chainable({"j1", "j2"});
  ASSERT_EQ(m.rig.configure(), CallbackReturn::success);
  const std::vector<std::string> names{"pid/j1/position", "pid/j2/position", "pid/j1/velocity",
                                       "pid/j2/velocity"};
  EXPECT_EQ(m.controller->reference_interfaces(), names);
  EXPECT_EQ(m.controller->exported_states(), names) << "what is measured";
  m.rig.state("arm/j1/position") = 2;
  m.rig.state("arm/j1/velocity") = 0.5;
  m.controller->on_activate(m.rig.cycle);
  EXPECT_EQ(m.rig.command("pid/j1/position"), 2);
  EXPECT_EQ(m.rig.command("pid/j1/velocity"), 0);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), -2 * 0.5, 1e-12) << "it is held, and braked";
  EXPECT_EQ(m.rig.state("pid/j1/position"), 2);
  EXPECT_EQ(m.rig.state("pid/j1/velocity"), 0.5);
}

TEST(PidController, TakesReferencesFromMessagesUnlessItIsChained) {
  Made m = chainable();
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1", "j1/dot"}, {1, 0.25}}, false);
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 10 * 1 + 2 * 0.25 + 0.5 * 0.25, 1e-12);
  m.controller->set_chained(true);
  m.controller->receive("reference", NamedValues{{"j1"}, {9}}, false);
  m.rig.command("pid/j1/position") = 3;
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 10 * 3 + 2 * 0.25 + 0.5 * 0.25, 1e-12);
  EXPECT_THROW(m.controller->receive("reference", NamedValues{{"elbow"}, {9}}, false), Error);
  EXPECT_THROW(m.controller->receive("reference", NamedValues{{"j1"}, {}}, false), Error);
}

TEST(PidController, OfTwoReferencesTheDerivativeIsFedForward) {
  Made two = chainable();
  two.rig.set("gains.j1.p", {"0"});
  two.rig.set("gains.j1.d", {"0"});
  two.rig.start();
  two.controller->receive("reference", NamedValues{{"j1", "j1/dot"}, {4, 6}}, false);
  two.rig.step();
  EXPECT_NEAR(two.rig.command("arm/j1/effort"), 0.5 * 6, 1e-12);
  Made one = chainable();
  one.rig.set("reference_and_state_interfaces", {"position"});
  one.rig.set("gains.j1.p", {"0"});
  one.rig.set("gains.j1.d", {"0"});
  one.rig.start();
  one.controller->receive("reference", NamedValues{{"j1", "j1/dot"}, {4, 6}}, false);
  one.rig.step();
  EXPECT_NEAR(one.rig.command("arm/j1/effort"), 0.5 * 4, 1e-12);
}

TEST(PidController, FeedForwardCanBeSwitchedOffAndOn) {
  Made m = chainable();
  m.rig.set("gains.j1.d", {"0"});
  m.rig.set("enable_feedforward", {"false"});
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1/dot"}, {2}}, false);
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/effort"), 0);
  change(m, "enable_feedforward", "true");
  m.rig.step();
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 0.5 * 2, 1e-12);
}

TEST(PidController, AStopHoldsWhereItIsAndNothingAskedForBeforeComesBack) {
  Made m = chainable();
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1", "j1/dot"}, {1, 0.25}}, false);
  m.rig.state("arm/j1/velocity") = 0.3;
  m.rig.step();
  EXPECT_FALSE(m.controller->standing());
  m.rig.verdict.speed = 0;
  m.rig.state("arm/j1/position") = 0.4;
  m.rig.step();
  EXPECT_EQ(m.rig.command("pid/j1/position"), 0.4);
  EXPECT_EQ(m.rig.command("pid/j1/velocity"), 0);
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), -2 * 0.3, 1e-12) << "it only brakes";
  EXPECT_FALSE(m.controller->standing()) << "it still moves";
  m.controller->receive("reference", NamedValues{{"j1"}, {5}}, false);
  m.rig.state("arm/j1/velocity") = 0;
  m.rig.step();
  EXPECT_TRUE(m.controller->standing());
  EXPECT_EQ(m.rig.command("pid/j1/position"), 0.4) << "a stopped joint takes nothing";
  m.rig.verdict.speed = 1;
  m.rig.step();
  EXPECT_EQ(m.rig.command("pid/j1/position"), 0.4);
}

TEST(PidController, AVelocityIsBroughtToRestByAStop) {
  Made m = chainable();
  m.rig.set("reference_and_state_interfaces", {"velocity"});
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1"}, {2}}, false);
  m.rig.step();
  EXPECT_GT(m.rig.command("arm/j1/effort"), 0);
  m.rig.state("arm/j1/velocity") = 2;
  m.rig.verdict.speed = 0;
  m.rig.step();
  EXPECT_EQ(m.rig.command("pid/j1/velocity"), 0);
  EXPECT_FALSE(m.controller->standing());
  m.rig.state("arm/j1/velocity") = 0;
  m.rig.verdict.speed = 1;
  m.rig.step();
  EXPECT_TRUE(m.controller->standing());
  EXPECT_EQ(m.rig.command("pid/j1/velocity"), 0);
}

TEST(PidController, WithoutAMeasuredVelocityAPositionThatStaysIsStanding) {
  Made m = chainable();
  m.rig.set("reference_and_state_interfaces", {"position"});
  m.rig.start();
  EXPECT_TRUE(m.controller->standing());
  for (int k = 0; k < 10; ++k) {
    m.rig.state("arm/j1/position") += 0.001;
    m.rig.step();
    EXPECT_FALSE(m.controller->standing());
  }
  for (int k = 0; k < 11; ++k) m.rig.step();
  EXPECT_TRUE(m.controller->standing());
}

TEST(PidController, AJointMovedByAForceStandsWhileItIsStopped) {
  Made m("pid_controller/PidController");
  m.rig.set("dof_names", {"j1"});
  m.rig.set("command_interface", {"velocity"});
  m.rig.set("reference_and_state_interfaces", {"effort"});
  m.rig.set("gains.j1.i", {"1"});
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1"}, {2}}, false);
  m.rig.step();
  m.rig.step();
  EXPECT_GT(m.rig.command("arm/j1/velocity"), 0);
  m.rig.verdict.speed = 0;
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/velocity"), 0);
}

TEST(PidController, InactiveItPushesNothingAndItsReferencesAreGone) {
  Made m = chainable();
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1"}, {1}}, false);
  m.rig.step();
  m.controller->receive("reference", NamedValues{{"j1"}, {7}}, false);
  m.controller->on_deactivate(m.rig.cycle);
  EXPECT_EQ(m.rig.command("arm/j1/effort"), 0);
  EXPECT_TRUE(std::isnan(m.rig.command("pid/j1/position")));
  EXPECT_TRUE(std::isnan(m.rig.state("pid/j1/position")));
  EXPECT_TRUE(m.controller->standing());
  m.rig.state("arm/j1/position") = 0.6;
  m.controller->on_activate(m.rig.cycle);
  m.rig.step();
  EXPECT_EQ(m.rig.command("pid/j1/position"), 0.6) << "neither the 1 nor the 7";
}

TEST(PidController, WhenTheControllerBeforeItGoesNoVelocityRemains) {
  Made m = chainable();
  ASSERT_EQ(m.rig.configure(), CallbackReturn::success);
  m.controller->set_chained(true);
  m.controller->on_activate(m.rig.cycle);
  m.rig.command("pid/j1/position") = 0.3;
  m.rig.command("pid/j1/velocity") = 1.5;
  m.rig.step();
  m.controller->set_chained(false);
  m.rig.step();
  EXPECT_EQ(m.rig.command("pid/j1/position"), 0.3);
  EXPECT_EQ(m.rig.command("pid/j1/velocity"), 0);
}

Made from_outside() {
  Made m = chainable({"j1", "j2"});
  m.rig.set("use_external_measured_states", {"true"});
  return m;
}

TEST(PidController, MeasuredStatesOfSomeLeaveTheOthersAsTheyAre) {
  Made m = from_outside();
  m.rig.start();
  EXPECT_TRUE(m.controller->state_interfaces().empty());
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/effort"), 0) << "what is not measured is not pushed";
  m.controller->receive("measured_state", NamedValues{{"j1", "j2"}, {1, 2}}, false);
  m.controller->receive("measured_state", NamedValues{{"j2"}, {3}}, false);
  m.rig.step();
  EXPECT_EQ(m.rig.command("pid/j1/position"), 1) << "the first measured position is held";
  EXPECT_EQ(m.rig.command("pid/j2/position"), 3);
  m.controller->receive("measured_state", NamedValues{{"j2"}, {3.5}}, false);
  m.rig.step();
  EXPECT_EQ(m.rig.state("pid/j1/position"), 1);
  EXPECT_EQ(m.rig.state("pid/j2/position"), 3.5);
  EXPECT_NEAR(m.rig.command("arm/j1/effort"), 0, 1e-12);
  EXPECT_LT(m.rig.command("arm/j2/effort"), 0);
  m.controller->receive("measured_state", NamedValues{{"j1"}, {std::nan("")}}, false);
  m.rig.step();
  EXPECT_EQ(m.rig.command("arm/j1/effort"), 0) << "nobody measures it any more";
}

TEST(PidController, MessagesOfOneCycleAddUp) {
  Made m = chainable({"j1", "j2"});
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1"}, {1}}, false);
  m.controller->receive("reference", NamedValues{{"j2"}, {2}}, false);
  m.rig.step();
  EXPECT_EQ(m.rig.command("pid/j1/position"), 1);
  EXPECT_EQ(m.rig.command("pid/j2/position"), 2);
}

TEST(PidController, WithoutSaturationNoClampHoldsWhateverChanges) {
  Made m = chainable();
  m.rig.set("gains.j1.u_clamp_max", {"5"});
  m.rig.set("gains.j1.u_clamp_min", {"-5"});
  m.rig.set("gains.j1.saturation", {"false"});
  m.rig.start();
  m.controller->receive("reference", NamedValues{{"j1"}, {1}}, false);
  const auto effort = [&] { return m.rig.step(), m.rig.command("arm/j1/effort"); };
  EXPECT_NEAR(effort(), 10, 1e-12);
  change(m, "gains.j1.u_clamp_max", "3");
  EXPECT_NEAR(effort(), 10, 1e-12);
  change(m, "gains.j1.p", "20");
  EXPECT_NEAR(effort(), 20, 1e-12);
  change(m, "gains.j1.saturation", "true");
  EXPECT_NEAR(effort(), 3, 1e-12);
}

TEST(PidController, TellsWhatMultiDofStateHas) {
  Made m = chainable();
  m.rig.start();
  Output& told = *m.controller->find_output("controller_state");
  told.fetch();
  m.controller->receive("reference", NamedValues{{"j1", "j1/dot"}, {1, 0.25}}, false);
  m.rig.state("arm/j1/position") = 0.5;
  m.rig.state("arm/j1/velocity") = 0.05;
  m.rig.step();
  ASSERT_TRUE(told.fetch());
  EXPECT_EQ(told.fields(),
            (std::vector<std::string>{"j1.reference", "j1.feedback", "j1.feedback_dot", "j1.error",
                                      "j1.error_dot", "j1.time_step", "j1.output"}));
  const std::vector<double> wanted{1, 0.5, 0.05, 0.5, 0.2, 0.01, m.rig.command("arm/j1/effort")};
  for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_NEAR(told.value().values[k], wanted[k], 1e-12) << k;
}

TEST(PidController, WhatIsMissingIsSaidWithWhatToWrite) {
  Made m("pid_controller/PidController");
  try {
    m.rig.configure();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().size(), 2u);
    EXPECT_NE(std::string(e.what()).find("dof_names: [JOINT"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("command_interface: effort"), std::string::npos) << e.what();
  }
}

// --- grippers ---------------------------------------------------------------------------------------------

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

TEST(Gripper, AGoalBeyondTheLimitsIsJudgedByWhatIsCommanded) {
  Gripper g;
  g.rig.context.joints[0].upper = 0.3;
  g.rig.start();
  g.go(0.8);
  g.run(1);
  EXPECT_EQ(g.rig.command("arm/j1/position"), 0.3);
  ASSERT_EQ(g.events.size(), 2u);
  EXPECT_EQ(g.events[1].outcome, GoalOutcome::succeeded);
  EXPECT_LE(std::abs(g.events[1].error), g.events[1].tolerance);
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
  EXPECT_NE(g.controller->refuse_changes({g.rig.context.parameters.change("gains.j1.p", ".inf")}), "");
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
