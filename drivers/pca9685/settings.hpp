#pragma once
/// The settings of a board, from the robot's description.
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/pca9685/motor.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::drivers {

struct Wheel {
  std::string joint;  ///< its name in the description
  MotorSettings motor;
};

struct BoardSettings {
  std::string bus = "/dev/i2c-1";
  std::uint8_t address = 0x60;
  double frequency = 1600;  ///< Hz, as requested
  std::uint8_t prescale = 3;
  int watchdog_ms = 0;
  double period = 0;  ///< s, between two writes
  std::vector<Wheel> wheels;
  // The interfaces of all wheels.
  std::vector<hardware::InterfaceDescription> states, commands;
  struct State {
    std::size_t wheel;
    bool position;
  };
  std::vector<State> state_of;
  std::vector<std::size_t> wheel_of_command;
};

/// The table of parameters that read_settings() uses.
const hardware::DriverFacts& board_facts();

/// Throws Error with all wrong parameters.
BoardSettings read_settings(const hardware::ComponentContext& context);

}  // namespace polyarm::drivers
