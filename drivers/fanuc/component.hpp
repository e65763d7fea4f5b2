#pragma once
/// A robot of FANUC (R-30iB Plus and newer, software V9.40P and newer) over Stream Motion, or with
/// `motion: forward` over the Remote Motion Interface alone.
#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "drivers/fanuc/forward_link.hpp"
#include "drivers/fanuc/link.hpp"
#include "drivers/forward/forward_component.hpp"
#include "drivers/wire/stream_component.hpp"

namespace polyarm::fanuc {

/// States: JOINT/position (rad), velocity (rad/s), current (A); flange_pose/position.x … orientation.w (m, in
/// the controller's world frame); force/force.x … torque.z (N, N·m; NaN before version 4); controller/ready,
/// moving, error, teach_pendant, emergency_stop, contact_stop, safety_scale, lost_packets, behind (rad, of
/// the sent command behind the loop's), shaped (commands that were not sent as given); io/digital_in_N,
/// digital_out_N in the controller's numbers. Commands: JOINT/position; io/digital_out_N. NaN leaves an
/// output in the state that it had at activation.
///
/// Configuring connects, reads and moves nothing. Activating starts the controller's streaming program; the
/// robot stands still, and the first command must be at the measured position. Deactivating brakes the robot
/// within the controller's limits and ends the program.
///
/// In forward mode the commands of joints are not sent: moves come over ForwardMoves. States that only Stream
/// Motion has are NaN.
class FanucComponent
    : public forward::ForwardComponent<wire::StreamComponent<Link, Cause>, ForwardLink, Cause> {
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
  bool stepped_forward_ = false;  ///< the simulated controller's clock waits for the loop

 private:
  void find_limits(const description::RobotModel& model);
  void make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p);
  hardware::ReturnType read_forward(const hardware::Cycle& cycle, std::span<double> states) noexcept;
  hardware::ReturnType write_forward(std::span<const double> commands) noexcept;

  double world_height_ = 0;
  LinkSettings settings_;
  std::string name_, robot_;
  std::vector<std::string> joints_;
  std::array<Six, 3> described_{};  ///< limits of the description, degrees, by LimitKind; 0: unknown
  Outputs outputs_;                 ///< the control thread's
};

/// "1-16", "3", "": a range of at most kMostDigital numbers from 1. Throws Error("bad-value").
IoRange io_range(const std::string& parameter, const std::string& text);

}  // namespace polyarm::fanuc
