#pragma once
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::controllers {

/// Drives a base with three or more omni wheels at equal angles, as ros2_control's OmniWheelDriveController
/// does. Input: `cmd_vel`. Outputs: `odom`, `tf`, `cmd_vel_out`. Wheels are named counter-clockwise, the
/// first at `wheel_offset` from the x axis; a positive velocity turns the base clockwise.
class OmniWheelDriveController : public BaseController {
 public:
  OmniWheelDriveController();
  CallbackReturn on_configure(ControllerContext& context) override;
  const PlanarOdometry& odometry() const noexcept override { return odometry_; }

 private:
  struct Wheel {
    double sin = 0, cos = 1;  // of its angle around the robot
    double position = 0;      // rad, at the last update
    std::size_t command = 0, state = 0;
  };
  void read_size(Parameters& p);
  void read_wheels(ControllerContext& context);
  void write(const PlanarTwist& limited, const std::optional<PlanarTwist>& wish) noexcept override;
  bool track(const PlanarTwist& commanded, double dt) noexcept override;
  PlanarOdometry& place() noexcept override { return odometry_; }
  void begin() noexcept override;

  std::vector<Wheel> wheels_;
  double robot_radius_ = 1, wheel_radius_ = 1, first_angle_ = 0;  // m, m, rad
  PlanarOdometry odometry_;
};

}  // namespace polyarm::controllers
