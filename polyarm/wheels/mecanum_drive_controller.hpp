#pragma once
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::controllers {

/// Drives a base with four mecanum wheels, as ros2_control's MecanumDriveController does. Inputs: `reference`
/// and `cmd_vel`. Outputs: `odometry`, `tf_odometry`, `controller_state`
/// (control_msgs/MecanumDriveControllerState), `cmd_vel_out`. Wheels are in the order front left, front
/// right, rear right, rear left; their rollers form an X seen from above.
class MecanumDriveController : public BaseController {
 public:
  MecanumDriveController();
  CallbackReturn on_configure(ControllerContext& context) override;
  const PlanarOdometry& odometry() const noexcept override { return odometry_; }

 private:
  using Wheels = std::array<double, 4>;
  void read_wheels(ControllerContext& context);
  void read_kinematics(Parameters& p);
  void write(const PlanarTwist& limited, const std::optional<PlanarTwist>& wish) noexcept override;
  bool track(const PlanarTwist& commanded, double dt) noexcept override;
  PlanarOdometry& place() noexcept override { return odometry_; }
  void publish_more(const Cycle& cycle) noexcept override;

  std::array<std::size_t, 4> command_{}, state_{};
  double radius_ = 1, reach_ = 1;  // m; reach: sum of the distances of a wheel from the centre along x and y
  double offset_x_ = 0, offset_y_ = 0, offset_cos_ = 1,
         offset_sin_ = 0;  // of the base's frame in the centre's
  PlanarTwist asked_;
  PlanarOdometry odometry_;
  Output* announced_ = nullptr;
};

}  // namespace polyarm::controllers
