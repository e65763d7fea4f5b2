#pragma once
/// The driver with a simulated controller of its own: `hardware: kuka_fake` drives it over the real wires.
#include <string>

#include "drivers/kuka/component.hpp"
#include "drivers/kuka/far_side.hpp"
#include "drivers/wire/in_world.hpp"
#include "drivers/wire/simulated_component.hpp"

namespace polyarm::kuka {

/// The driver's parameters apply, except host and ports. `wires: 1=1 2=5` connects outputs to inputs, as
/// OUTPUT=INPUT. `world: mock` or `world: mujoco` simulates tool, parts and machines around the robot, with
/// their interfaces. `faults: KIND@SECOND KIND@again …` orders faults of FarSide, in seconds since the first
/// activation. While the component is active, states and outputs are exchanged every 12 cycles.
class FakeKuka : public wire::SimulatedComponent<wire::InWorld<KukaComponent>, FarSide> {
 public:
  FakeKuka() {
    paced_ = false;
    follows_ = true;
    stepped_link_ = true;
  }
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  std::string summary() const override;
};

}  // namespace polyarm::kuka
