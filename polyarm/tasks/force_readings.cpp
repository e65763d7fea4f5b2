#include "polyarm/tasks/force_readings.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/error.hpp"

namespace polyarm::cell {

namespace {
constexpr std::array kAxes = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
}  // namespace

bool may_feel_force(const CellRobot& robot, const CellRobots& robots) {
  if (robot.entry.force_sensor) return true;
  for (const HardwareBlock& block : robot.blocks)
    for (const description::ComponentInfo& component : block.info->components)
      if (component.kind == "sensor" &&
          std::any_of(component.state_interfaces.begin(), component.state_interfaces.end(),
                      [](const auto& state) { return state.name == "force.x"; }))
        return true;
  const std::vector<NamedHardware> real = named_real_hardware(robots);
  return std::any_of(real.begin(), real.end(),
                     [&](const NamedHardware& each) { return each.robot == robot.entry.name; });
}

ForceReadings::Sensor& ForceReadings::sensor_of(const std::string& robot) {
  if (const auto at = sensors_.find(robot); at != sensors_.end()) return at->second;
  Sensor out;
  for (const std::string& name : machine_.table().state_names()) {
    if (!name.starts_with(robot + "/") || !name.ends_with("/force.x")) continue;
    const std::string sensor = name.substr(0, name.size() - std::string_view(kAxes.front()).size());
    bool all = true;
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      const auto state = machine_.table().find_state(sensor + kAxes[i]);
      all = all && state;
      if (state) out.states[i] = *state;
    }
    if (all) return sensors_[robot] = out;
  }
  const auto entry = std::find_if(setup_.robots.begin(), setup_.robots.end(),
                                  [&](const auto& each) { return each->entry.name == robot; });
  if (entry == setup_.robots.end() || !(*entry)->entry.force_sensor)
    throw Error("signal", "'" + robot + "' has no force sensor",
                "write `force_sensor: true` at the robot in cell.yaml, for physics, or use hardware with a sensor");
  if (setup_.options.real)
    for (const NamedHardware& real : named_real_hardware(setup_.robots))
      if (real.robot == robot)
        throw Error("signal", "the hardware of '" + robot + "' gives no force: a search would not stop",
                    "take `force_sensor` out of cell.yaml, or use hardware with a sensor");
  observer_.on_note("'" + robot + "' has no physics: its force sensor measures zero");
  out.simulated_as_zero = true;
  return sensors_[robot] = out;
}

Wrench ForceReadings::measured(const Sensor& sensor, const std::string& robot) const {
  Wrench out{};
  if (sensor.simulated_as_zero) return out;
  const std::vector<double>& states = machine_.snapshot().states;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = sensor.states[i] < states.size() ? states[sensor.states[i]] : NAN;
    if (!std::isfinite(out[i]))
      throw Error("signal", "the force sensor of '" + robot + "' gives no numbers", "look at its hardware");
  }
  return out;
}

Wrench ForceReadings::wrench(const std::string& robot) {
  const Sensor& sensor = sensor_of(robot);
  Wrench out = measured(sensor, robot);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] -= sensor.zero[i];
  return out;
}

void ForceReadings::zero(const std::string& robot) {
  Sensor& sensor = sensor_of(robot);
  sensor.zero = measured(sensor, robot);
}

}  // namespace polyarm::cell
