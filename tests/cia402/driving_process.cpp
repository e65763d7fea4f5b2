/// A driver of two drives in a process of its own: BUS [PARAMETER=VALUE …]; it reads orders from standard
/// input. Both joints turn slowly.
#include <cmath>
#include <string>

#include "drivers/cia402/component.hpp"
#include "tests/support/told_driver.hpp"

namespace polyarm::test {
namespace {

using hardware::ReturnType;
constexpr Nanoseconds kPeriod = 10'000'000;
constexpr double kEachCycle = 0.002;  // rad

hardware::ComponentContext two_drives(int argc, char** argv) {
  hardware::ComponentContext out;
  out.name = "arm";
  out.period = kPeriod;
  // Times for a machine that does much else.
  out.parameters = {{"bus", argv[1]},         {"pace", "false"},       {"loop_silence_ms", "10000"},
                    {"heartbeat_ms", "1000"}, {"watchdog_ms", "1000"}, {"lost_cycles", "500"},
                    {"start_timeout", "60"},  {"answer_ms", "5000"}};
  for (int k = 2; k < argc; ++k) {
    const std::string word = argv[k];
    out.parameters[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
  }
  hardware::RobotInstance robot;
  robot.name = "arm";
  description::HardwareInfo block;
  for (const char* node : {"1", "2"}) {
    description::ComponentInfo joint;
    joint.name = std::string("joint") + node;
    joint.kind = "joint";
    joint.parameters = {{"node", node}, {"counts_per_turn", "4096"}, {"gear", "100"}};
    joint.command_interfaces.push_back({"position"});
    block.components.push_back(joint);
  }
  robot.hardware.push_back(block);
  out.robots.push_back(robot);
  return out;
}

int drive(cia402::Cia402Component& component) {
  if (!start(component, "driving")) return 1;
  std::vector<double> states(component.state_interfaces().size()), commands(2, std::nan(""));
  hardware::Cycle cycle{0, kPeriod, 0};
  bool failed = false;
  for (;; ++cycle.index) {
    const std::string word = heard(10);
    if (is_to_return(word)) return 0;
    if (word == "activate") {
      failed = !start(component, "driving");
      commands.assign(2, std::nan(""));
    }
    if (failed) continue;
    failed = component.read(cycle, states) != ReturnType::ok;
    for (std::size_t j = 0; j < 2; ++j)
      commands[j] = std::isfinite(commands[j]) ? commands[j] + kEachCycle : states[3 * j];
    failed = failed || component.write(cycle, commands) != ReturnType::ok;
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
  if (argc < 2) return 2;
  cia402::Cia402Component component;
  component.on_init(test::two_drives(argc, argv));
  return test::drive(component);
}
