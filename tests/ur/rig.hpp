#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drivers/ur/fake.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::test {

using hardware::CallbackReturn;
using hardware::ReturnType;
using ur::Cause;
using ur::FarSide;

using Parameters = std::map<std::string, std::string>;

inline const description::RobotModel& ur_model(const std::string& name = "ur5e") {
  static std::map<std::string, description::RobotModel> models;
  if (!models.contains(name)) {
    Problems warnings;
    models[name] = description::load_robot(
        "universal_robots/" + name, description::Catalogue({std::string(POLYARM_SOURCE_DIR) + "/robots"}),
        warnings);
  }
  return models[name];
}

inline hardware::ComponentContext ur_context(std::map<std::string, std::string> parameters = {},
                                             const std::string& robot = "ur5e") {
  hardware::ComponentContext context;
  context.name = "arm";
  hardware::RobotInstance instance;
  instance.name = "arm";
  instance.model = &ur_model(robot);
  instance.initial_positions = {0.3, -1.2, 1.1, -1.5, -1.57, 0.2};
  context.robots.push_back(instance);
  context.period = 2'000'000;
  context.parameters = std::move(parameters);
  return context;
}

/// What a person does at the pendant.
inline void mend(FarSide& far) {
  for (const char* order : {"normal", "power_on", "healthy", "program_stop", "remote"}) far.order(order);
}

/// The driver on its simulated controller, called as a cell calls it.
class UrRig {
 public:
  explicit UrRig(Parameters parameters = {}) {
    const hardware::ComponentContext context = ur_context(std::move(parameters));
    cycle.period = context.period;
    component.on_init(context);
    for (const auto& one : component.state_interfaces()) state_names.push_back(one.name);
    for (const auto& one : component.command_interfaces()) command_names.push_back(one.name);
    states.assign(state_names.size(), std::nan(""));
    commands.assign(command_names.size(), std::nan(""));
  }
  ~UrRig() { component.on_shutdown(); }

  bool configure() { return component.on_configure() == CallbackReturn::success; }
  bool activate() {
    std::fill(commands.begin(), commands.end(), std::nan(""));
    if (component.on_activate() != CallbackReturn::success) return false;
    read();
    hold();
    return true;
  }
  bool start() { return configure() && activate(); }
  ReturnType read() {
    const ReturnType result = component.read(cycle, states);
    cycle.time += cycle.period;
    ++cycle.index;
    return result;
  }
  /// As the loop does it after a start: the commands begin where the robot is measured.
  void hold() {
    for (std::size_t j = 0; j < 6; ++j) commands[j] = states[4 * j];
  }
  ReturnType cycle_once() {
    ReturnType result = read();
    if (result == ReturnType::ok) result = component.write(cycle, commands);
    if (result == ReturnType::error) component.on_error();
    return result;
  }
  /// Until it fails, at most so many cycles; `move` changes the commands before each.
  template <typename Move>
  ::testing::AssertionResult fails(int cycles, Move move) {
    for (int i = 0; i < cycles; ++i) {
      move(i);
      if (cycle_once() == ReturnType::error) return ::testing::AssertionSuccess();
    }
    return ::testing::AssertionFailure() << "still well after " << cycles << " cycles";
  }
  template <typename Move>
  ::testing::AssertionResult runs(int cycles, Move move) {
    for (int i = 0; i < cycles; ++i) {
      move(i);
      if (cycle_once() == ReturnType::error)
        return ::testing::AssertionFailure() << i << ": " << component.reason();
    }
    return ::testing::AssertionSuccess();
  }
  double& state(const std::string& name) { return states.at(place(state_names, "arm/" + name)); }
  double& command(const std::string& name) { return commands.at(place(command_names, "arm/" + name)); }
  FarSide& far() { return component.far_side(); }
  ur::Six q() {
    return far().with([](ur::Machine& machine) { return machine.q(); });
  }

  ur::FakeUr component;
  std::vector<std::string> state_names, command_names;
  std::vector<double> states, commands;
  hardware::Cycle cycle;

 private:
  static std::size_t place(const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  }
};

}  // namespace polyarm::test
