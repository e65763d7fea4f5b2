#include "drivers/wire/world.hpp"

#include <algorithm>
#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/hardware/driver_loader.hpp"

namespace polyarm::wire {

using hardware::CallbackReturn;
using hardware::ReturnType;

World::World(const std::string& driver, const hardware::ComponentContext& context,
             const std::vector<std::string>& joints) {
  if (driver != "mock" && driver != "mujoco")
    throw Error("bad-value", "'" + driver + "' simulates no parts", "`world: mock` or `world: mujoco`");
  inside_ = hardware::make_driver(driver);
  hardware::ComponentContext own = context;
  own.parameters.clear();
  for (hardware::RobotInstance& robot : own.robots) robot.hardware.clear();
  if (inside_->on_init(own) != CallbackReturn::success)
    throw Error("component-failed", "the simulation of parts does not start: " + inside_->reason());
  const std::string robot = context.robots.front().name + "/";
  const auto of_joint = [&](const std::string& name) {
    return std::any_of(joints.begin(), joints.end(),
                       [&](const std::string& joint) { return name.starts_with(robot + joint + "/"); });
  };
  const auto split = [&](const auto& all, auto& out, std::vector<std::size_t>& places) {
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!of_joint(all[i].name)) out.push_back(all[i]), places.push_back(i);
  };
  const auto states = inside_->state_interfaces(), commands = inside_->command_interfaces();
  split(states, states_, state_places_);
  split(commands, commands_, command_places_);
  for (const std::string& joint : joints) {
    joint_commands_.push_back(robot + joint + "/position");
    for (std::size_t i = 0; i < commands.size(); ++i)
      if (commands[i].name == joint_commands_.back()) joint_places_.push_back(i);
  }
  if (joint_places_.size() != joints.size())
    throw Error("component-failed", "the simulation of parts has other joints than the controller");
  inner_states_.resize(states.size());
  for (std::size_t i = 0; i < states.size(); ++i) inner_states_[i] = states[i].initial;
  inner_commands_.assign(commands.size(), std::nan(""));
}

CallbackReturn World::configure() {
  if (configured_) return CallbackReturn::success;
  const CallbackReturn done = inside_->on_configure();
  configured_ = done == CallbackReturn::success;
  return done;
}

CallbackReturn World::activate() {
  const CallbackReturn done = inside_->on_activate();
  if (done == CallbackReturn::success) inside_->perform_command_mode_switch(joint_commands_, {});
  return done;
}

void World::command(std::span<const double> commands) noexcept {
  for (std::size_t i = 0; i < command_places_.size(); ++i) inner_commands_[command_places_[i]] = commands[i];
}

ReturnType World::step(const hardware::Cycle& cycle, std::span<const double> joints,
                       std::span<double> states) noexcept {
  for (std::size_t j = 0; j < joint_places_.size(); ++j) inner_commands_[joint_places_[j]] = joints[j];
  ReturnType result = inside_->write(cycle, inner_commands_);
  if (result == ReturnType::ok) result = inside_->read(cycle, inner_states_);
  for (std::size_t i = 0; i < state_places_.size(); ++i) states[i] = inner_states_[state_places_[i]];
  return result;
}

}  // namespace polyarm::wire
