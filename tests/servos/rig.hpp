#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/dynamixel/dynamixel.hpp"
#include "drivers/feetech/feetech.hpp"
#include "drivers/servo_bus/fake_bus.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::test {

using hardware::CallbackReturn;
using hardware::ReturnType;
using servo_bus::FakeBus;
using servo_bus::Mischief;
using servo_bus::Wire;

constexpr double kStep = 2 * std::numbers::pi / 4096;

/// Joints a, b, c (servos 1, 2, 3) on a fake bus, and the component that drives them.
class ServoRig {
 public:
  static const servo_bus::Family& family_of(Wire wire) {
    return wire == Wire::feetech ? feetech::sts_family() : dynamixel::x_family();
  }
  explicit ServoRig(Wire wire, const std::string& command = "position")
      : family(family_of(wire)), fake(wire, {1, 2, 3}), wire_(wire) {
    hardware::RobotInstance robot;
    robot.name = "arm";
    description::HardwareInfo info;
    info.name = "bus";
    info.type = "system";
    for (const char* name : {"a", "b", "c"}) {
      description::ComponentInfo joint;
      joint.name = name;
      joint.kind = "joint";
      joint.parameters["id"] = std::to_string(name[0] - 'a' + 1);
      joint.command_interfaces.push_back({command});
      for (const char* state : {"position", "velocity", "effort", "current", "temperature", "voltage"})
        joint.state_interfaces.push_back({state});
      info.components.push_back(joint);
    }
    robot.hardware.push_back(info);
    context.name = "bus";
    context.robots.push_back(robot);
    context.period = 10'000'000;
    context.parameters = {{"port", fake.path()}, {"answer_timeout_ms", "2000"}, {"bus_watchdog_ms", "0"}};
    cycle.period = context.period;
    make();
  }
  /// A component that has been told the parameters as they stand now.
  void make() {
    component.reset();
    if (wire_ == Wire::feetech)
      component = std::make_unique<feetech::FeetechComponent>();
    else
      component = std::make_unique<dynamixel::DynamixelComponent>();
    ASSERT_EQ(component->on_init(context), CallbackReturn::success);
    states.assign(component->state_interfaces().size(), 0);
    commands.assign(component->command_interfaces().size(), std::nan(""));
  }
  void set(const std::string& parameter, const std::string& value) {
    context.parameters[parameter] = value;
    make();
  }
  ::testing::AssertionResult start() {
    if (component->on_configure() != CallbackReturn::success)
      return ::testing::AssertionFailure() << "configure: " << component->reason();
    if (component->on_activate() != CallbackReturn::success)
      return ::testing::AssertionFailure() << "activate: " << component->reason();
    return ::testing::AssertionSuccess();
  }
  ReturnType step() {
    const ReturnType read = component->read(cycle, states);
    const ReturnType written = read == ReturnType::ok ? component->write(cycle, commands) : read;
    ++cycle.index;
    return written;
  }
  /// Steps until the component fails; how many it took, 0 if it did not in `most`.
  int steps_until_error(int most = 50) {
    for (int k = 1; k <= most; ++k)
      if (step() != ReturnType::ok) return k;
    return 0;
  }
  double state(std::size_t joint, std::size_t quantity) const { return states[joint * 6 + quantity]; }
  bool says(const std::string& text) const { return component->reason().find(text) != std::string::npos; }

  const servo_bus::Family& family;
  FakeBus fake;
  hardware::ComponentContext context;
  std::unique_ptr<servo_bus::ServoComponent> component;
  hardware::Cycle cycle;
  std::vector<double> states, commands;

 private:
  Wire wire_;
};

class BothWires : public ::testing::TestWithParam<Wire> {};

}  // namespace polyarm::test
