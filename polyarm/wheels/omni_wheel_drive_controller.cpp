#include "polyarm/wheels/omni_wheel_drive_controller.hpp"

#include <cmath>
#include <numbers>

namespace polyarm::controllers {

OmniWheelDriveController::OmniWheelDriveController()
    : BaseController({.lateral = true,
                      .has_window = false,
                      .position_feedback = true,
                      .pose_covariance = "diagonal_covariance.pose",
                      .twist_covariance = "diagonal_covariance.twist"}) {}

void OmniWheelDriveController::read_size(Parameters& p) {
  robot_radius_ = wheel_radius_ = first_angle_ = 0;
  p.read("robot_radius", robot_radius_, {"m from the centre to a wheel"});
  p.read("wheel_radius", wheel_radius_, {"m, radius of a wheel"});
  p.read("wheel_offset", first_angle_, {"rad from the x axis to the first wheel"});
  require_size(p, "robot_radius", robot_radius_);
  require_size(p, "wheel_radius", wheel_radius_);
  if (!std::isfinite(first_angle_))
    p.problems().error("bad-value", place_in_file(p, "wheel_offset"), "wheel_offset is not finite");
}

void OmniWheelDriveController::read_wheels(ControllerContext& context) {
  Parameters& p = context.parameters;
  const std::string key = "wheel_names";
  std::vector<std::string> names;
  p.read(key, names, {"the joints of the wheels, counter-clockwise"});
  if (names.size() < 3)
    throw Error(Problem{"bad-value", place_in_file(p, key),
                        "there are " + std::to_string(names.size()) + " wheels; it needs at least three",
                        "name the joints in wheel_names, counter-clockwise"});
  wheels_.assign(names.size(), {});
  const std::string feedback = position_feedback() ? "/position" : "/velocity";
  for (std::size_t i = 0; i < names.size(); ++i) {
    Wheel& wheel = wheels_[i];
    const double angle =
        first_angle_ + 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(names.size());
    wheel.sin = std::sin(angle);
    wheel.cos = std::cos(angle);
    wheel.command = claim_wheel(context, names[i], "velocity", key);
    if (!open_loop()) wheel.state = claim_state(whole_wheel(context, names[i], "velocity", key) + feedback);
  }
}

CallbackReturn OmniWheelDriveController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  rename_key(p, "pose_covariance_diagonal", {"diagonal_covariance.pose"});
  rename_key(p, "twist_covariance_diagonal", {"diagonal_covariance.twist"});
  read_base(context);
  read_size(p);
  collect(p.problems(), [&] { read_wheels(context); });
  odometry_.configure(window());
  return finish_base(p);
}

void OmniWheelDriveController::begin() noexcept {
  if (open_loop()) return;
  for (Wheel& wheel : wheels_) wheel.position = state(wheel.state);
}

void OmniWheelDriveController::write(const PlanarTwist& limited, const std::optional<PlanarTwist>&) noexcept {
  const double turn = limited.angular * robot_radius_;
  for (const Wheel& wheel : wheels_)
    set_command(wheel.command, (wheel.sin * limited.x - wheel.cos * limited.y - turn) / wheel_radius_);
}

/// Least squares over all wheels, which has a closed form because they stand at equal angles.
bool OmniWheelDriveController::track(const PlanarTwist& commanded, double dt) noexcept {
  if (open_loop()) {
    odometry_.update_open_loop(commanded, dt);
    return true;
  }
  PlanarTwist sum;
  for (Wheel& wheel : wheels_) {
    double w = state(wheel.state);
    if (!std::isfinite(w)) return false;
    if (position_feedback()) {
      const double before = wheel.position;
      wheel.position = w;
      w = std::isfinite(before) ? (w - before) / dt : 0;
    }
    sum.x += wheel.sin * w;
    sum.y -= wheel.cos * w;
    sum.angular -= w;
  }
  const double share = wheel_radius_ / static_cast<double>(wheels_.size());
  odometry_.update({2 * share * sum.x, 2 * share * sum.y, share * sum.angular / robot_radius_}, dt);
  return true;
}

}  // namespace polyarm::controllers
