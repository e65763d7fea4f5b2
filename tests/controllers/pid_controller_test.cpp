#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/controllers/made_controller.hpp"

namespace polyarm::controllers {
namespace {

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

}  // namespace
}  // namespace polyarm::controllers
