#pragma once
/// A robot of Franka (Research 3 or Panda) over the Franka Control Interface, and its hand.
#include <string>
#include <vector>

#include "drivers/franka/link.hpp"
#include "drivers/wire/stream_component.hpp"

namespace polyarm::franka {

/// States: JOINT/position (rad, measured), velocity (rad/s), effort (N m, measured), external_torque (N m,
/// estimated); tcp_pose/position.x … orientation.w (m, of the end effector that Desk knows, in the base);
/// force/force.x … torque.z (N, N m, the estimated wrench of the surroundings on the stiffness frame, in its
/// axes) and force_base/… (the same in the axes of the base); controller/mode, ready, guiding, user_stop,
/// error (number of the flag, -1: none), success_rate (0 to 1), lost_states, behind (rad), shaped; with
/// `hand` tool/width, tool/max_width (m), tool/part_present, tool/busy (0 or 1), tool/temperature (degrees
/// Celsius). Commands: JOINT/position, or JOINT/velocity with `command: velocity`; with `hand` tool/grip (1:
/// grasp, 0: open), tool/width (m), tool/homing (1: once). NaN leaves them as they are.
///
/// Configuring connects, reads and moves nothing. Activating recovers from an error, sets what the parameters
/// name, and starts a motion in which the robot stands still; the first command must be at the measured
/// position. Deactivating brakes the robot and ends the motion. When commands stop for any reason, the robot
/// ends the motion by itself.
class FrankaComponent : public wire::StreamComponent<Link, Cause, 7> {
 public:
  static constexpr std::size_t kStates = 4;  ///< of each joint, the position first
  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;
  const std::vector<std::string>& joint_names() const { return joints_; }

 protected:
  bool stepped_link_ = false;  ///< the robot's clock waits for answers
  bool has_hand() const { return settings_.hand.used; }

 private:
  void read_robot_settings(hardware::DriverParameters& p);
  void read_hand(hardware::DriverParameters& p, const hardware::RobotInstance& robot);
  void find_limits(const hardware::RobotInstance& robot, double max_speed);
  hardware::ReturnType write_velocities(std::span<const double> commands) noexcept;

  LinkSettings settings_;
  std::string robot_;
  std::vector<std::string> joints_;
};

}  // namespace polyarm::franka
