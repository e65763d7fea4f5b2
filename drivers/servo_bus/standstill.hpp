#pragma once
/// Making joints stand where they are; for the component, and for the watchdog that does it in its place.
#include <span>
#include <vector>

#include "drivers/servo_bus/bus.hpp"
#include "drivers/servo_bus/setup.hpp"

namespace polyarm::servo_bus {

constexpr double kStandstill = 0.02;  // rad/s

const Register& goal_register(const Family& family, Mode mode) noexcept;

/// A joint in position whose goal is not where it is gets goal = measured, within `min` and `max` (steps);
/// others get the goal 0. Torque stays as it is. `ok` when the servo has confirmed it.
Outcome stand(ServoBus& bus, std::uint8_t id, Mode mode, int min, int max) noexcept;

struct StandingJoint {
  std::uint8_t id = 0;
  Mode mode = Mode::position;
  int slow = 0;  ///< of a joint in velocity: counts of its speed that are a standstill
};

/// One attempt on a bus that may be in any state: speed 0 to all joints in velocity with one instruction,
/// then each joint as stand() has it. `ok` when all joints have confirmed their goals, and those in velocity
/// that they stand.
Outcome stand_all(ServoBus& bus, std::span<const StandingJoint> joints) noexcept;

}  // namespace polyarm::servo_bus
