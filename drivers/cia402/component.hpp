#pragma once
/// An arm of servo drives with CiA 402 on a CAN bus.
#include <string>
#include <vector>

#include "drivers/cia402/link.hpp"
#include "drivers/watchdog/link.hpp"
#include "drivers/wire/stream_component.hpp"

namespace polyarm::cia402 {

/// States: JOINT/position (rad), velocity (rad/s), effort (N m; NaN without a rated torque) as the drives
/// measure them; controller/ready (1: all drives are enabled), limited and warned (bits of the joints whose
/// drive reports an active limit, or a warning), lost (positions that did not come in their cycle). Commands:
/// JOINT/position. NaN for one joint: all keep their targets.
///
/// Configuring prepares the drives and switches nothing on. Activating resets faults (if allowed) and enables
/// each drive where it is measured. Deactivating ends in a quick stop of every drive, which then holds.
class Cia402Component : public wire::StreamComponent<Link, Cause, kMostDrives> {
 public:
  static constexpr std::size_t kStates = 3;  ///< of each joint, the position first
  /// `watchdog`: the path of the program.
  explicit Cia402Component(std::string watchdog = watchdog::find_program(kWatchdogProgram))
      : watchdog_(std::move(watchdog)) {}

  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_shutdown() override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;
  const std::vector<std::string>& joint_names() const { return joints_; }
  int watchdog_process() const noexcept { return link_ ? link_->watchdog_process() : 0; }

 protected:
  const Settings& settings() const noexcept { return settings_; }

 private:
  std::string watchdog_, robot_;
  Settings settings_;
  std::vector<std::string> joints_;
};

}  // namespace polyarm::cia402
