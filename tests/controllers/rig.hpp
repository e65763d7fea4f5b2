#pragma once
/// A controller on a table of its own, without a loop: names become places in two arrays, and a test writes
/// states, reads commands and lets cycles pass.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

struct Rig {
  using Values = std::map<std::string, std::vector<std::string>>;
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  Controller& controller;
  ControllerContext context;
  Cycle cycle{1'000'000'000, 10'000'000, 0};  ///< 1 s after the start, 10 ms a cycle
  Verdict verdict;
  std::vector<double> states, commands;

  /// `joints` without the robot; `states` and `commands` without it too: "wheel/velocity".
  Rig(Controller& tested, const std::string& robot, const std::vector<std::string>& joints,
      const std::vector<std::string>& state_names, const std::vector<std::string>& command_names,
      const Values& parameters = {}, const std::string& name = "tested")
      : controller(tested) {
    context.name = name;
    context.robot = robot;
    context.period = context.loop_period = cycle.period;
    for (const std::string& joint : joints)
      context.joints.push_back({robot + "/" + joint, true, -kUnlimited, kUnlimited, 100, 1000, kUnlimited});
    for (const std::string& one : state_names) context.state_names.push_back(robot + "/" + one);
    for (const std::string& one : command_names) context.command_names.push_back(robot + "/" + one);
    int line = 10;
    for (const auto& [key, values] : parameters) set(key, values, line++);
  }

  void set(const std::string& key, std::vector<std::string> values, int line = 7) {
    Parameters::Entry entry;
    entry.list = values.size() != 1;
    entry.values = std::move(values);
    entry.where = {"controllers.yaml", line};
    context.parameters.entries[key] = std::move(entry);
  }

  /// Configures and binds as the controller manager does. Throws what is wrong with the parameters.
  CallbackReturn configure() {
    controller.forget_interfaces();
    context.parameters.begin();
    const CallbackReturn result = controller.on_configure(context);
    context.parameters.finish(context.name);
    context.parameters.problems().throw_if_errors();
    if (result == CallbackReturn::success) bind();
    return result;
  }
  void bind() {
    for (const std::string& one : controller.reference_interfaces()) add(context.command_names.edit(), one);
    for (const std::string& one : controller.exported_states()) add(context.state_names.edit(), one);
    states.resize(context.state_names.size(), 0.0);
    commands.resize(context.command_names.size(), kNone);
    controller.bind({states, commands, places(context.state_names, controller.state_interfaces()),
                     places(context.command_names, controller.command_interfaces()),
                     places(context.command_names, controller.reference_interfaces()), states,
                     places(context.state_names, controller.exported_states())});
  }
  CallbackReturn activate(bool chained = false) {
    controller.set_chained(chained);
    return controller.on_activate(cycle);
  }
  void start(bool chained = false) {
    ASSERT_EQ(configure(), CallbackReturn::success);
    ASSERT_EQ(activate(chained), CallbackReturn::success);
  }

  /// By name with its robot, or without it.
  double& state(const std::string& name) { return states.at(place(context.state_names, name)); }
  double& command(const std::string& name) { return commands.at(place(context.command_names, name)); }

  ReturnType step() {
    const ReturnType result = controller.update(cycle, verdict);
    cycle.time += cycle.period;
    ++cycle.index;
    return result;
  }
  void steps(int n) {
    for (int k = 0; k < n; ++k) EXPECT_EQ(step(), ReturnType::ok);
  }

  /// The newest value of a field of an output; NaN where nothing was told.
  double told(const std::string& output, const std::string& field) {
    Output* found = controller.find_output(output);
    if (!found) return ADD_FAILURE() << "no output " << output, kNone;
    fresh[output] = found->fetch() || fresh[output];
    const auto at = std::find(found->fields().begin(), found->fields().end(), field);
    if (at == found->fields().end()) return ADD_FAILURE() << "no field " << field, kNone;
    return fresh[output] ? found->value().values[static_cast<std::size_t>(at - found->fields().begin())]
                         : kNone;
  }

  /// Writes a changeable parameter as the controller manager does; returns why not.
  std::string change(const std::string& key, const std::string& value) {
    const std::vector<ParameterChange> changes{context.parameters.change(key, value)};
    if (std::string why = controller.refuse_changes(changes); !why.empty()) return why;
    changes.front().apply();
    controller.on_parameters_changed();
    return {};
  }

  /// What configuring throws, as text; "" if nothing.
  std::string refusal() {
    try {
      configure();
    } catch (const Error& e) {
      return e.what();
    }
    return {};
  }
  /// The texts of all findings, warnings among them.
  std::string findings() {
    std::string out;
    for (const Problem& problem : context.parameters.problems().list()) out += problem.text() + "\n";
    return out;
  }

 private:
  static void add(std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  std::size_t place(const std::vector<std::string>& names, const std::string& name) const {
    for (const std::string& whole : {name, context.robot + "/" + name}) {
      const auto found = std::find(names.begin(), names.end(), whole);
      if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    }
    ADD_FAILURE() << "no interface " << name;
    return names.size();
  }
  std::vector<std::size_t> places(const std::vector<std::string>& names,
                                  const std::vector<std::string>& wanted) const {
    std::vector<std::size_t> out;
    for (const std::string& name : wanted) out.push_back(place(names, name));
    return out;
  }
  std::map<std::string, bool> fresh;
};

}  // namespace polyarm::controllers
