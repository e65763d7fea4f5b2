#pragma once
/// A driver on a simulated controller, in a world of parts, tools and machines: `world: mock` or
/// `world: mujoco`.
#include <memory>
#include <string>
#include <vector>

#include "drivers/wire/simulated_component.hpp"
#include "drivers/wire/world.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::wire {

/// `Fake` is a component with `joint_names()` and `kStates`, the states of each joint, with which its states
/// begin; the position is the first of them. Without `world` it is what Fake is. The interfaces of the world
/// come behind those of Fake.
template <class Fake>
class InWorld : public Fake {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override {
    world_.reset();
    const std::string world = given(context, "world");
    hardware::ComponentContext own = context;
    own.parameters.erase("world");
    const hardware::CallbackReturn done = Fake::on_init(own);
    if (done != hardware::CallbackReturn::success) return done;
    own_states_ = Fake::state_interfaces().size();
    own_commands_ = Fake::command_interfaces().size();
    if (world.empty()) return done;
    world_ = std::make_unique<World>(world, context, this->joint_names());
    refuse_doubles(Fake::command_interfaces(), world_->commands());
    positions_.resize(this->joint_names().size());
    return done;
  }
  std::vector<hardware::InterfaceDescription> state_interfaces() const override {
    auto out = Fake::state_interfaces();
    if (world_) out.insert(out.end(), world_->states().begin(), world_->states().end());
    return out;
  }
  std::vector<hardware::InterfaceDescription> command_interfaces() const override {
    auto out = Fake::command_interfaces();
    if (world_) out.insert(out.end(), world_->commands().begin(), world_->commands().end());
    return out;
  }
  hardware::CallbackReturn on_configure() override {
    const hardware::CallbackReturn done = Fake::on_configure();
    return done == hardware::CallbackReturn::success && world_ ? world_->configure() : done;
  }
  hardware::CallbackReturn on_activate() override {
    const hardware::CallbackReturn done = Fake::on_activate();
    return done == hardware::CallbackReturn::success && world_ ? world_->activate() : done;
  }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override {
    const hardware::ReturnType result = Fake::read(cycle, states.first(own_states_));
    if (!world_ || result != hardware::ReturnType::ok) return result;
    for (std::size_t j = 0; j < positions_.size(); ++j) positions_[j] = states[Fake::kStates * j];
    return world_->step(cycle, positions_, states.subspan(own_states_));
  }
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override {
    if (world_) world_->command(commands.subspan(own_commands_));
    return Fake::write(cycle, commands.first(own_commands_));
  }
  const hardware::WorldState* world() const noexcept override { return world_ ? world_->world() : nullptr; }
  std::vector<std::string> world_names() const override {
    return world_ ? world_->names() : std::vector<std::string>{};
  }

 private:
  /// A tool of the controller and one of the world cannot be the same.
  static void refuse_doubles(const std::vector<hardware::InterfaceDescription>& own,
                             const std::vector<hardware::InterfaceDescription>& others) {
    for (const auto& one : own)
      for (const auto& other : others)
        if (one.name == other.name)
          throw Error("bad-value", "both the controller and the simulated world have '" + one.name + "'",
                      "leave out `world`, or the gripper of the controller");
  }
  std::unique_ptr<World> world_;
  std::size_t own_states_ = 0, own_commands_ = 0;
  std::vector<double> positions_;
};

}  // namespace polyarm::wire
