#pragma once
#include "polyarm/wheels/base_controller.hpp"
#include "polyarm/wheels/steering_kinematics.hpp"

namespace polyarm::controllers {

/// Drives a base that steers, as the controllers of ros2_control's steering_controllers_library do. Inputs:
/// `reference` and `cmd_vel`. Outputs: `odometry`, `tf_odometry`, `controller_state`
/// (control_msgs/SteeringControllerStatus), `cmd_vel_out`. Without a valid reference the wheels stop and the
/// steering stays.
class SteeringController : public BaseController {
 public:
  CallbackReturn on_configure(ControllerContext& context) override;
  bool turns_on_the_spot() const override { return false; }
  double sharpest() const noexcept override { return sharpest_; }
  double share_on(double curvature) const noexcept override;
  const PlanarOdometry& odometry() const noexcept override { return odometry_; }
  const SteeringGeometry& geometry() const noexcept { return geometry_; }

 protected:
  explicit SteeringController(SteeringGeometry::Kind kind);

 private:
  void read_geometry(Parameters& p);
  void read_joints(ControllerContext& context);
  std::vector<std::string> read_names(Parameters& p, const std::string& key, const char* text,
                                      std::size_t count, const std::vector<std::string>& fallback);
  void claim_states(ControllerContext& context, const std::vector<std::string>& traction,
                    const std::vector<std::string>& steering);
  void make_state_output();

  void write(const PlanarTwist& limited, const std::optional<PlanarTwist>& wish) noexcept override;
  bool track(const PlanarTwist& commanded, double dt) noexcept override;
  PlanarOdometry& place() noexcept override { return odometry_; }
  void begin() noexcept override;
  void publish_more(const Cycle& cycle) noexcept override;

  RightLeft read(const std::vector<std::size_t>& states) const noexcept;
  void hold_steering() noexcept;
  /// The measured angle of the middle; the last one if it is not measured now.
  double measured_angle() noexcept;

  SteeringGeometry geometry_;
  std::vector<std::size_t> traction_, steering_;              // commands
  std::vector<std::size_t> traction_state_, steering_state_;  // empty: not measured
  bool slow_while_steering_ = false;
  double sharpest_ = 0;  // 1/m
  PlanarOdometry odometry_;
  Output* state_ = nullptr;
  // control thread
  double desired_angle_ = 0, angle_ = 0;
  RightLeft wheel_positions_{};
  bool holds_ = false;
};

class BicycleSteeringController : public SteeringController {
 public:
  BicycleSteeringController() : SteeringController(SteeringGeometry::Kind::bicycle) {}
};
class TricycleSteeringController : public SteeringController {
 public:
  TricycleSteeringController() : SteeringController(SteeringGeometry::Kind::tricycle) {}
};
class AckermannSteeringController : public SteeringController {
 public:
  AckermannSteeringController() : SteeringController(SteeringGeometry::Kind::ackermann) {}
};

}  // namespace polyarm::controllers
