#pragma once
/// The driver with a simulated controller of its own: `hardware: abb_fake` drives it over the real wires.
#include <memory>
#include <string>
#include <vector>

#include "drivers/abb/component.hpp"
#include "drivers/abb/far_side.hpp"
#include "drivers/wire/in_world.hpp"
#include "drivers/wire/simulated_component.hpp"

namespace polyarm::abb {

/// The driver's parameters apply, except host and ports; `rws` chooses the version of Robot Web Services.
/// `wires: doA=diB` connects outputs to inputs. `world: mock` or `world: mujoco` simulates tool, parts and
/// machines around the robot, with their interfaces. `faults: KIND@SECOND KIND@again …` orders faults of
/// FarSide, in seconds since the first activation. While the component is active, the controller's clock
/// stands still between two cycles of the loop, and signals are exchanged every 12 cycles, so that a run
/// repeats itself, as fast as the machine can.
class FakeAbb : public wire::SimulatedComponent<wire::InWorld<AbbComponent>, FarSide> {
 public:
  FakeAbb() {
    paced_ = false;
    follows_ = true;
    stepped_services_ = true;
  }
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  std::string summary() const override;
};

}  // namespace polyarm::abb
