#pragma once
/// What tests of drivers share whose robots stand behind a network wire: a driver on its simulated
/// controller, called as a cell calls it, and what every fault must end in.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "drivers/wire/shaper.hpp"
#include "polyarm/catalogue/catalogue.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::test {

using hardware::CallbackReturn;
using hardware::ReturnType;
using wire::Six;

using Parameters = std::map<std::string, std::string>;
inline constexpr double kDegree = std::numbers::pi / 180;

/// A robot of the catalogue, such as "abb/irb_120".
inline const description::RobotModel& catalogue_model(const std::string& name) {
  static std::map<std::string, description::RobotModel> models;
  if (!models.contains(name)) {
    Problems warnings;
    models[name] = description::load_robot(
        name, description::Catalogue({std::string(POLYARM_SOURCE_DIR) + "/robots"}), warnings);
  }
  return models[name];
}

/// Of a component with the robot "arm".
inline hardware::ComponentContext wire_context(const description::RobotModel& model,
                                               std::vector<double> initial_positions, Nanoseconds period,
                                               Parameters parameters) {
  hardware::ComponentContext context;
  context.name = "arm";
  hardware::RobotInstance instance;
  instance.name = "arm";
  instance.model = &model;
  instance.initial_positions = std::move(initial_positions);
  context.robots.push_back(instance);
  context.period = period;
  context.parameters = std::move(parameters);
  return context;
}

/// `Fake` is a driver on its simulated controller, whose machine counts in degrees. `kStates`: states of each
/// joint, the position first.
template <class Fake, std::size_t kStates = 2, std::size_t kJoints = 6>
class WireRig {
 public:
  explicit WireRig(const hardware::ComponentContext& context) {
    cycle.period = context.period;
    component.on_init(context);
    for (const auto& one : component.state_interfaces()) state_names.push_back(one.name);
    for (const auto& one : component.command_interfaces()) command_names.push_back(one.name);
    states.assign(state_names.size(), std::nan(""));
    commands.assign(command_names.size(), std::nan(""));
  }
  ~WireRig() { component.on_shutdown(); }

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
    for (std::size_t j = 0; j < kJoints; ++j) commands[j] = states[kStates * j];
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
  auto& far() { return component.far_side(); }
  /// rad
  auto q() {
    auto out = far().with([](auto& machine) { return machine.q(); });
    for (double& one : out) one *= kDegree;
    return out;
  }
  /// rad
  double largest_jump() {
    return far().with([](auto& machine) { return machine.largest_jump(); }) * kDegree;
  }
  void forget_jumps() {
    far().with([](auto& machine) { return machine.forget_jumps(), 0; });
  }

  Fake component;
  std::vector<std::string> state_names, command_names;
  std::vector<double> states, commands;
  hardware::Cycle cycle;

 private:
  static std::size_t place(const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  }
};

/// A fault, and what the driver must make of it.
template <class Cause>
struct FaultOf {
  const char* order;
  Cause cause;
  const char* words;  ///< a part of the sentence
};
template <class Cause>
std::ostream& operator<<(std::ostream& out, const FaultOf<Cause>& row) {
  return out << row.order;
}
template <class Cause>
std::string fault_name(const testing::TestParamInfo<FaultOf<Cause>>& info) {
  std::string out = info.param.order;
  std::replace(out.begin(), out.end(), '=', '_');
  return out;
}

/// The robot comes to a standstill within `cycles`, and stays there.
template <class Rig>
void expect_standing(Rig& rig, int cycles = 300) {
  // What the driver sent last may still be on its way.
  if constexpr (requires { rig.far().settle(); }) rig.far().settle();
  for (int i = 0; i < cycles; ++i) rig.far().step();
  const auto at = rig.q();
  for (int i = 0; i < 100; ++i) rig.far().step();
  const auto later = rig.q();
  for (std::size_t j = 0; j < at.size(); ++j) EXPECT_NEAR(later[j], at[j], 1e-6) << "joint " << j;
}

/// Draws the same numbers in every run.
class Draw {
 public:
  explicit Draw(std::uint32_t seed) : seed_(seed) {}
  /// Below `n`.
  std::uint32_t operator()(std::uint32_t n) {
    seed_ = seed_ * 1664525u + 1013904223u;
    return (seed_ >> 8) % n;
  }

 private:
  std::uint32_t seed_;
};

/// A smooth way from 0 to 1 and its end, for a joint that is moved by hand.
inline double smooth(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return s * s * s * (10 - 15 * s + 6 * s * s);
}

/// The way after `i` cycles of a motion that speeds up smoothly in `cycles` to `step` for each.
inline double travel(int i, double step, int cycles) {
  const double x = static_cast<double>(i) / cycles;
  if (i >= cycles) return step * (i - cycles / 2);
  return step * cycles * x * x * x * x * (2.5 - 3 * x + x * x);
}

/// The number behind a word, in a line of a far side.
inline std::string number_behind(const std::string& line, const std::string& word) {
  const std::size_t at = line.find(word + " ");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + word.size() + 1;
  return line.substr(begin, line.find_first_not_of("0123456789", begin) - begin);
}

}  // namespace polyarm::test
