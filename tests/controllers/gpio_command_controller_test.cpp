#include "polyarm/broadcasters/gpio_command_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "polyarm/plugins/types.hpp"
#include "tests/controllers/rig.hpp"
#include "tests/support/realtime_guard.hpp"

namespace polyarm::controllers {
namespace {

/// Two gpios as the usual example has them: digital lines and an analog one.
struct Gpio {
  GpioCommandController gpio;
  Rig rig;
  explicit Gpio(const Rig::Values& values = usual())
      : rig(gpio, "arm", {"elbow"}, {"gpio1/dig.1", "gpio1/dig.2", "gpio2/ana.1"},
            {"gpio1/dig.1", "gpio1/dig.2", "gpio2/ana.1"}, values) {}
  static Rig::Values usual() {
    return {{"gpios", {"gpio1", "gpio2"}},
            {"command_interfaces.gpio1.interfaces", {"dig.1", "dig.2"}},
            {"command_interfaces.gpio2.interfaces", {"ana.1"}},
            {"state_interfaces.gpio1.interfaces", {"dig.2"}},
            {"state_interfaces.gpio2.interfaces", {"ana.1"}}};
  }
  void send(std::vector<std::string> names, std::vector<double> values) {
    gpio.receive("commands", NamedValues{std::move(names), std::move(values)}, false);
  }
};

TEST(GpioController, IsFoundUnderItsName) {
  Parameters parameters;
  EXPECT_TRUE(make_controller("gpio_controllers/GpioCommandController", parameters));
}

TEST(GpioController, CommandsByName) {
  Gpio g;
  g.rig.start();
  g.send({"gpio2/ana.1", "gpio1/dig.1"}, {2.5, 1});
  g.rig.step();
  EXPECT_EQ(g.rig.command("gpio1/dig.1"), 1);
  EXPECT_EQ(g.rig.command("gpio2/ana.1"), 2.5);
  EXPECT_TRUE(std::isnan(g.rig.command("gpio1/dig.2")));
}

TEST(GpioController, CommandsNothingUntilSomethingIsSent) {
  Gpio g;
  g.rig.start();
  g.rig.command("gpio1/dig.1") = 1;  // from before
  g.rig.steps(3);
  EXPECT_EQ(g.rig.command("gpio1/dig.1"), 1);
  EXPECT_TRUE(std::isnan(g.rig.command("gpio2/ana.1")));
}

TEST(GpioController, KeepsEveryValueOfMessagesInOneCycle) {
  Gpio g;
  g.rig.start();
  g.send({"gpio1/dig.1"}, {1});
  g.send({"gpio1/dig.2"}, {1});
  g.send({"gpio1/dig.1"}, {std::nan("")});
  g.rig.step();
  EXPECT_EQ(g.rig.command("gpio1/dig.1"), 1);
  EXPECT_EQ(g.rig.command("gpio1/dig.2"), 1);
}

TEST(GpioController, ForgetsWhatWasSentBeforeItBecameActiveAgain) {
  Gpio g;
  g.rig.start();
  g.send({"gpio1/dig.1"}, {1});
  g.rig.step();
  g.gpio.on_deactivate(g.rig.cycle);
  g.send({"gpio1/dig.2"}, {1});
  g.rig.activate();
  g.rig.command("gpio1/dig.1") = 0;
  g.rig.step();
  EXPECT_TRUE(std::isnan(g.rig.command("gpio1/dig.2")));
  g.send({"gpio2/ana.1"}, {3});
  g.rig.step();
  EXPECT_EQ(g.rig.command("gpio1/dig.1"), 0);
  EXPECT_EQ(g.rig.command("gpio2/ana.1"), 3);
}

TEST(GpioController, WhatNobodyRepeatsBecomesZeroWhereATimeoutIsStated) {
  Rig::Values values = Gpio::usual();
  values["command_timeout"] = {"0.1"};
  Gpio g(values);
  g.rig.start();
  g.send({"gpio1/dig.1", "gpio2/ana.1"}, {1, 2.5});
  g.rig.steps(2000);
  EXPECT_EQ(g.rig.command("gpio1/dig.1"), 0);
  EXPECT_EQ(g.rig.command("gpio2/ana.1"), 0);
  EXPECT_TRUE(std::isnan(g.rig.command("gpio1/dig.2"))) << "nobody ever commanded it";
  EXPECT_TRUE(g.gpio.command_watch().stale());
  g.send({"gpio2/ana.1"}, {3});
  g.rig.step();
  EXPECT_EQ(g.rig.command("gpio2/ana.1"), 3);
  EXPECT_EQ(g.rig.command("gpio1/dig.1"), 0) << "what has ended does not come back with another";
}

TEST(GpioController, TellsItsStates) {
  Gpio g;
  g.rig.start();
  g.rig.state("gpio1/dig.2") = 1;
  g.rig.state("gpio2/ana.1") = 4.5;
  g.rig.step();
  EXPECT_EQ(g.rig.told("gpio_states", "gpio1/dig.2"), 1);
  EXPECT_EQ(g.rig.told("gpio_states", "gpio2/ana.1"), 4.5);
  EXPECT_EQ(g.gpio.find_output("gpio_states")->fields().size(), 2u);
  EXPECT_EQ(g.gpio.find_output("gpio_states")->type(), "control_msgs/DynamicJointState");
}

TEST(GpioController, TellsEveryStateOfItsGpiosWhereNoneIsNamed) {
  Gpio g(Rig::Values{{"gpios", {"gpio1"}}, {"command_interfaces.gpio1.interfaces", {"dig.1"}}});
  g.rig.start();
  EXPECT_EQ(g.gpio.find_output("gpio_states")->fields(),
            (std::vector<std::string>{"gpio1/dig.1", "gpio1/dig.2"}));
}

TEST(GpioController, OnlyTellsWithoutCommands) {
  Gpio g(Rig::Values{{"gpios", {"gpio2"}}});
  g.rig.start();
  EXPECT_TRUE(g.gpio.inputs().empty());
  EXPECT_TRUE(g.gpio.command_interfaces().empty());
  EXPECT_THROW(g.send({}, {}), Error);
}

TEST(GpioController, LeavesOutputsAsTheyAreOnAStop) {
  Gpio g;
  g.rig.start();
  g.send({"gpio1/dig.1"}, {1});
  g.rig.step();
  g.rig.verdict = {0, true, true};
  g.rig.step();
  EXPECT_EQ(g.rig.command("gpio1/dig.1"), 1);
  EXPECT_TRUE(g.gpio.standing());
}

TEST(GpioController, RefusesAWrongMessageWhole) {
  Gpio g;
  g.rig.start();
  EXPECT_THROW(g.send({"gpio1/dig.1", "gpio1/dag.2"}, {1, 1}), Error);
  EXPECT_THROW(g.send({"gpio1/dig.1", "gpio1/dig.2"}, {1, HUGE_VAL}), Error);
  EXPECT_THROW(g.send({"gpio1/dig.1", "gpio1/dig.2"}, {1}), Error);
  EXPECT_THROW(g.gpio.receive("commands", Numbers{{1}}, false), Error);
  g.rig.step();
  EXPECT_TRUE(std::isnan(g.rig.command("gpio1/dig.1")));
  try {
    g.send({"gpio1/dag.2"}, {1});
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'gpio1/dig.2'"), std::string::npos) << e.what();
  }
}

TEST(GpioController, RefusesWhatItCannotCommand) {
  const std::pair<Rig::Values, const char*> kWrong[] = {
      {{{"gpios", {}}}, "it names no gpios"},
      {{{"gpios", {"gpio1", "gpio1"}}}, "'gpio1' is named twice"},
      {{{"gpios", {"gpio1"}}, {"command_interfaces.gpio1.interfaces", {"dig.1", "dig.1"}}},
       "'gpio1/dig.1' is named twice"},
      {{{"gpios", {"gpio1"}}, {"command_interfaces.gpio1.interfaces", {"dig.9"}}},
       "no command 'gpio1/dig.9'"},
      {{{"gpios", {"gpio1"}}, {"state_interfaces.gpio1.interfaces", {"dog.1"}}}, "no state 'gpio1/dog.1'"},
      {{{"gpios", {"gpio7"}}}, "nothing to command and nothing to publish"},
  };
  for (const auto& [values, sentence] : kWrong) {
    Gpio g(values);
    const std::string why = g.rig.refusal();
    EXPECT_NE(why.find(sentence), std::string::npos) << why;
    EXPECT_NE(why.find("controllers.yaml:1"), std::string::npos) << why;
  }
}

TEST(GpioController, PassesOverInterfacesOfWhatIsNotAmongGpios) {
  Rig::Values values = Gpio::usual();
  values["command_interfaces.gpio3.interfaces"] = {"dig.1"};
  Gpio g(values);
  g.rig.start();
  EXPECT_NE(g.rig.findings().find("'gpio3' is not among gpios"), std::string::npos);
  EXPECT_EQ(g.rig.findings().find("has no parameter"), std::string::npos);
}

TEST(GpioController, DoesNothingThatWaits) {
  if (!test::RealtimeGuard::watches()) GTEST_SKIP() << "sanitizers bring their own allocator";
  Gpio g;
  g.rig.start();
  for (int k = 0; k < 100; ++k) {
    g.send({"gpio1/dig.1", "gpio2/ana.1"}, {1, 0.1 * k});
    test::RealtimeGuard guard;
    for (int i = 0; i < 100; ++i) g.gpio.update(g.rig.cycle, g.rig.verdict);
    g.gpio.on_activate(g.rig.cycle);
    ASSERT_EQ(guard.violations(), "");
  }
}

}  // namespace
}  // namespace polyarm::controllers
