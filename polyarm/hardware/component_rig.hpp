#pragma once
/// Tests a component without a cell: runs its life cycle in the order of a cell and gives access to states
/// and commands by name. Uses standard types only, because tests of plugins include this file.
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::hardware {

class ComponentRig {
 public:
  /// The component drives one robot, "arm", whose revolute joints have these names, each with `interfaces`,
  /// as if a <ros2_control> block declared them. The component's name is "tested".
  ComponentRig(std::unique_ptr<Component> component, const std::vector<std::string>& joints,
               std::map<std::string, std::string> parameters = {},
               const std::vector<std::string>& interfaces = {"position"})
      : component_(std::move(component)) {
    make_model(joints, interfaces);
    context_.name = "tested";
    context_.robots.push_back(
        {"arm", &model_, nullptr, {}, std::vector<double>(joints.size(), 0.0), model_.hardware});
    for (auto& [key, value] : parameters) context_.parameters[key] = value;
    cycle_.period = context_.period;
  }

  /// The next transition; throws Error("wrong-state") if it is not allowed now. Exceptions of the callback
  /// pass through. After an error on_error() was called, as in a cell.
  CallbackReturn initialise() {
    if (initialised_) wrong("initialised");
    const CallbackReturn result = component_->on_init(context_);
    if (result != CallbackReturn::success) return result;
    initialised_ = true;
    take(component_->state_interfaces(), state_names_, states_);
    take(component_->command_interfaces(), command_names_, commands_);
    commands_.assign(commands_.size(), std::numeric_limits<double>::quiet_NaN());
    return result;
  }
  CallbackReturn configure() {
    return step(&Component::on_configure, LifecycleState::unconfigured, LifecycleState::inactive);
  }
  CallbackReturn activate() {
    return step(&Component::on_activate, LifecycleState::inactive, LifecycleState::active);
  }
  CallbackReturn deactivate() {
    return step(&Component::on_deactivate, LifecycleState::active, LifecycleState::inactive);
  }
  CallbackReturn cleanup() {
    return step(&Component::on_cleanup, LifecycleState::inactive, LifecycleState::unconfigured);
  }
  CallbackReturn shut_down() {
    if (state_ == LifecycleState::finalized) wrong("shut down");
    if (state_ == LifecycleState::active) component_->on_deactivate();
    state_ = LifecycleState::finalized;
    return component_->on_shutdown();
  }
  /// Runs initialise, configure and activate; false at the first that does not succeed.
  bool start() {
    return initialise() == CallbackReturn::success && configure() == CallbackReturn::success &&
           activate() == CallbackReturn::success;
  }

  /// One cycle of the loop: reads states while inactive or active, writes commands while active. After an
  /// error on_error() was called and the component is unconfigured or finalized.
  ReturnType cycle() {
    ReturnType result = ReturnType::ok;
    if (state_ == LifecycleState::inactive || state_ == LifecycleState::active)
      result = component_->read(cycle_, states_);
    if (result == ReturnType::ok && state_ == LifecycleState::active)
      result = component_->write(cycle_, commands_);
    if (result == ReturnType::error) recover();
    cycle_.time += cycle_.period;
    ++cycle_.index;
    return result;
  }

  /// Access by full name, "arm/joint_1/position", or without the robot.
  double& state(const std::string& name) { return states_[place(state_names_, name)]; }
  double& command(const std::string& name) { return commands_[place(command_names_, name)]; }
  LifecycleState lifecycle() const { return state_; }
  Component& component() { return *component_; }
  ComponentContext& context() { return context_; }

 private:
  void make_model(const std::vector<std::string>& joints, const std::vector<std::string>& interfaces) {
    model_.name = "arm";
    model_.links.push_back({"base"});
    description::HardwareInfo block;
    block.name = "tested";
    block.type = "system";
    for (const std::string& name : joints) {
      description::Joint joint;
      joint.name = name;
      joint.type = description::JointType::revolute;
      joint.parent_link = static_cast<int>(model_.links.size()) - 1;
      joint.child_link = joint.parent_link + 1;
      description::Link link{name + "_link"};
      link.parent_joint = static_cast<int>(model_.joints.size());
      model_.actuated.push_back(link.parent_joint);
      model_.links.push_back(std::move(link));
      model_.joints.push_back(std::move(joint));
      description::ComponentInfo info;
      info.name = name;
      info.kind = "joint";
      for (const std::string& one : interfaces) {
        description::InterfaceInfo interface;
        interface.name = one;
        info.command_interfaces.push_back(interface);
        info.state_interfaces.push_back(interface);
      }
      block.components.push_back(std::move(info));
    }
    model_.hardware.push_back(std::move(block));
  }
  static void take(const std::vector<InterfaceDescription>& from, std::vector<std::string>& names,
                   std::vector<double>& values) {
    for (const InterfaceDescription& one : from) {
      names.push_back(one.name);
      values.push_back(one.initial);
    }
  }
  [[noreturn]] void wrong(const char* what) const {
    throw Error("wrong-state", std::string("the component is ") + name(state_) + ", it cannot be " + what);
  }
  void recover() {
    state_ = component_->on_error() == CallbackReturn::success ? LifecycleState::unconfigured
                                                               : LifecycleState::finalized;
  }
  CallbackReturn step(CallbackReturn (Component::*callback)(), LifecycleState from, LifecycleState to) {
    if (!initialised_ || state_ != from) wrong(name(to));
    const CallbackReturn result = (component_.get()->*callback)();
    if (result == CallbackReturn::success) state_ = to;
    if (result == CallbackReturn::error) recover();
    return result;
  }
  static std::size_t place(const std::vector<std::string>& names, const std::string& wanted) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == wanted || names[i] == "arm/" + wanted) return i;
    throw Error("unknown-interface", "the component offers no interface '" + wanted + "'");
  }

  std::unique_ptr<Component> component_;
  description::RobotModel model_;
  ComponentContext context_;
  LifecycleState state_ = LifecycleState::unconfigured;
  bool initialised_ = false;
  std::vector<std::string> state_names_, command_names_;
  std::vector<double> states_, commands_;
  Cycle cycle_;
};

}  // namespace polyarm::hardware
