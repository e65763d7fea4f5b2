#pragma once
/// A base with two wheels on the fake board.
#include <limits>
#include <map>
#include <memory>
#include <string>

#include "drivers/pca9685/component.hpp"
#include "tests/pca9685/fake_bus.hpp"

namespace polyarm::test {

inline description::ComponentInfo wheel(const std::string& name) {
  description::ComponentInfo out;
  out.name = name;
  out.kind = "joint";
  out.command_interfaces.emplace_back().name = "velocity";
  for (const char* state : {"position", "velocity"}) out.state_interfaces.emplace_back().name = state;
  return out;
}

/// The pins of the JetBot.
inline std::map<std::string, std::string> jetbot(const std::string& bus) {
  return {{"bus", bus},           {"pin_enable_0", "8"}, {"pin_pos_0", "9"}, {"pin_neg_0", "10"},
          {"pin_enable_1", "13"}, {"pin_pos_1", "12"},   {"pin_neg_1", "11"}};
}

inline hardware::ComponentContext wheels_on(std::map<std::string, std::string> parameters,
                                            Nanoseconds period = 20'000'000) {
  hardware::ComponentContext out;
  out.name = "JetBot";
  out.period = period;
  out.parameters = std::move(parameters);
  hardware::RobotInstance robot;
  robot.name = "base";
  description::HardwareInfo block;
  block.name = "JetBot";
  block.components = {wheel("left_wheel_joint"), wheel("right_wheel_joint")};
  robot.hardware = {block};
  out.robots = {robot};
  return out;
}

/// The component in this process, its watchdog in another.
inline drivers::BoardEnvironment fake_environment() {
  return {open_fake_bus, POLYARM_FAKE_PROCESS};
}

}  // namespace polyarm::test
