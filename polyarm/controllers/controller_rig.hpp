#pragma once
/// A controller without a cell, for tests: names become places in two lists of numbers, and a test writes
/// states, reads commands and lets cycles pass. Standard types only: tests of plugins include this.
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/controllers/controller.hpp"

namespace polyarm::controllers {

class ControllerRig {
 public:
  using Values = std::map<std::string, std::vector<std::string>>;

  /// The controller is called "tested"; the robot is "arm", its joints have these names and a position to
  /// read and to command (more with offer()). Parameters are written as in YAML.
  ControllerRig(std::unique_ptr<Controller> controller, const std::vector<std::string>& joints,
                const Values& parameters = {})
      : controller_(std::move(controller)) {
    context_.name = "tested";
    context_.robot = "arm";
    context_.period = context_.loop_period = cycle_.period = 1'000'000;
    for (const std::string& joint : joints) {
      context_.joints.push_back(
          {"arm/" + joint, false, -kUnlimited, kUnlimited, kUnlimited, kUnlimited, kUnlimited});
      offer(joint + "/position");
    }
    int line = 1;
    for (const auto& [key, values] : parameters)
      context_.parameters.entries[key] = {values, {"controllers.yaml", line++}, values.size() != 1};
  }

  /// A state and a command more, without the robot's name: "joint_1/velocity".
  void offer(const std::string& interface) {
    context_.state_names.push_back("arm/" + interface);
    context_.command_names.push_back("arm/" + interface);
    states_.push_back(0);
    commands_.push_back(std::numeric_limits<double>::quiet_NaN());
  }

  /// on_configure as a cell calls it. Throws everything that is wrong with the parameters.
  CallbackReturn configure() {
    controller_->forget_interfaces();
    context_.parameters.begin();
    const CallbackReturn result = controller_->on_configure(context_);
    context_.parameters.finish(context_.name);
    context_.parameters.problems().throw_if_errors();
    if (result == CallbackReturn::success) bind();
    return result;
  }
  CallbackReturn activate() { return controller_->on_activate(cycle_); }
  void deactivate() { controller_->on_deactivate(cycle_); }
  CallbackReturn cleanup() { return controller_->on_cleanup(); }
  bool start() { return configure() == CallbackReturn::success && activate() == CallbackReturn::success; }

  /// One update; time then advances by a period of 1 ms.
  ReturnType update() {
    const ReturnType result = controller_->update(cycle_, verdict);
    cycle_.time += cycle_.period;
    ++cycle_.index;
    return result;
  }
  /// Writes a changeable parameter as a cell does between two cycles.
  void change(const std::string& key, const std::string& value) {
    const std::vector<ParameterChange> changes{context_.parameters.change(key, value)};
    if (std::string why = controller_->refuse_changes(changes); !why.empty()) throw Error("bad-value", why);
    changes.front().apply();
    controller_->on_parameters_changed();
  }

  /// With the robot's name or without it.
  double& state(const std::string& name) { return states_[place(context_.state_names, name)]; }
  double& command(const std::string& name) { return commands_[place(context_.command_names, name)]; }
  Controller& controller() { return *controller_; }
  /// Of the next update.
  Nanoseconds time() const { return cycle_.time; }
  ControllerContext& context() { return context_; }
  /// What the supervisor allows; a stop is `speed = 0`.
  Verdict verdict;

 private:
  void bind() {
    for (const std::string& name : controller_->reference_interfaces())
      add(context_.command_names.edit(), commands_, name);
    for (const std::string& name : controller_->exported_states()) add(context_.state_names.edit(), states_, name);
    controller_->bind({states_, commands_, places(context_.state_names, controller_->state_interfaces()),
                       places(context_.command_names, controller_->command_interfaces()),
                       places(context_.command_names, controller_->reference_interfaces()), states_,
                       places(context_.state_names, controller_->exported_states())});
  }
  static void add(std::vector<std::string>& names, std::vector<double>& values, const std::string& name) {
    for (const std::string& known : names)
      if (known == name) return;
    names.push_back(name);
    values.push_back(std::numeric_limits<double>::quiet_NaN());
  }
  static std::size_t place(const std::vector<std::string>& names, const std::string& wanted) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == wanted || names[i] == "arm/" + wanted) return i;
    throw Error("unknown-interface", "the rig has no interface '" + wanted + "'", "offer() it first");
  }
  static std::vector<std::size_t> places(const std::vector<std::string>& names,
                                         const std::vector<std::string>& wanted) {
    std::vector<std::size_t> out;
    for (const std::string& name : wanted) out.push_back(place(names, name));
    return out;
  }

  std::unique_ptr<Controller> controller_;
  ControllerContext context_;
  hardware::Cycle cycle_;
  std::vector<double> states_, commands_;
};

}  // namespace polyarm::controllers
