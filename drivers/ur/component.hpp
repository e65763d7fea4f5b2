#pragma once
/// A robot of Universal Robots (CB3 from 3.5, e-Series, PolyScope X) over the controller's own interfaces.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "drivers/ur/arm_kinematics.hpp"
#include "drivers/ur/link.hpp"
#include "drivers/wire/forward_watch.hpp"
#include "drivers/wire/six_axes.hpp"
#include "polyarm/hardware/component.hpp"
#include "polyarm/hardware/forward_moves.hpp"

namespace polyarm::ur {

/// States: JOINT/position (rad), velocity (rad/s), current (A), effort (N·m, NaN before software 5.23);
/// tcp_pose/position.x … orientation.w in the controller's base; tcp_wrench/force.x … torque.z (N, N·m) in
/// the axes of the controller's TCP, as programs want them that yield to forces; controller/robot_mode,
/// safety_mode, program_state, speed_scaling, speed_slider, payload (kg), lost_packages, command_age
/// (commands that the robot has not taken yet); io/digital_in_N, digital_out_N (N: 0 to 7 standard, 8 to 15
/// configurable, 16 and 17 tool), analog_in_N, analog_out_N. Commands: JOINT/position or JOINT/velocity;
/// controller/speed_slider (0 to 1); io/digital_out_N, io/analog_out_N (share of 10 V). NaN leaves an output
/// as it is.
///
/// Configuring connects, reads and moves nothing. Activating sends the program; the robot stands still until
/// commands come, and the first one must be at the measured position. Deactivating ends the program: the
/// robot stops and holds. When commands stop for any reason, the program on the robot stops the robot.
///
/// In forward mode the commands of joints are not sent: moves come over ForwardMoves. The driver has the
/// speed slider to itself then.
class UrComponent : public hardware::Component, public hardware::TakesMoves {
 public:
  static constexpr std::size_t kStates = 4;  ///< of each joint, the position first

  hardware::CallbackReturn on_init(const hardware::ComponentContext& context) override;
  hardware::CallbackReturn on_configure() override;
  hardware::CallbackReturn on_activate() override;
  hardware::CallbackReturn on_deactivate() override;
  hardware::CallbackReturn on_cleanup() override;
  hardware::CallbackReturn on_shutdown() override;
  hardware::CallbackReturn on_error() override;
  std::vector<hardware::InterfaceDescription> state_interfaces() const override;
  std::vector<hardware::InterfaceDescription> command_interfaces() const override;
  hardware::ReturnType prepare_command_mode_switch(std::span<const std::string> start,
                                                   std::span<const std::string> stop) override;
  hardware::ReturnType perform_command_mode_switch(std::span<const std::string> start,
                                                   std::span<const std::string> stop) noexcept override;
  hardware::ReturnType read(const hardware::Cycle& cycle, std::span<double> states) noexcept override;
  hardware::ReturnType write(const hardware::Cycle& cycle,
                             std::span<const double> commands) noexcept override;
  bool real() const noexcept override { return true; }
  bool paces() const noexcept override { return paced_; }
  bool await_cycle(Nanoseconds timeout) noexcept override { return link_ && link_->await(timeout); }
  std::string reason() const override;
  hardware::ForwardMoves* forward_moves(std::uint32_t layout) noexcept override;
  const hardware::DriverFacts* facts() const noexcept override;
  std::string summary() const override;

  /// Why it failed last; none after configuring. Any thread.
  Cause cause() const noexcept {
    return !link_ ? Cause::none : link_->cause() != Cause::none ? link_->cause() : link_->refused();
  }

 protected:
  LinkSettings& settings() noexcept { return settings_; }
  Link* link() noexcept { return link_.get(); }
  std::int32_t last_command() const noexcept { return last_command_; }
  const std::vector<std::string>& joint_names() const { return joints_; }
  bool paced_ = true;

 private:
  void find_joints(const hardware::ComponentContext& context, Problems& problems);
  void make_forward(const hardware::ComponentContext& context, hardware::DriverParameters& p);
  hardware::ReturnType write_moves(std::span<const double> commands, const wire::Six& measured) noexcept;
  void write_outputs(std::span<const double> commands) noexcept;

  LinkSettings settings_;
  std::string name_, robot_;
  std::vector<std::string> joints_;
  std::vector<double> velocity_limits_;
  std::vector<JointLine> described_;  ///< the six joints of the description; empty: unknown
  bool positions_ = true, velocities_ = false;
  Nanoseconds period_ = 2'000'000;
  std::unique_ptr<Link> link_;
  std::atomic<Mode> mode_{Mode::position};
  // the control thread's
  bool active_ = false;
  wire::StepCheck steps_;
  wire::ForwardWatch watch_;
  Outputs outputs_, written_;
  std::int32_t last_command_ = 0;
};

}  // namespace polyarm::ur
