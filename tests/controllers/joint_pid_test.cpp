#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/controllers/made_controller.hpp"

namespace polyarm::controllers {
namespace {

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
  m.rig.context.joints.edit()[0].continuous = true;
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
  EXPECT_THROW(p.change("pid.i", ".inf"), Error);
  EXPECT_THROW(p.change("pid.p", ".nan"), Error);
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
  m.rig.context.joints.edit()[0].continuous = true;
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

}  // namespace
}  // namespace polyarm::controllers
