#pragma once
/// The driver with a simulated robot of its own: `hardware: franka_fake` drives it over the real wires.
#include <string>

#include "drivers/franka/component.hpp"
#include "drivers/franka/far_side.hpp"
#include "drivers/wire/in_world.hpp"

namespace polyarm::franka {

/// The driver's parameters apply, except host, ports and `pace`. `faults: KIND@SECOND …` orders faults of
/// FarSide, in seconds since the first activation. While the component is active, one cycle of the robot is
/// one cycle of the loop, and the hand is served in every tenth.
class OnFarSide : public wire::SimulatedComponent<FrankaComponent, FarSide> {
 public:
  OnFarSide() {
    paced_ = false;
    follows_ = true;
    stepped_link_ = true;
  }
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  std::string summary() const override;
};

/// `world: mock` or `world: mujoco` simulates tool, parts and machines around the robot, with their
/// interfaces.
class FakeFranka : public wire::InWorld<OnFarSide> {};

}  // namespace polyarm::franka
