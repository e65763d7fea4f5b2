#pragma once
/// The driver with a simulated controller of its own: `hardware: fanuc_fake` drives it over the real wires.
#include <string>

#include "drivers/fanuc/component.hpp"
#include "drivers/fanuc/far_side.hpp"
#include "drivers/wire/in_world.hpp"
#include "drivers/wire/simulated_component.hpp"

namespace polyarm::fanuc {

/// The driver's parameters apply, except host and ports. `wires: 1=1 2=5` connects outputs to inputs, as
/// OUTPUT=INPUT. `world: mock` or `world: mujoco` simulates tool, parts and machines around the robot, with
/// their interfaces. `faults: KIND@SECOND KIND@again …` orders faults of FarSide, in seconds since the first
/// activation. While the component is active, the controller's clock stands still between two cycles of the
/// loop, so that a run repeats itself, as fast as the machine can.
class FakeFanuc : public wire::SimulatedComponent<wire::InWorld<FanucComponent>, FarSide> {
 public:
  FakeFanuc();
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  std::string summary() const override;
};

}  // namespace polyarm::fanuc
