#include "polyarm/hardware/transmitted_component.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "polyarm/base/error.hpp"
#include "polyarm/description/urdf.hpp"

namespace polyarm::hardware {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Motors that stand where they are commanded, and remember what they were told.
class Motors : public Component {
 public:
  CallbackReturn on_init(const ComponentContext& context) override {
    for (const RobotInstance& robot : context.robots)
      for (const description::HardwareInfo& block : robot.hardware)
        for (const description::ComponentInfo& c : block.components) {
          for (const auto& i : c.state_interfaces)
            states_.push_back({robot.name + "/" + c.name + "/" + i.name, i.initial_value.value_or(0)});
          for (const auto& i : c.command_interfaces)
            commands_.push_back({robot.name + "/" + c.name + "/" + i.name});
        }
    measured.assign(states_.size(), 0);
    for (std::size_t i = 0; i < states_.size(); ++i) measured[i] = states_[i].initial;
    commanded.assign(commands_.size(), kNone);
    return CallbackReturn::success;
  }
  std::vector<InterfaceDescription> state_interfaces() const override { return states_; }
  std::vector<InterfaceDescription> command_interfaces() const override { return commands_; }
  ReturnType read(const Cycle&, std::span<double> states) noexcept override {
    std::copy(measured.begin(), measured.end(), states.begin());
    return ReturnType::ok;
  }
  ReturnType write(const Cycle&, std::span<const double> commands) noexcept override {
    commanded.assign(commands.begin(), commands.end());
    return ReturnType::ok;
  }
  ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                         std::span<const std::string>) override {
    starting.assign(start.begin(), start.end());
    return ReturnType::ok;
  }
  bool paces() const noexcept override { return true; }
  bool await_cycle(Nanoseconds timeout) noexcept override { return timeout == 7; }
  double& state(const std::string& name) { return measured[index(states_, name)]; }
  double& command(const std::string& name) { return commanded[index(commands_, name)]; }
  static std::size_t index(const std::vector<InterfaceDescription>& in, const std::string& name) {
    for (std::size_t i = 0; i < in.size(); ++i)
      if (in[i].name == name) return i;
    throw std::out_of_range("no " + name);
  }
  std::vector<double> measured, commanded;
  std::vector<std::string> starting;

 private:
  std::vector<InterfaceDescription> states_, commands_;
};

std::string joint(const std::string& name, const std::string& interfaces) {
  return "<joint name='" + name + "'>" + interfaces + "</joint>";
}
std::string state(const std::string& name, const std::string& initial = "") {
  return "<state_interface name='" + name + "'>" +
         (initial.empty() ? "" : "<param name='initial_value'>" + initial + "</param>") +
         "</state_interface>";
}
std::string command(const std::string& name) {
  return "<command_interface name='" + name + "'/>";
}

/// Two joints, a and b, and what the block says of them.
struct Robot {
  explicit Robot(const std::string& block, std::vector<double> start = {0, 0}) {
    Problems warnings;
    model = description::read_urdf(
        "<robot name='r'><link name='l0'/><link name='l1'/><link name='l2'/>"
        "<joint name='a' type='continuous'><parent link='l0'/><child link='l1'/></joint>"
        "<joint name='b' type='continuous'><parent link='l1'/><child link='l2'/></joint>"
        "<ros2_control name='h' type='system'><hardware><plugin>p</plugin></hardware>" +
            block + "</ros2_control></robot>",
        "r.urdf", warnings);
    context.name = "h";
    context.robots = {{"arm", &model, nullptr, {}, std::move(start), model.hardware}};
    auto made = std::make_unique<Motors>();
    motors = made.get();
    component = through_transmissions(std::move(made), context);
    if (component->on_init(context) != CallbackReturn::success) throw std::runtime_error("refused");
    states.assign(component->state_interfaces().size(), kNone);
    commands.assign(component->command_interfaces().size(), kNone);
  }
  double measured(const std::string& name) {
    component->read({}, states);
    return states[Motors::index(component->state_interfaces(), name)];
  }
  void commanded(const std::string& name, double value) {
    commands[Motors::index(component->command_interfaces(), name)] = value;
    component->read({}, states);
    component->write({}, commands);
  }
  description::RobotModel model;
  ComponentContext context;
  Motors* motors = nullptr;
  std::unique_ptr<Component> component;
  std::vector<double> states, commands;
};

const std::string kSimple =
    "<transmission name='t'><plugin>transmission_interface/SimpleTransmission</plugin>"
    "<actuator name='m' role='actuator1'/><joint name='a' role='joint1'>"
    "<mechanical_reduction>10</mechanical_reduction><offset>1</offset></joint></transmission>";

const std::string kDifferential =
    "<transmission name='d'><plugin>transmission_interface/DifferentialTransmission</plugin>"
    "<actuator name='m1' role='actuator1'><mechanical_reduction>50</mechanical_reduction></actuator>"
    "<actuator name='m2' role='actuator2'><mechanical_reduction>-50</mechanical_reduction></actuator>"
    "<joint name='a' role='joint1'><mechanical_reduction>2</mechanical_reduction><offset>0.5</offset></joint>"
    "<joint name='b' "
    "role='joint2'><mechanical_reduction>2</mechanical_reduction><offset>-0.5</offset></joint>"
    "</transmission>";

const std::string kAll = command("position") + command("velocity") + command("effort") + state("position") +
                         state("velocity") + state("effort");

TEST(TransmittedComponent, AComponentWithoutTransmissionsIsLeftAlone) {
  Robot robot(joint("a", kAll));
  EXPECT_EQ(robot.component.get(), robot.motors);
}

TEST(TransmittedComponent, TheDevicesClockStillPacesTheLoop) {
  Robot robot(joint("a", kAll) + joint("b", kAll) + kSimple);
  EXPECT_TRUE(robot.component->paces());
  EXPECT_TRUE(robot.component->await_cycle(7));
  EXPECT_FALSE(robot.component->await_cycle(8));
}

TEST(TransmittedComponent, JointsGoThroughAReductionOfTenWithAnOffset) {
  Robot robot(joint("a", kAll) + joint("b", kAll) + kSimple);
  robot.motors->state("arm/m/position") = 1;
  robot.motors->state("arm/m/velocity") = 1;
  robot.motors->state("arm/m/effort") = 1;
  EXPECT_DOUBLE_EQ(robot.measured("arm/a/position"), 1.1);
  EXPECT_DOUBLE_EQ(robot.measured("arm/a/velocity"), 0.1);
  EXPECT_DOUBLE_EQ(robot.measured("arm/a/effort"), 10);
  robot.commanded("arm/a/position", 1.1);
  EXPECT_NEAR(robot.motors->command("arm/m/position"), 1, 1e-12);
  EXPECT_TRUE(std::isnan(robot.motors->command("arm/m/velocity")));
}

TEST(TransmittedComponent, WhatNoTransmissionDrivesPassesAsItIs) {
  Robot robot(joint("a", kAll + state("temperature")) + joint("b", kAll) + kSimple);
  robot.motors->state("arm/b/position") = 0.25;
  robot.motors->state("arm/m/temperature") = 40;
  EXPECT_EQ(robot.measured("arm/b/position"), 0.25);
  EXPECT_EQ(robot.measured("arm/a/temperature"), 40);
  robot.commanded("arm/b/velocity", 3);
  EXPECT_EQ(robot.motors->command("arm/b/velocity"), 3);
}

TEST(TransmittedComponent, ADifferentialIsUndoneByItself) {
  Robot robot(joint("a", kAll) + joint("b", kAll) + kDifferential);
  robot.commanded("arm/a/position", 0.7);
  robot.commanded("arm/b/position", -0.2);
  robot.motors->state("arm/m1/position") = robot.motors->command("arm/m1/position");
  robot.motors->state("arm/m2/position") = robot.motors->command("arm/m2/position");
  EXPECT_NEAR(robot.measured("arm/a/position"), 0.7, 1e-12);
  EXPECT_NEAR(robot.measured("arm/b/position"), -0.2, 1e-12);
}

TEST(TransmittedComponent, OneJointOfAPairMovesWhileTheOtherHolds) {
  Robot robot(joint("a", kAll) + joint("b", kAll) + kDifferential, {0.3, -0.4});
  robot.commanded("arm/a/position", 0.35);
  robot.motors->state("arm/m1/position") = robot.motors->command("arm/m1/position");
  robot.motors->state("arm/m2/position") = robot.motors->command("arm/m2/position");
  EXPECT_NEAR(robot.measured("arm/a/position"), 0.35, 1e-12);
  EXPECT_NEAR(robot.measured("arm/b/position"), -0.4, 1e-12);
  robot.commanded("arm/b/effort", 5);
  EXPECT_TRUE(std::isfinite(robot.motors->command("arm/m1/effort")));
}

TEST(TransmittedComponent, StartsWhereTheJointsStart) {
  Robot robot(joint("a", kAll) + joint("b", kAll) + kSimple, {0.2, 0.6});
  EXPECT_NEAR(robot.motors->state("arm/m/position"), (0.2 - 1) * 10, 1e-12);
  EXPECT_NEAR(robot.measured("arm/a/position"), 0.2, 1e-12);
  Robot stated(joint("a", command("position") + state("position", "0.9")) + kSimple, {0.2, 0.6});
  EXPECT_NEAR(stated.measured("arm/a/position"), 0.9, 1e-12);
}

TEST(TransmittedComponent, ASwitchOfOneJointReachesBothActuators) {
  Robot robot(joint("a", kAll) + joint("b", kAll) + kDifferential);
  const std::vector<std::string> start{"arm/a/velocity"};
  EXPECT_EQ(robot.component->prepare_command_mode_switch(start, {}), ReturnType::ok);
  EXPECT_EQ(robot.motors->starting, (std::vector<std::string>{"arm/m1/velocity", "arm/m2/velocity"}));
}

TEST(TransmittedComponent, APairThatIsCommandedByHalvesIsRefused) {
  try {
    Robot robot(joint("a", kAll) + joint("b", state("position")) + kDifferential);
    FAIL() << "was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().at(0).code, "bad-transmission");
    EXPECT_NE(std::string(e.what()).find("'b'"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace polyarm::hardware
