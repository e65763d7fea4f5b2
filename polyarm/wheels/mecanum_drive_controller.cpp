#include "polyarm/wheels/mecanum_drive_controller.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::controllers {

namespace {
constexpr const char* kWheels[] = {"front_left", "front_right", "rear_right", "rear_left"};
}

MecanumDriveController::MecanumDriveController()
    : BaseController({.port = "reference",
                      .timeout_key = "reference_timeout",
                      .timeout = 0,
                      .zero_timeout_is_once = true,
                      .lateral = true,
                      .has_window = false,
                      .has_position_feedback = false,
                      .has_open_loop = false,
                      .odometry = "odometry",
                      .transforms = "tf_odometry",
                      .covariance = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1}}) {}

void MecanumDriveController::read_wheels(ControllerContext& context) {
  Parameters& p = context.parameters;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string key = std::string(kWheels[i]) + "_wheel_command_joint_name",
                      state_key = std::string(kWheels[i]) + "_wheel_state_joint_name";
    std::string name, state_name;
    p.read(key, name, {"the joint of this wheel"});
    p.read(state_key, state_name, {"where the wheel is measured, if elsewhere"});
    if (name.empty()) {
      p.problems().error("bad-value", place_in_file(p, key), "'" + key + "' is missing",
                         "name the joint of the wheel");
      continue;
    }
    command_[i] = claim_wheel(context, name, "velocity", key);
    if (state_name.empty()) state_name = name;
    state_[i] = claim_state(whole_wheel(context, state_name, "velocity", state_key) + "/velocity");
  }
}

void MecanumDriveController::read_kinematics(Parameters& p) {
  double theta = 0;
  radius_ = reach_ = offset_x_ = offset_y_ = 0;
  const std::string reach = "kinematics.sum_of_robot_center_projection_on_X_Y_axis";
  p.read("kinematics.wheels_radius", radius_, {"m, radius of a wheel"});
  p.read(reach, reach_, {"m, distance of a wheel from the centre along x plus along y"});
  p.read("kinematics.base_frame_offset.x", offset_x_, {"m, the base's frame in that of the wheels' centre"});
  p.read("kinematics.base_frame_offset.y", offset_y_, {"m"});
  p.read("kinematics.base_frame_offset.theta", theta, {"rad"});
  require_size(p, "kinematics.wheels_radius", radius_);
  require_size(p, reach, reach_);
  for (const double value : {offset_x_, offset_y_, theta})
    if (!std::isfinite(value))
      p.problems().error("bad-value", place_in_file(p, "kinematics.base_frame_offset.x"),
                         "kinematics.base_frame_offset is not finite");
  offset_cos_ = std::cos(theta);
  offset_sin_ = std::sin(theta);
}

CallbackReturn MecanumDriveController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  p.superseded("use_stamped_vel", "twists with and without stamp are both understood");
  read_base(context);
  read_kinematics(p);
  collect(p.problems(), [&] { read_wheels(context); });
  announced_ = &add_output("controller_state", "control_msgs/MecanumDriveControllerState",
                      {"front_left_wheel_velocity", "front_right_wheel_velocity", "back_right_wheel_velocity",
                       "back_left_wheel_velocity", "reference_velocity.linear.x",
                       "reference_velocity.linear.y", "reference_velocity.angular.z"});
  announced_->texts["frame_id"] = odometry_output()->texts["frame_id"];
  odometry_.configure(window());
  return finish_base(p);
}

void MecanumDriveController::write(const PlanarTwist& limited,
                                   const std::optional<PlanarTwist>& wish) noexcept {
  asked_ = wish.value_or(PlanarTwist{NAN, NAN, NAN});
  const double turn = reach_ * limited.angular;
  const double x = offset_cos_ * limited.x - offset_sin_ * limited.y + offset_y_ * limited.angular;
  const double y = offset_sin_ * limited.x + offset_cos_ * limited.y - offset_x_ * limited.angular;
  const Wheels wheels{x - y - turn, x + y + turn, x - y + turn, x + y - turn};
  for (std::size_t i = 0; i < 4; ++i) set_command(command_[i], wheels[i] / radius_);
}

/// A wheel that is not measured now leaves the odometry as it is, as in ROS.
bool MecanumDriveController::track(const PlanarTwist&, double dt) noexcept {
  const Wheels w{state(state_[0]), state(state_[1]), state(state_[2]), state(state_[3])};
  const double share = radius_ / 4;
  const double turn = share / reach_ * (-w[0] + w[1] + w[2] - w[3]);
  const double x = share * (w[0] + w[1] + w[2] + w[3]) - offset_y_ * turn;
  const double y = share * (-w[0] + w[1] - w[2] + w[3]) + offset_x_ * turn;
  odometry_.update({offset_cos_ * x + offset_sin_ * y, -offset_sin_ * x + offset_cos_ * y, turn}, dt);
  return true;
}

void MecanumDriveController::publish_more(const Cycle& cycle) noexcept {
  const double values[] = {state(state_[0]), state(state_[1]), state(state_[2]), state(state_[3]),
                           asked_.x,         asked_.y,         asked_.angular};
  std::copy(std::begin(values), std::end(values), announced_->draft().values.begin());
  announced_->publish(cycle.time);
}

}  // namespace polyarm::controllers
