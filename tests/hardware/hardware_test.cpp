#include "polyarm/hardware/hardware.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "tests/hardware/exchange_rig.hpp"

namespace polyarm::hardware {
namespace {

/// Echoes its one command; fails where it is told to.
class Echo : public Component {
 public:
  CallbackReturn on_init(const ComponentContext& context) override {
    name_ = context.name;
    return context.parameters.contains("refuse") ? CallbackReturn::failure : CallbackReturn::success;
  }
  CallbackReturn on_activate() override {
    ++active;
    return CallbackReturn::success;
  }
  CallbackReturn on_deactivate() override {
    --active;
    return CallbackReturn::success;
  }
  std::vector<InterfaceDescription> state_interfaces() const override {
    return {{name_ + "/j/position", 0.0}};
  }
  std::vector<InterfaceDescription> command_interfaces() const override { return {{name_ + "/j/position"}}; }
  ReturnType read(const Cycle&, std::span<double> states) noexcept override {
    states[0] = last_;
    return fail ? ReturnType::error : ReturnType::ok;
  }
  ReturnType write(const Cycle&, std::span<const double> commands) noexcept override {
    last_ = commands[0];
    return ReturnType::ok;
  }
  static inline int active = 0;
  static inline bool fail = false;

 private:
  std::string name_;
  double last_ = 0;
};

ComponentContext named(const std::string& name) {
  ComponentContext context;
  context.name = name;
  return context;
}

TEST(Hardware, GivesEachComponentItsOwnPlacesInTheTable) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Echo>(), named("left"));
  hardware.add(std::make_unique<Echo>(), named("right"));
  hardware.configure_and_activate();
  table.commands()[*table.find_command("right/j/position")] = 0.5;
  write(hardware);
  EXPECT_FALSE(read(hardware));
  EXPECT_EQ(table.states()[*table.find_state("right/j/position")], 0.5);
  EXPECT_TRUE(std::isnan(table.states()[*table.find_state("left/j/position")]));
}

/// Waits for a device, and knows nothing before it has asked it.
class Device : public Echo {
 public:
  std::vector<InterfaceDescription> state_interfaces() const override { return {{"device/j/position"}}; }
  ReturnType read(const Cycle&, std::span<double> states) noexcept override {
    states[0] = 7;
    return ReturnType::ok;
  }
  bool blocks() const noexcept override { return true; }
};

TEST(Hardware, WhatWaitsForADeviceHasMeasuredBeforeControllersBegin) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Device>(), named("device"));
  hardware.configure_and_activate();
  read(hardware);
  EXPECT_EQ(table.states()[0], 7);
}

/// A robot with a clock of its own.
class Pacer : public Echo {
 public:
  bool paces() const noexcept override { return true; }
  bool await_cycle(Nanoseconds timeout) noexcept override {
    asked = timeout;
    return ticks-- > 0;
  }
  static inline int ticks = 0;
  static inline Nanoseconds asked = 0;
};

TEST(Hardware, AnActiveComponentWithAClockPacesTheLoop) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Pacer>(), named("robot"));
  EXPECT_FALSE(hardware.exchange().await_cycle(1000).has_value())
      << "not active, the loop keeps its own time";
  hardware.configure_and_activate();
  Pacer::ticks = 1;
  EXPECT_EQ(hardware.exchange().await_cycle(2'000'000), std::optional<bool>(true));
  EXPECT_EQ(Pacer::asked, 2'000'000) << "never longer than it may";
  EXPECT_EQ(hardware.exchange().await_cycle(2'000'000), std::optional<bool>(false)) << "the robot is silent";
  hardware.begin_deactivate(0);
  EXPECT_FALSE(hardware.exchange().await_cycle(1000).has_value());
}

TEST(Hardware, ALoopHasOneClock) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Pacer>(), named("robot"));
  try {
    hardware.add(std::make_unique<Pacer>(), named("other"));
    FAIL() << "was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, "two-clocks");
  }
}

TEST(Hardware, NamesTheComponentThatFails) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Echo>(), named("left"));
  hardware.configure_and_activate();
  Echo::fail = true;
  const FaultEvent fault = read(hardware);
  Echo::fail = false;
  EXPECT_EQ(fault.cause, StopCause::component);
  EXPECT_EQ(hardware.component_name(static_cast<std::size_t>(fault.component)), "left");
}

/// Knows why it failed.
class Speaking : public Echo {
 public:
  std::string reason() const override { return fail ? "the bus is silent" : ""; }
};

/// Notes the order of callbacks; a sensor has no commands.
class Noting : public Component {
 public:
  static inline std::vector<std::string> calls;
  explicit Noting(bool sensor) : sensor_(sensor) {}
  CallbackReturn on_init(const ComponentContext& context) override {
    return name_ = context.name, CallbackReturn::success;
  }
  CallbackReturn on_configure() override { return note("configure"); }
  CallbackReturn on_activate() override { return note("activate"); }
  std::vector<InterfaceDescription> state_interfaces() const override {
    return {{name_ + "/j/position", 0.0}};
  }
  std::vector<InterfaceDescription> command_interfaces() const override {
    if (sensor_) return {};
    return {{name_ + "/j/position"}};
  }
  ReturnType read(const Cycle&, std::span<double>) noexcept override { return ReturnType::ok; }
  ReturnType write(const Cycle&, std::span<const double>) noexcept override { return ReturnType::ok; }

 private:
  CallbackReturn note(const char* call) {
    return calls.push_back(std::string(call) + " " + name_), CallbackReturn::success;
  }
  bool sensor_;
  std::string name_;
};

TEST(Hardware, ConfiguresAndActivatesSensorsBeforeWhatMoves) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Noting>(false), named("motor"));
  hardware.add(std::make_unique<Noting>(false), named("drive"));
  hardware.add(std::make_unique<Noting>(true), named("scale"));
  hardware.configure_and_activate();
  EXPECT_EQ(Noting::calls, (std::vector<std::string>{"configure scale", "configure motor", "configure drive",
                                                     "activate scale", "activate motor", "activate drive"}));
}

/// Each of its callbacks fails for a reason of its own.
class Unplugged : public Echo {
 public:
  CallbackReturn on_configure() override { return reason_ = "no cable", CallbackReturn::error; }
  CallbackReturn on_error() override { return reason_ = "on_error fails", CallbackReturn::failure; }
  std::string reason() const override { return reason_; }

 private:
  std::string reason_;
};

TEST(Hardware, SaysWhyTheFirstCallbackFailedNotItsOnError) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Unplugged>(), named("arm"));
  try {
    hardware.configure_and_activate();
    FAIL() << "was configured";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("could not be configured and is finalized: no cable"),
              std::string::npos)
        << e.what();
  }
}

TEST(Hardware, SaysWhyItFailedWhileItIsFreedFromItsError) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Speaking>(), named("arm"));
  hardware.configure_and_activate();
  Echo::fail = true;
  EXPECT_TRUE(read(hardware));
  const auto freeing = hardware.begin(0, Step::error);
  Echo::fail = false;  // its thread may change what it would say now
  ASSERT_TRUE(hardware.pending(0));
  EXPECT_EQ(hardware.diagnostics().own_reason(0), "the bus is silent");
  EXPECT_EQ(hardware.diagnostics().reason(0), "the bus is silent");
  freeing->run();
  hardware.finish(*freeing);
  EXPECT_EQ(hardware.diagnostics().own_reason(0), "");
}

TEST(Hardware, DeactivatesOnEveryWayOut) {
  Echo::active = 0;
  {
    InterfaceTable table;
    realtime::Jobs jobs;
    Hardware hardware(table, jobs);
    hardware.add(std::make_unique<Echo>(), named("left"));
    hardware.configure_and_activate();
    EXPECT_EQ(Echo::active, 1);
  }
  EXPECT_EQ(Echo::active, 0);
}

TEST(Hardware, ForcesAFaultOverWhatControllersSay) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Echo>(), named("arm"));
  hardware.configure_and_activate();
  hardware.force("arm/j/position", 0.25);
  table.commands()[0] = 1;
  write(hardware);
  read(hardware);
  EXPECT_EQ(table.commands()[0], 0.25);
  EXPECT_EQ(table.states()[0], 0.25);
  EXPECT_THROW(hardware.force("arm/k/position", 0), Error);
}

/// Notes every command it is given.
class Waiting : public Component {
 public:
  CallbackReturn on_init(const ComponentContext&) override { return CallbackReturn::success; }
  std::vector<InterfaceDescription> state_interfaces() const override { return {{"w/j/velocity", 0.0}}; }
  std::vector<InterfaceDescription> command_interfaces() const override { return {{"w/j/velocity"}}; }
  ReturnType read(const Cycle&, std::span<double>) noexcept override { return ReturnType::ok; }
  ReturnType write(const Cycle&, std::span<const double> commands) noexcept override {
    told.push_back(commands[0]);
    return std::exchange(fail, false) ? ReturnType::error : ReturnType::ok;
  }
  bool blocks() const noexcept override { return true; }
  static inline std::vector<double> told;
  static inline bool fail = false;
};

class WaitingTest : public ::testing::Test {
 protected:
  WaitingTest() {
    Waiting::told.clear();
    HostOptions options;
    options.lock_step = true;
    hardware.add(std::make_unique<Waiting>(), named("w"), options);
    hardware.configure_and_activate();
    cycle();
    table.commands()[0] = 0.5;
    cycle();
  }
  FaultEvent cycle() {
    const FaultEvent fault = read(hardware);
    write(hardware);
    return fault;
  }
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware{table, jobs};
};

TEST_F(WaitingTest, AComponentWithAThreadIsNotToldOldCommandsWhenItIsInactive) {
  ASSERT_EQ(Waiting::told.back(), 0.5);
  hardware.begin_deactivate(0);
  cycle();
  hardware.run(0, Step::deactivate);
  cycle();
  EXPECT_TRUE(std::isnan(Waiting::told.back())) << Waiting::told.back();
}

TEST_F(WaitingTest, AComponentWithAThreadFailsOnceAndCanBeUsedAgain) {
  Waiting::fail = true;
  cycle();
  EXPECT_TRUE(cycle()) << "the failure of the cycle before";
  hardware.run(0, Step::error);
  hardware.run(0, Step::configure);
  hardware.run(0, Step::activate);
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(cycle()) << k;
  EXPECT_EQ(hardware.state_of(0), LifecycleState::active);
}

TEST(Hardware, RefusesTwoInterfacesOfOneName) {
  InterfaceTable table;
  realtime::Jobs jobs;
  Hardware hardware(table, jobs);
  hardware.add(std::make_unique<Echo>(), named("arm"));
  EXPECT_THROW(hardware.add(std::make_unique<Echo>(), named("arm")), Error);
}

TEST(Drivers, UnknownNamesGetTheNearestKnownOne) {
  register_driver("echo", [] { return std::unique_ptr<Component>(new Echo); });
  EXPECT_NE(make_driver("echo"), nullptr);
  try {
    make_driver("ecko");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("did you mean 'echo'"), std::string::npos);
  }
}

}  // namespace
}  // namespace polyarm::hardware
