#pragma once
#include <cmath>

#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::controllers {

/// Follows an angle (rad) within limits of position, velocity and acceleration; NaN: no limit. It brakes in
/// time, so that it does not overshoot. Real-time.
class AngleLimiter {
 public:
  struct Limits {
    double min_position = NAN, max_position = NAN;  ///< rad
    double max_velocity = NAN;                      ///< rad/s
    double max_acceleration = NAN;                  ///< rad/s²
  };
  void set(const Limits& limits) noexcept { limits_ = limits; }
  void reset(double angle) noexcept { angle_ = angle, velocity_ = 0; }
  double next(double wanted, double dt) noexcept;
  double angle() const noexcept { return angle_; }

 private:
  Limits limits_;
  double angle_ = 0, velocity_ = 0;
};

/// Drives a base whose one front wheel both steers and drives, as ros2_control's older TricycleController
/// does. Input: `cmd_vel`. Outputs: `odom`, `tf`, `cmd_ackermann` (speed in rad/s of the wheel, as in ROS).
class TricycleController : public BaseController {
 public:
  TricycleController();
  CallbackReturn on_configure(ControllerContext& context) override;
  bool turns_on_the_spot() const override { return false; }
  double sharpest() const noexcept override { return sharpest_; }
  SpeedLimits linear_limits() const noexcept override;
  double share_on(double curvature) const noexcept override {
    return 1 / std::hypot(1, wheelbase_ * curvature);
  }
  const PlanarOdometry& odometry() const noexcept override { return odometry_; }

 private:
  struct Drive {
    double angle = 0, wheel = 0;  // rad, rad/s
  };
  void read_limits(Parameters& p);
  void read_joints(ControllerContext& context);
  Drive drive_for(const PlanarTwist& twist) const noexcept;
  void write(const PlanarTwist& limited, const std::optional<PlanarTwist>& wish) noexcept override;
  bool track(const PlanarTwist& commanded, double dt) noexcept override;
  PlanarOdometry& place() noexcept override { return odometry_; }
  void begin() noexcept override;
  bool wheels_at_rest() const noexcept override { return wheel_.speed() == 0; }
  void publish_more(const Cycle& cycle) noexcept override;

  std::size_t traction_ = 0, steering_ = 0, traction_state_ = 0, steering_state_ = 0;
  double wheelbase_ = 1, radius_ = 1;  // m
  double sharpest_ = 0;                // 1/m
  bool report_drive_ = false;
  SpeedLimits traction_limits_;
  AngleLimiter::Limits steering_limits_;
  PlanarOdometry odometry_;
  Output* drive_ = nullptr;
  // control thread
  SpeedLimiter wheel_;
  AngleLimiter angle_;
  double target_ = 0;       // rad
  bool commanded_ = false;  // since activation
  bool holds_ = false;
};

}  // namespace polyarm::controllers
