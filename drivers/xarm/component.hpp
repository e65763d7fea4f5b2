#pragma once
/// A robot of UFACTORY (xArm 5, 6 and 7, Lite 6, 850) in servo mode, or in position mode (forward mode).
#include <array>
#include <string>
#include <vector>

#include "drivers/forward/forward_component.hpp"
#include "drivers/wire/stream_component.hpp"
#include "drivers/xarm/forward_link.hpp"
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
///
/// In forward mode, for arms with six joints, the commands of joints are not sent: moves come over
/// ForwardMoves, and go into the queue of the controller. The controller's tool becomes that of the cell.
class XarmComponent
    : public forward::ForwardComponent<wire::StreamComponent<Link, Cause, kWireJoints>, ForwardLink, Cause> {
 public:
  static constexpr std::size_t kStates = 3;  ///< of each joint, the position first
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

 protected:
  const std::vector<std::string>& joint_names() const { return joints_; }
  bool stepped_link_ = false;  ///< the controller's clock waits for the loop

 private:
  void add_signals(std::vector<hardware::InterfaceDescription>& out, bool inputs) const;
  void make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p);
  hardware::ReturnType read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept;
  /// What follows the joints' states.
  void show_controller(const Report& report, const Panel& panel, const std::array<double, 3>& streaming,
                       Mode mode, std::span<double> states) const noexcept;
  Outputs outputs_of(std::span<const double> commands) const noexcept;

  LinkSettings settings_;
  std::string robot_;
  std::vector<std::string> joints_;
  bool force_sensor_ = false;
};

/// Cycles of the loop for one servo command: `least_ms` or more. Throws Error("bad-value").
int cycles_of_command(Nanoseconds period, double least_ms);

}  // namespace polyarm::xarm
