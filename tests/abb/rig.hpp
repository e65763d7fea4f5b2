#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/abb/fake.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/catalogue/catalogue.hpp"

namespace polyarm::test {

using abb::Cause;
using abb::FarSide;
using abb::FarSideOptions;
using hardware::CallbackReturn;
using hardware::ReturnType;
using wire::Six;

using Parameters = std::map<std::string, std::string>;
inline constexpr double kDegree = std::numbers::pi / 180;

inline const description::RobotModel& abb_model() {
  static const description::RobotModel model = [] {
    Problems warnings;
    return description::load_robot(
        "abb/irb_120", description::Catalogue({std::string(POLYARM_SOURCE_DIR) + "/robots"}), warnings);
  }();
  return model;
}

inline hardware::ComponentContext abb_context(Parameters parameters = {}) {
  hardware::ComponentContext context;
  context.name = "arm";
  hardware::RobotInstance instance;
  instance.name = "arm";
  instance.model = &abb_model();
  instance.initial_positions = {0.3, 0.2, -0.1, 0.1, 0.8, 0.4};
  context.robots.push_back(instance);
  context.period = 4'000'000;
  context.parameters = std::move(parameters);
  return context;
}

inline FarSideOptions far_options(int version = 2) {
  FarSideOptions options;
  options.machine.facts = abb::facts_of(abb_model());
  options.machine.start = {10, 10, -5, 0, 40, 20};
  options.machine.signals = {{"doA", false}, {"diA", false}};
  if (version == 1) options.machine.software = "6.16.02.00";
  options.rws_version = version;
  options.rws = options.egm = 0;
  return options;
}

/// The driver on its simulated controller, called as a cell calls it.
class AbbRig {
 public:
  explicit AbbRig(Parameters parameters = {}) {
    parameters.try_emplace("digital_out", "doA doB");
    parameters.try_emplace("digital_in", "diA");
    const hardware::ComponentContext context = abb_context(std::move(parameters));
    cycle.period = context.period;
    component.on_init(context);
    for (const auto& one : component.state_interfaces()) state_names.push_back(one.name);
    for (const auto& one : component.command_interfaces()) command_names.push_back(one.name);
    states.assign(state_names.size(), std::nan(""));
    commands.assign(command_names.size(), std::nan(""));
  }
  ~AbbRig() { component.on_shutdown(); }

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
    for (std::size_t j = 0; j < 6; ++j) commands[j] = states[2 * j];
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
  /// rad
  Six q() {
    Six out = far().with([](abb::Machine& machine) { return machine.q(); });
    for (double& one : out) one *= kDegree;
    return out;
  }
  /// rad
  double largest_jump() {
    return far().with([](abb::Machine& machine) { return machine.largest_jump(); }) * kDegree;
  }
  void forget_jumps() {
    far().with([](abb::Machine& machine) { return machine.forget_jumps(), 0; });
  }

  abb::FakeAbb component;
  std::vector<std::string> state_names, command_names;
  std::vector<double> states, commands;
  hardware::Cycle cycle;

 private:
  static std::size_t place(const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  }
};

/// A smooth way from 0 to 1 and its end, for a joint that is moved by hand.
inline double smooth(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return s * s * s * (10 - 15 * s + 6 * s * s);
}

/// The way after `i` cycles of a motion that speeds up smoothly in 80 cycles to `step` for each.
inline double travel(int i, double step) {
  constexpr int kCycles = 80;
  const double x = static_cast<double>(i) / kCycles;
  if (i >= kCycles) return step * (i - kCycles / 2);
  return step * kCycles * x * x * x * x * (2.5 - 3 * x + x * x);
}

}  // namespace polyarm::test
