#include "polyarm/tasks/force_readings.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/tasks/force_states.hpp"

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

const CellRobot* ForceReadings::find_robot(const std::string& name) const {
  const auto at = std::find_if(setup_.robots.begin(), setup_.robots.end(),
                               [&](const auto& each) { return each->entry.name == name; });
  return at == setup_.robots.end() ? nullptr : at->get();
}

std::optional<ForceStates> force_states(const Machine& machine, const std::string& robot) {
  const std::string_view first = kAxes.front();
  for (const std::string& name : machine.table().state_names()) {
    if (!name.starts_with(robot + "/") || !name.ends_with("/" + std::string(first))) continue;
    const std::string sensor = name.substr(0, name.size() - first.size());
    ForceStates out;
    out.sensor = sensor.substr(robot.size() + 1, sensor.size() - robot.size() - 2);
    bool all = true;
    for (std::size_t i = 0; i < kAxes.size(); ++i) {
      const auto state = machine.table().find_state(sensor + kAxes[i]);
      all = all && state;
      if (state) out.states[i] = *state;
    }
    if (all) return out;
  }
  return std::nullopt;
}

/// The sensor by the states of the hardware.
std::optional<ForceReadings::Sensor> ForceReadings::find_sensor(const std::string& robot) const {
  Sensor out;
  const CellRobot* const entry = find_robot(robot);
  const auto noise = [](const hardware::ForceSensorErrors& errors) {
    return errors.noise > 0 || errors.torque_noise > 0;
  };
  out.noisy = setup_.options.real || (entry && noise(entry->entry.sensor_errors));
  const std::optional<ForceStates> found = force_states(machine_, robot);
  if (!found) return std::nullopt;
  out.states = found->states;
  return out;
}

ForceReadings::Sensor& ForceReadings::sensor_of(const std::string& robot) {
  if (const auto at = sensors_.find(robot); at != sensors_.end()) return at->second;
  if (std::optional<Sensor> found = find_sensor(robot)) return sensors_[robot] = *std::move(found);
  const CellRobot* const entry = find_robot(robot);
  if (!entry || !entry->entry.force_sensor)
    throw Error("signal", "'" + robot + "' has no force sensor",
                "write `force_sensor: true` at the robot in cell.yaml, for physics, or use hardware with a sensor");
  if (setup_.options.real)
    for (const NamedHardware& real : named_real_hardware(setup_.robots))
      if (real.robot == robot)
        throw Error("signal", "the hardware of '" + robot + "' gives no force: a search would not stop",
                    "take `force_sensor` out of cell.yaml, or use hardware with a sensor");
  observer_.on_note("'" + robot + "' has no physics: its force sensor measures zero");
  Sensor out;
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
  if (sensor.rest.empty()) return;
  for (std::size_t i = 0; i < sensor.zero.size(); ++i) {
    double sum = 0;
    for (const Wrench& each : sensor.rest) sum += each[i];
    sensor.zero[i] = sum / static_cast<double>(sensor.rest.size());
  }
}

void ForceReadings::tick(const std::function<bool(const std::string&)>& stands) {
  constexpr std::size_t kKept = 25;  // 50 ms
  if (!std::exchange(looked_, true))
    for (const auto& robot : setup_.robots)
      if (const auto found = find_sensor(robot->entry.name); found && found->noisy)
        sensors_[robot->entry.name] = *found;
  for (auto& [robot, sensor] : sensors_) {
    if (!sensor.noisy || sensor.simulated_as_zero) continue;
    if (!stands(robot)) {
      sensor.rest.clear();
      continue;
    }
    const std::vector<double>& states = machine_.snapshot().states;
    Wrench now{};
    for (std::size_t i = 0; i < now.size(); ++i) now[i] = states[sensor.states[i]];
    if (std::any_of(now.begin(), now.end(), [](double each) { return !std::isfinite(each); })) continue;
    sensor.rest.push_back(now);
    if (sensor.rest.size() > kKept) sensor.rest.pop_front();
  }
}

}  // namespace polyarm::cell
