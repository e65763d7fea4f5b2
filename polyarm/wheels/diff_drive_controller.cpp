#include "polyarm/wheels/diff_drive_controller.hpp"

#include <cmath>

namespace polyarm::controllers {

DiffDriveController::DiffDriveController()
    : BaseController({.nan_stops = false, .position_feedback = true}) {}

void DiffDriveController::begin() noexcept {
  if (!open_loop() && position_feedback())
    odometry_.start(mean_feedback(left_feedback_), mean_feedback(right_feedback_));
}

void DiffDriveController::write(const PlanarTwist& limited, const std::optional<PlanarTwist>&) noexcept {
  const double turning = limited.angular * separation_ / 2;
  for (const std::size_t wheel : left_) set_command(wheel, (limited.x - turning) / left_radius_);
  for (const std::size_t wheel : right_) set_command(wheel, (limited.x + turning) / right_radius_);
}

double DiffDriveController::mean_feedback(const std::vector<std::size_t>& side) const noexcept {
  double sum = 0;
  for (const std::size_t wheel : side) sum += state(wheel);
  return sum / static_cast<double>(side.size());
}

bool DiffDriveController::track(const PlanarTwist& commanded, double dt) noexcept {
  if (open_loop()) {
    odometry_.update_open_loop(commanded.x, commanded.angular, dt);
    return true;
  }
  const double left = mean_feedback(left_feedback_), right = mean_feedback(right_feedback_);
  if (!std::isfinite(left) || !std::isfinite(right)) return false;
  if (position_feedback())
    odometry_.update_from_positions(left, right, dt);
  else
    odometry_.update_from_velocities(left, right, dt);
  return true;
}

}  // namespace polyarm::controllers
