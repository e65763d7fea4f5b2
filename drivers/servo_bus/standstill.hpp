#pragma once
/// Brings joints to standstill; used by the component, and by the watchdog in its place. No allocation.
#include <span>
#include <vector>

#include "drivers/servo_bus/bus.hpp"
#include "drivers/servo_bus/setup.hpp"

namespace polyarm::servo_bus {

constexpr double kStandstill = 0.02;  // rad/s

const Register& goal_register(const Family& family, Mode mode) noexcept;

/// A joint in position mode with a goal away from its position gets goal = measured, within `min` and `max`
/// (steps); others get the goal 0. Torque is unchanged. `ok` when the servo has confirmed it.
Outcome stand(ServoBus& bus, std::uint8_t id, Mode mode, int min, int max) noexcept;

struct StandingJoint {
  std::uint8_t id = 0;
  Mode mode = Mode::position;
  int slow = 0;  ///< for a joint in velocity mode: the speed in counts that counts as standstill
};

/// One attempt on a bus in any state: speed 0 to all joints in velocity mode with one instruction, then
/// stand() for each joint. `ok` when all joints have confirmed their goals, and those in velocity mode are at
/// standstill.
Outcome all_at_rest(ServoBus& bus, std::span<const StandingJoint> joints) noexcept;

}  // namespace polyarm::servo_bus
