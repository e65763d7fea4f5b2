#pragma once
/// A robot of KUKA with six axes (KR C4 or KR C5) over the Robot Sensor Interface and EthernetKRL.
#include <memory>
#include <string>
#include <vector>

#include "drivers/forward/forward_component.hpp"
#include "drivers/kuka/forward_link.hpp"
#include "drivers/kuka/link.hpp"
#include "drivers/wire/stream_component.hpp"

namespace polyarm::kuka {

/// States: JOINT/position (rad), velocity (rad/s); flange_pose/position.x … orientation.w (m, of the tool in
/// the base that the controller's program chose; NaN before RSI runs); controller/drives_on, automatic,
/// running, rsi, guard_stop, emergency_stop, message (0 or 1), speed_override (0 to 1), late_answers (in a
/// row), lost_packets, behind (rad, of the sent command behind the loop's), shaped (commands that were not
/// sent as given); io/digital_in_N, digital_out_N. Commands: JOINT/position; io/digital_out_N;
/// controller/speed_override (of KRL motion, not of RSI). NaN leaves them as they are.
///
/// Configuring connects, reads and moves nothing. Activating starts RSI; the robot stands still, and the
/// first command must be at the measured position. Deactivating brakes the robot and ends RSI. When answers
/// stop for any reason, the controller ends RSI by itself.
///
/// In forward mode the commands of joints are not sent: moves come over ForwardMoves, and go to the program
/// PolyarmMoves over EthernetKRL. RSI is not used. The driver has the override to itself then.
class KukaComponent
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
  bool stepped_link_ = false;  ///< the controller's clock waits for answers

 private:
  const wire::Six& shown_position(bool guided, double dt) noexcept;
  void make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p);
  hardware::ReturnType read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept;
  hardware::ReturnType write_forward(std::span<const double> commands) noexcept;
  std::string forward_summary() const;
  void add_signals(const EkiState& state, std::uint32_t inputs, std::span<double> states) const noexcept;

  LinkSettings settings_;
  wire::SignalRange inputs_;
  std::string name_, robot_;
  std::vector<std::string> joints_;
  // the control thread's
  std::atomic<bool> guided_{false};  ///< RSI runs
  bool placed_ = false;              ///< shown_ is a position of the robot
  wire::Six shown_{};                ///< rad
  Outputs outputs_;
};

}  // namespace polyarm::kuka
