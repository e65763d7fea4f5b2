#pragma once
/// A robot of Yaskawa with six axes (YRC1000, YRC1000micro, DX200, DX100, FS100) over MotoROS and the
/// High-Speed Ethernet Server.
#include <memory>
#include <string>
#include <vector>

#include "drivers/forward/forward_component.hpp"
#include "drivers/wire/stream_component.hpp"
#include "drivers/yaskawa/forward_link.hpp"
#include "drivers/yaskawa/link.hpp"

namespace polyarm::yaskawa {

/// States: JOINT/position (rad), velocity (rad/s), torque_share (of the rated torque); flange_pose/position.x
/// … orientation.w (m, of the tool in base coordinates); controller/servo_on, play, remote, running, ready,
/// hold, alarm, error, emergency_stop (0 or 1), alarm_code, buffered (s of motion in the controller), busy
/// (points that were sent again), behind (rad, of the sent command behind the loop's), shaped (points that
/// were not sent as given); io/digital_in_N, digital_out_N. What only the Ethernet server knows is NaN
/// without it. Commands: JOINT/position; io/digital_out_N. NaN leaves them as they are.
///
/// The loop runs by the clock of this computer. The controller has its own and keeps a buffer of points; the
/// driver holds that buffer at `lead_ms`. Configuring connects, reads and moves nothing. Activating starts
/// the job INIT_ROS; the robot stands still, and the first command must be at the measured position.
/// Deactivating brakes the robot and ends the job.
///
/// In forward mode the commands of joints are not sent: moves come over ForwardMoves, and go to the job
/// POLYARM over the Ethernet server. MotoROS is not used. Outputs are switched between two moves.
class YaskawaComponent
    : public forward::ForwardComponent<wire::StreamComponent<Link, Cause>, ForwardLink, Cause> {
 public:
  static constexpr std::size_t kStates = 3;  ///< of each joint, the position first
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
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
  bool stepped_link_ = false;  ///< the controller's clock waits for the loop

 private:
  void find_limits(const hardware::RobotInstance& robot, double max_speed);
  void make_stream(const hardware::ComponentContext& context, hardware::DriverParameters& p);
  void make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p);
  hardware::ReturnType read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept;
  hardware::ReturnType write_forward(std::span<const double> commands) noexcept;
  void add_signals(std::uint32_t inputs, std::uint32_t outputs, std::span<double> states) const noexcept;

  LinkSettings settings_;
  std::string robot_;
  std::vector<std::string> joints_;
  // The robot is behind the loop: an output waits until the robot is where the loop was. The control
  // thread's.
  std::vector<Outputs> outputs_;  ///< of the last cycles
  std::size_t newest_ = 0;
};

/// Cycles of the loop for one point: at least `least_ms`, and whole milliseconds. Throws Error("bad-value").
int cycles_of_point(Nanoseconds period, double least_ms);

}  // namespace polyarm::yaskawa
