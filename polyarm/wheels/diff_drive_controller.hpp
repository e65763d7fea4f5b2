#pragma once
#include "polyarm/wheels/base_controller.hpp"

namespace polyarm::controllers {

/// Drives a base with wheels on two sides, as ros2_control's DiffDriveController does. Outputs: `odom`, `tf`,
/// `cmd_vel_out`.
class DiffDriveController : public BaseController {
 public:
  DiffDriveController();
  CallbackReturn on_configure(ControllerContext& context) override;
  const Odometry& odometry() const noexcept override { return odometry_; }  ///< control thread

 private:
  void read_wheels(ControllerContext& context);
  void read_size(Parameters& p);
  void write(const PlanarTwist& limited, const std::optional<PlanarTwist>& wish) noexcept override;
  bool track(const PlanarTwist& commanded, double dt) noexcept override;
  PlanarOdometry& place() noexcept override { return odometry_; }
  void begin() noexcept override;
  double mean_feedback(const std::vector<std::size_t>& side) const noexcept;

  std::vector<std::size_t> left_, right_;                    // commands
  std::vector<std::size_t> left_feedback_, right_feedback_;  // states
  double separation_ = 1, left_radius_ = 1, right_radius_ = 1;
  Odometry odometry_;
};

}  // namespace polyarm::controllers
