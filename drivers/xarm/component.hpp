#pragma once
/// A robot of UFACTORY (xArm 5, 6 and 7, Lite 6, 850) in servo mode.
#include <string>
#include <vector>

#include "drivers/wire/stream_component.hpp"
#include "drivers/xarm/link.hpp"

namespace polyarm::xarm {

/// States: JOINT/position (rad), velocity (rad/s, from two reports), effort (N m, an estimate of the
/// controller); tcp_pose/position.x … orientation.w (m, of the controller's tool in base coordinates);
/// controller/state, mode, ready, error, warning (codes), queued (commands), behind (rad, of the sent command
/// behind the loop's), shaped (commands that were not sent as given), replaced (commands that a newer one
/// replaced); io/digital_in_N, digital_out_N, tool_in_N, tool_out_N; with `force_sensor` tcp_wrench/force.x …
/// torque.z (N, N m). Commands: JOINT/position; io/digital_out_N, tool_out_N. NaN leaves them as they are.
///
/// The loop runs by the clock of this computer, as reports come at 100 Hz at most. Configuring connects,
/// reads and moves nothing. Activating clears an error, switches motors and servo mode on; the robot stands
/// still, and the first command must be at the measured position. Deactivating brakes the robot and leaves
/// the controller stopped, in position mode.
class XarmComponent : public wire::StreamComponent<Link, Cause, kWireJoints> {
 public:
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

 protected:
  bool stepped_link_ = false;  ///< the controller's clock waits for the loop

 private:
  void add_signals(std::vector<hardware::InterfaceDescription>& out, bool inputs) const;

  LinkSettings settings_;
  std::string robot_;
  std::vector<std::string> joints_;
  bool force_sensor_ = false;
};

/// Cycles of the loop for one servo command: `least_ms` or more. Throws Error("bad-value").
int cycles_of_command(Nanoseconds period, double least_ms);

}  // namespace polyarm::xarm
