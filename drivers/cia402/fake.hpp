#pragma once
/// The driver with simulated drives of its own: `hardware: cia402_fake` drives them over the real protocol.
#include <memory>
#include <string>

#include "drivers/cia402/component.hpp"
#include "drivers/cia402/far_side.hpp"
#include "drivers/wire/in_world.hpp"

namespace polyarm::cia402 {

/// The driver's parameters apply, except `bus` and `pace`; joints without a `node` or `counts_per_turn` get
/// one. `faults: KIND@SECOND …` orders faults of FarSide, in seconds since the first activation. While the
/// component is active, one tick of the drives is one cycle of the loop, so that a run repeats itself.
class OnFarSide : public Cia402Component {
 public:
  OnFarSide() : Cia402Component(std::string()) {}
  ~OnFarSide() override { OnFarSide::on_cleanup(); }
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_deactivate() override;
  hardware::CallbackReturn on_cleanup() override;
  hardware::CallbackReturn on_shutdown() override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  bool real() const noexcept override { return false; }
  std::string summary() const override;
  FarSide& far_side() { return *far_; }

 private:
  void stop_in_steps();
  std::unique_ptr<FarSide> far_;
  wire::DueOrders faults_;
  std::atomic<bool> stepped_{false};
};

/// `world: mock` or `world: mujoco` simulates tool, parts and machines around the robot.
class FakeCia402 : public wire::InWorld<OnFarSide> {};

/// The options of a simulated drive for each joint of the settings, at the robot's start.
std::vector<FarDriveOptions> drives_of(const Settings& settings, const hardware::RobotInstance& robot);

}  // namespace polyarm::cia402
