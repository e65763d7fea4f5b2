#pragma once
/// The driver with a simulated controller of its own: `hardware: ur_fake` drives it over the real wires.
#include <memory>

#include "drivers/ur/component.hpp"
#include "drivers/ur/far_side.hpp"
#include "drivers/wire/in_world.hpp"
#include "drivers/wire/simulated.hpp"

namespace polyarm::ur {

/// The driver's parameters apply, except host and ports. `wires: 0=0 1=3` connects outputs to inputs, as
/// OUTPUT=INPUT. `world: mock` or `world: mujoco` simulates tool, parts and machines around the robot, with
/// their interfaces. `faults: KIND@SECOND KIND@again …` orders faults of FarSide, in seconds since the first
/// activation. While the component is active, the controller's clock stands still between two cycles of the
/// loop, so that a run repeats itself, as fast as the machine can.
class FakeUr : public wire::InWorld<UrComponent> {
 public:
  FakeUr() { paced_ = false; }
  ~FakeUr() override;
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_deactivate() override;
  hardware::CallbackReturn on_cleanup() override;
  hardware::CallbackReturn on_shutdown() override { return on_cleanup(); }
  hardware::CallbackReturn on_error() override { return on_cleanup(); }
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  bool real() const noexcept override { return false; }
  std::string summary() const override;
  FarSide& far_side() { return *far_; }

 private:
  bool await_package(double sent) noexcept;
  std::unique_ptr<FarSide> far_;
  wire::DueOrders faults_;
  std::atomic<bool> stepped_{false};
  bool disturbed_ = false;
};

}  // namespace polyarm::ur
