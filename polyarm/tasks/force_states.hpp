#pragma once
/// Finds the states of a force sensor in the table of the hardware. Cell thread.
#include <array>
#include <optional>
#include <string>

#include "polyarm/machine/machine.hpp"

namespace polyarm::cell {

struct ForceStates {
  std::string sensor;  ///< its component
  std::array<std::size_t, 6> states{};
};
/// The first sensor of the robot that has all of ROBOT/SENSOR/force.x … torque.z.
std::optional<ForceStates> force_states(const Machine& machine, const std::string& robot);

}  // namespace polyarm::cell
