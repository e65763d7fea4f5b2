#pragma once
/// The driver with a simulated controller of its own: `hardware: xarm_fake` drives it over the real wires.
#include <string>

#include "drivers/wire/in_world.hpp"
#include "drivers/wire/simulated_component.hpp"
#include "drivers/xarm/component.hpp"
#include "drivers/xarm/far_side.hpp"

namespace polyarm::xarm {

/// The driver's parameters apply, except host and ports. `wires: 0=0 2=5` connects outputs to inputs, as
/// OUTPUT=INPUT; `world: mock` or `world: mujoco` simulates tool, parts and machines. `faults: KIND@SECOND
/// KIND@again …` orders faults of FarSide, in seconds since the first activation. While the component is
/// active, one cycle of the controller is one cycle of the loop, a report comes in each of them, and the rest
/// is exchanged every 12 cycles; in forward mode in each of them.
class FakeXarm : public wire::SimulatedComponent<wire::InWorld<XarmComponent>, FarSide> {
 public:
  FakeXarm() { stepped_link_ = true; }
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  std::string summary() const override;

 private:
  void step_moves(double period) noexcept;
};

}  // namespace polyarm::xarm
