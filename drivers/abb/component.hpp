#pragma once
/// A robot of ABB with six axes (IRC5 or OmniCore) over Externally Guided Motion and Robot Web Services, or
/// with `motion: forward` over our RAPID program PolyarmMoves instead of EGM.
#include <memory>
#include <string>
#include <vector>

#include "drivers/abb/forward_link.hpp"
#include "drivers/abb/link.hpp"
#include "drivers/forward/forward_component.hpp"
#include "drivers/wire/stream_component.hpp"

namespace polyarm::abb {

/// States: JOINT/position (rad), velocity (rad/s); flange_pose/position.x … orientation.w (m, in the
/// controller's world frame; NaN before EGM runs); force/force.x … torque.z (N, N·m; NaN without a sensor);
/// controller/motors_on, automatic, running, egm, guard_stop, emergency_stop, collision, converged (0 or 1),
/// speed_ratio (0 to 1), utilization (%), lost_packets, behind (rad, of the sent command behind the loop's),
/// shaped (commands that were not sent as given); io/NAME of each signal. Commands: JOINT/position; io/NAME
/// of each output; controller/speed_ratio (of RAPID motion, not of EGM). NaN leaves them as they are.
///
/// Configuring connects, reads and moves nothing. Activating starts the controller's program; the robot
/// stands still, and the first command must be at the measured position. Deactivating brakes the robot and
/// stops the program. When commands stop for any reason, the controller's own watchdog stops the robot.
///
/// In forward mode the commands of joints are not sent: moves come over ForwardMoves, and go to the program.
/// States that only EGM has are NaN or 0.
class AbbComponent
    : public forward::ForwardComponent<wire::StreamComponent<Link, Cause>, ForwardLink, Cause> {
 public:
  static constexpr std::size_t kStates = 2;  ///< of each joint, the position first

  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_deactivate() override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

 protected:
  const std::vector<std::string>& joint_names() const { return joints_; }
  bool stepped_services_ = false;

 private:
  void make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p);
  hardware::ReturnType read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept;
  hardware::ReturnType write_forward(std::span<const double> commands) noexcept;
  void show_signals(const Panel& panel, std::span<double> states) const noexcept;
  void take_outputs(std::span<const double> commands) noexcept;
  /// `at`: where the robot is; `guided`: by our program, so that it does not jump.
  const wire::Six& shown_position(const wire::Six& at, bool guided, double dt) noexcept;

  LinkSettings settings_;
  std::string name_, robot_;
  std::vector<std::string> joints_;
  // the control thread's
  std::atomic<bool> guided_{false};  ///< from the first packet until the program is stopped
  bool placed_ = false;              ///< shown_ is a position of the robot
  wire::Six shown_{};                ///< rad
  std::uint64_t shown_count_ = 0;    ///< of positions that were shown without a session of moves
  Outputs outputs_;
};

}  // namespace polyarm::abb
