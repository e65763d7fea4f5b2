#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "drivers/sensors/serial_sensor.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::test {

/// Time as a test wants it.
inline Nanoseconds test_now = 0;
inline Nanoseconds test_clock() noexcept {
  return test_now;
}

/// One component with a robot of no joints, read as a loop would.
template <typename Sensor>
class SensorRig {
 public:
  explicit SensorRig(std::map<std::string, std::string> parameters,
                     std::vector<description::HardwareInfo> blocks = {})
      : sensor(&test_clock) {
    context.name = "unit";
    context.parameters = std::move(parameters);
    model.name = "carrier";
    hardware::RobotInstance robot;
    robot.name = "cart";
    robot.model = &model;
    robot.hardware = std::move(blocks);
    context.robots = {robot};
  }

  /// The error of on_init, as text; "" if there is none.
  std::string init() {
    try {
      sensor.on_init(context);
    } catch (const Error& e) {
      return e.what();
    }
    names.clear();
    for (const auto& state : sensor.state_interfaces()) names.push_back(state.name);
    states.assign(names.size(), -99);
    return {};
  }
  bool configure() { return init().empty() && sensor.on_configure() == hardware::CallbackReturn::success; }
  hardware::ReturnType read() { return sensor.read({}, states); }
  /// Reads until the condition holds; false if it does not for seconds.
  template <typename Condition>
  bool until(Condition condition) {
    const Nanoseconds end = realtime::monotonic_now() + 5'000'000'000;
    do {
      last = read();
      if (condition()) return true;
      std::this_thread::yield();
    } while (realtime::monotonic_now() < end);
    return false;
  }
  double state(const std::string& name) const {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == name) return states[i];
    ADD_FAILURE() << "no state " << name;
    return -77;
  }

  Sensor sensor;
  hardware::ComponentContext context;
  description::RobotModel model;
  std::vector<std::string> names;
  std::vector<double> states;
  hardware::ReturnType last = hardware::ReturnType::ok;
};

inline description::HardwareInfo sensor_block(const std::string& sensor, std::vector<std::string> states) {
  description::HardwareInfo out;
  out.name = "unit";
  out.type = "sensor";
  description::ComponentInfo part;
  part.name = sensor;
  part.kind = "sensor";
  for (const std::string& name : states) {
    part.state_interfaces.emplace_back();
    part.state_interfaces.back().name = name;
  }
  out.components = {part};
  return out;
}

}  // namespace polyarm::test
