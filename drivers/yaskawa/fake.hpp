#pragma once
/// The driver with a simulated controller of its own: `hardware: yaskawa_fake` drives it over the real wires.
#include <string>

#include "drivers/wire/in_world.hpp"
#include "drivers/wire/simulated_component.hpp"
#include "drivers/yaskawa/component.hpp"
#include "drivers/yaskawa/far_side.hpp"

namespace polyarm::yaskawa {

/// The driver's parameters apply, except host and ports. `wires: 1=1 2=5` connects outputs to inputs, as
/// OUTPUT=INPUT. `world: mock` or `world: mujoco` simulates tool, parts and machines around the robot, with
/// their interfaces. In forward mode the controller has the tool of the cell, and its own `pulses`. `faults:
/// KIND@SECOND KIND@again …` orders faults of FarSide, in seconds since the first activation. While the
/// component is active, one interpolation cycle of the controller is one cycle of the loop, states come in
/// each of them, and the rest is exchanged every 12 cycles.
class FakeYaskawa : public wire::SimulatedComponent<wire::InWorld<YaskawaComponent>, FarSide> {
 public:
  FakeYaskawa() { stepped_link_ = true; }
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_activate() override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  std::string summary() const override;

 private:
  hardware::CallbackReturn activate_forward();
  std::uint64_t cycles_ = 0;
};

}  // namespace polyarm::yaskawa
