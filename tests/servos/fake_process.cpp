/// A driver of two servos in a process of its own: FAMILY PORT COMMAND [PARAMETER=VALUE …]; it does as it is
/// told on standard input.
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/dynamixel/dynamixel.hpp"
#include "drivers/feetech/feetech.hpp"

namespace polyarm::test {
namespace {

using hardware::CallbackReturn;
using hardware::ReturnType;

int tell(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
  return 1;
}

bool start(hardware::Component& component) {
  if (component.on_configure() == CallbackReturn::success &&
      component.on_activate() == CallbackReturn::success)
    return tell("driving") != 0;
  tell("refused: " + component.reason());
  return false;
}

/// A line, if there is one within a period of the loop; the pace of the loop is the wait.
std::string heard() {
  pollfd waiting{STDIN_FILENO, POLLIN, 0};
  if (poll(&waiting, 1, 10) <= 0) return {};
  char buffer[64];
  const ssize_t n = ::read(STDIN_FILENO, buffer, sizeof buffer - 1);
  if (n <= 0) std::_Exit(9);  // the test is gone
  return {buffer, static_cast<std::size_t>(n)};
}

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
  if (!start(component)) return 1;
  const double commands[] = {command, command};
  double states[2];
  bool failed = false;
  for (hardware::Cycle cycle{0, 10'000'000, 0};; ++cycle.index) {
    const std::string word = heard();
    if (word == "return\n") return 0;
    if (word == "exit\n") std::exit(0);  // without the destructor
    if (word == "abort\n") std::abort();
    if (word == "throw\n") throw std::runtime_error("nobody catches this");
    if (word == "spin\n")
      for (volatile bool for_ever = true; for_ever;) {
      }
    if (word == "activate\n") failed = !start(component);
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
