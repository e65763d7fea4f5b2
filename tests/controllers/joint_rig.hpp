#pragma once
/// A controller on arrays instead of a loop.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

/// Joints of a robot `arm` with position, velocity and effort to read and to command; ten milliseconds a
/// cycle.
struct JointRig {
  static constexpr Nanoseconds kPeriod = 10'000'000;
  Controller& controller;
  ControllerContext context;
  std::vector<double> states, commands;
  std::vector<std::string> state_names, command_names;
  Cycle cycle{0, kPeriod, 0};
  Verdict verdict;

  JointRig(Controller& c, std::vector<std::string> joints) : controller(c) {
    context.name = "pid";
    context.robot = "arm";
    context.period = kPeriod;
    for (const std::string& joint : joints) {
      context.joints.push_back({"arm/" + joint, false, -10, 10, 100, 100, kUnlimited});
      for (const char* quantity : {"position", "velocity", "effort"}) {
        context.state_names.push_back("arm/" + joint + "/" + quantity);
        context.command_names.push_back("arm/" + joint + "/" + quantity);
      }
    }
  }
  void set(const std::string& key, std::vector<std::string> values) {
    Parameters::Entry entry;
    entry.list = values.size() != 1;
    entry.values = std::move(values);
    entry.where = {"controllers.yaml", 3};
    context.parameters.entries[key] = std::move(entry);
  }
  CallbackReturn configure() {
    const CallbackReturn result = controller.on_configure(context);
    context.parameters.problems().throw_if_errors();
    state_names = controller.state_interfaces();
    for (const std::string& name : controller.exported_states()) state_names.push_back(name);
    command_names = controller.command_interfaces();
    for (const std::string& name : controller.reference_interfaces()) command_names.push_back(name);
    states.assign(state_names.size(), 0.0);
    commands.assign(command_names.size(), std::numeric_limits<double>::quiet_NaN());
    Bindings b{states, commands, {}, {}, {}, states, {}};
    for (std::size_t i = 0; i < state_names.size(); ++i)
      (i < controller.state_interfaces().size() ? b.state : b.exported).push_back(i);
    for (std::size_t i = 0; i < command_names.size(); ++i)
      (i < controller.command_interfaces().size() ? b.command : b.reference).push_back(i);
    controller.bind(b);
    return result;
  }
  void start() {
    ASSERT_EQ(configure(), CallbackReturn::success);
    ASSERT_EQ(controller.on_activate(cycle), CallbackReturn::success);
  }
  double& state(const std::string& name) { return at(state_names, states, name); }
  double& command(const std::string& name) { return at(command_names, commands, name); }
  void step() {
    EXPECT_EQ(controller.update(cycle, verdict), ReturnType::ok);
    cycle.time += kPeriod;
    ++cycle.index;
  }

 private:
  static double& at(const std::vector<std::string>& names, std::vector<double>& values,
                    const std::string& name) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == name) return values[i];
    ADD_FAILURE() << "nothing is called " << name;
    static double nothing;
    return nothing;
  }
};

}  // namespace polyarm::controllers
