/// A driver of two servos in a process of its own: FAMILY PORT COMMAND [PARAMETER=VALUE …]; it does as it is
/// told on standard input.
#include <memory>
#include <string>

#include "drivers/dynamixel/dynamixel.hpp"
#include "drivers/feetech/feetech.hpp"
#include "tests/support/told_driver.hpp"

namespace polyarm::test {
namespace {

using hardware::ReturnType;

hardware::ComponentContext two_joints(int argc, char** argv) {
  hardware::ComponentContext out;
  out.name = "bus";
  out.period = 10'000'000;
  out.parameters = {{"port", argv[2]}, {"answer_timeout_ms", "500"}};
  for (int k = 4; k < argc; ++k) {
    const std::string word = argv[k];
    out.parameters[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
  }
  hardware::RobotInstance robot;
  robot.name = "arm";
  description::HardwareInfo block;
  for (const char* id : {"1", "2"}) {
    description::ComponentInfo joint;
    joint.name = std::string("joint") + id;
    joint.kind = "joint";
    joint.parameters["id"] = id;
    joint.command_interfaces.push_back({argv[3]});
    joint.state_interfaces.push_back({"position"});
    block.components.push_back(joint);
  }
  robot.hardware.push_back(block);
  out.robots.push_back(robot);
  return out;
}

int drive(hardware::Component& component, double command) {
  if (!start(component, "driving")) return 1;
  const double commands[] = {command, command};
  double states[2];
  bool failed = false;
  for (hardware::Cycle cycle{0, 10'000'000, 0};; ++cycle.index) {
    const std::string word = heard(10);
    if (is_to_return(word)) return 0;
    if (word == "activate") failed = !start(component, "driving");
    if (failed) continue;
    failed =
        component.read(cycle, states) != ReturnType::ok || component.write(cycle, commands) != ReturnType::ok;
    if (!failed) continue;
    const std::string reason = component.reason();
    component.on_error();
    tell("error: " + reason);
  }
}
}  // namespace
}  // namespace polyarm::test

int main(int argc, char** argv) {
  using namespace polyarm;
  if (argc < 4) return 2;
  std::unique_ptr<servo_bus::ServoComponent> component;
  if (std::string(argv[1]) == "feetech")
    component = std::make_unique<feetech::FeetechComponent>();
  else
    component = std::make_unique<dynamixel::DynamixelComponent>();
  component->on_init(test::two_joints(argc, argv));
  return test::drive(*component, 0.5);
}
