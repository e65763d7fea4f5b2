#pragma once
/// Tool, parts and machines around a simulated controller: a component that simulates them (mock, mujoco),
/// whose robot is wherever the controller has it. SI units.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::wire {

/// One robot. The calls are those of the component that owns it, on the same threads.
class World {
 public:
  /// `driver`: "mock" or "mujoco"; `joints`: of the controller. Throws Error.
  World(const std::string& driver, const hardware::ComponentContext& context,
        const std::vector<std::string>& joints);

  /// What it has besides the joints: "arm/tool/vacuum", "scene/feeder/feed".
  const std::vector<hardware::InterfaceDescription>& states() const { return states_; }
  const std::vector<hardware::InterfaceDescription>& commands() const { return commands_; }
  /// Once; when the driver connects again, the world is as it was, and its robot does not go back to its
  /// start.
  hardware::CallbackReturn configure();
  hardware::CallbackReturn activate();

  /// A cycle: the joints of the robot (rad) and the newest commands go in, `states` come out.
  hardware::ReturnType step(const hardware::Cycle& cycle, std::span<const double> joints,
                            std::span<double> states) noexcept;
  void command(std::span<const double> commands) noexcept;
  const hardware::WorldState* world() const noexcept { return inside_->world(); }
  std::vector<std::string> names() const { return inside_->world_names(); }

 private:
  std::unique_ptr<hardware::Component> inside_;
  std::vector<hardware::InterfaceDescription> states_, commands_;
  std::vector<std::size_t> state_places_, command_places_, joint_places_;  ///< in the component's lists
  std::vector<std::string> joint_commands_;
  std::vector<double> inner_states_, inner_commands_;
  bool configured_ = false;
};

}  // namespace polyarm::wire
