#include "polyarm/wheels/steering_controllers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::controllers {

namespace {
bool is_measured(const RightLeft& values) noexcept {
  return std::isfinite(values[0]) && std::isfinite(values[1]);
}

/// Humble's and Jazzy's names say front and rear, and which of them steers.
void accept_older_names(Parameters& p, bool bicycle) {
  if (!p.has("front_wheels_names") && !p.has("rear_wheels_names")) return;
  const bool front_steers = p.boolean("front_steering", true);
  const std::string steering = front_steers ? "front" : "rear", traction = front_steers ? "rear" : "front";
  const std::string wheels = bicycle ? "_wheel" : "_wheels";
  rename_key(p, steering + "_wheels_names", {"steering_joints_names"});
  rename_key(p, traction + "_wheels_names", {"traction_joints_names"});
  rename_key(p, steering + "_wheels_state_names", {"steering_joints_state_names"});
  rename_key(p, traction + "_wheels_state_names", {"traction_joints_state_names"});
  rename_key(p, traction + wheels + "_radius",
             {bicycle ? "traction_wheel_radius" : "traction_wheels_radius"});
  rename_key(p, "wheel_track", {"traction_track_width"});
  rename_key(p, traction + "_wheel_track", {"traction_track_width"});
  rename_key(p, steering + "_wheel_track", {"steering_track_width"});
  p.superseded("front_steering", "steering_joints_names and traction_joints_names say which wheels steer");
  p.superseded(steering + wheels + "_radius", "the radius of steered wheels has no effect");
}
}  // namespace

SteeringController::SteeringController(SteeringGeometry::Kind kind)
    : BaseController({.port = "reference",
                      .timeout_key = "reference_timeout",
                      .timeout = 1,
                      .zero_timeout_is_once = true,
                      .limits_turning = false,
                      .odometry = "odometry",
                      .transforms = "tf_odometry",
                      .covariance = {0, 7, 14, 21, 28, 35}}) {
  geometry_.kind = kind;
}

void SteeringController::read_geometry(Parameters& p) {
  const bool bicycle = geometry_.kind == SteeringGeometry::Kind::bicycle;
  geometry_ = {geometry_.kind, 0, 0, 0, 0};
  const char* radius = bicycle ? "traction_wheel_radius" : "traction_wheels_radius";
  p.read("wheelbase", geometry_.wheelbase, {"m from the traction axle to the steering axle"});
  p.read(radius, geometry_.radius, {"m, radius of the traction wheels"});
  require_size(p, "wheelbase", geometry_.wheelbase);
  require_size(p, radius, geometry_.radius);
  if (bicycle) return;
  p.read("traction_track_width", geometry_.traction_track, {"m between the traction wheels"});
  require_size(p, "traction_track_width", geometry_.traction_track);
  if (geometry_.kind != SteeringGeometry::Kind::ackermann) return;
  p.read("steering_track_width", geometry_.steering_track,
         {.text = "m between the steering axes; 0: as the traction wheels", .least = 0, .most = 1e6});
  if (geometry_.steering_track == 0) geometry_.steering_track = geometry_.traction_track;
}

std::vector<std::string> SteeringController::read_names(Parameters& p, const std::string& key,
                                                        const char* text, std::size_t count,
                                                        const std::vector<std::string>& fallback) {
  std::vector<std::string> names;
  p.read(key, names, {text});
  if (names.empty()) names = fallback;
  if (names.size() != count)
    p.problems().error(
        "bad-value", place_in_file(p, key),
        "'" + key + "' has " + std::to_string(names.size()) + " joints, it needs " + std::to_string(count),
        count == 2 ? "name the right one, then the left one" : "name one joint");
  return names;
}

void SteeringController::claim_states(ControllerContext& context, const std::vector<std::string>& traction,
                                      const std::vector<std::string>& steering) {
  traction_state_.clear(), steering_state_.clear();
  const std::string feedback = position_feedback() ? "position" : "velocity";
  std::vector<std::string> wheels, joints;
  for (const std::string& name : traction)
    wheels.push_back(whole_wheel(context, name, feedback, "traction_joints_state_names") + "/" + feedback);
  for (const std::string& name : steering)
    joints.push_back(whole_wheel(context, name, "position", "steering_joints_state_names") + "/position");
  const auto known = [&](const std::string& name) { return context.has_state(name); };
  if (open_loop() &&
      !(std::all_of(wheels.begin(), wheels.end(), known) && std::all_of(joints.begin(), joints.end(), known)))
    return;
  for (const std::string& name : wheels) traction_state_.push_back(claim_state(name));
  for (const std::string& name : joints) steering_state_.push_back(claim_state(name));
}

void SteeringController::read_joints(ControllerContext& context) {
  Parameters& p = context.parameters;
  const std::size_t wheels = geometry_.traction_wheels(), joints = geometry_.steering_joints();
  const std::vector<std::string> traction =
      read_names(p, "traction_joints_names", "the joints of the traction wheels: right, left", wheels, {});
  const std::vector<std::string> steering =
      read_names(p, "steering_joints_names", "the steering joints: right, left", joints, {});
  const std::vector<std::string> traction_states = read_names(
      p, "traction_joints_state_names", "where the wheels are measured, if elsewhere", wheels, traction);
  const std::vector<std::string> steering_states = read_names(
      p, "steering_joints_state_names", "where the steering is measured, if elsewhere", joints, steering);
  if (p.problems().has_errors()) return;
  traction_.clear(), steering_.clear();
  for (const std::string& name : traction)
    traction_.push_back(claim_wheel(context, name, "velocity", "traction_joints_names"));
  for (const std::string& name : steering)
    steering_.push_back(claim_wheel(context, name, "position", "steering_joints_names"));
  claim_states(context, traction_states, steering_states);
  sharpest_ = sharpest_curvature(geometry_, steering_limit(context, steering));
}

double SteeringController::share_on(double curvature) const noexcept {
  const bool bicycle = geometry_.kind == SteeringGeometry::Kind::bicycle;
  const double outer = 1 + (bicycle ? 0 : geometry_.traction_track / 2 * std::abs(curvature));
  return 1 / std::max(std::hypot(1, geometry_.wheelbase * curvature), outer);
}

void SteeringController::make_state_output() {
  std::vector<std::string> fields;
  const auto add = [&](const std::string& name, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) fields.push_back(name + "[" + std::to_string(i) + "]");
  };
  add(position_feedback() ? "traction_wheels_position" : "traction_wheels_velocity", traction_state_.size());
  add("steer_positions", steering_state_.size());
  add("traction_command", traction_.size());
  add("steering_angle_command", steering_.size());
  state_ = &add_output("controller_state", "control_msgs/SteeringControllerStatus", std::move(fields));
  state_->texts["frame_id"] = odometry_output()->texts["frame_id"];
}

CallbackReturn SteeringController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  p.superseded("use_stamped_vel", "twists with and without stamp are both understood");
  accept_older_names(p, geometry_.kind == SteeringGeometry::Kind::bicycle);
  read_base(context);
  p.read("reduce_wheel_speed_until_steering_reached", slow_while_steering_ = false,
         {.text = "drive slower while the steering is more than 30 degrees off", .changeable = true});
  read_geometry(p);
  collect(p.problems(), [&] { read_joints(context); });
  make_state_output();
  odometry_.configure(window());
  return finish_base(p);
}

RightLeft SteeringController::read(const std::vector<std::size_t>& states) const noexcept {
  return {state(states.front()), state(states.back())};
}

double SteeringController::measured_angle() noexcept {
  if (!steering_state_.empty())
    if (const RightLeft joints = read(steering_state_); is_measured(joints))
      angle_ = middle_angle(geometry_, joints);
  return angle_;
}

/// The steering stops where it is, once.
void SteeringController::hold_steering() noexcept {
  if (holds_ || steering_state_.empty()) return;
  holds_ = true;
  for (std::size_t i = 0; i < steering_.size(); ++i)
    if (const double now = state(steering_state_[i]); std::isfinite(now)) set_command(steering_[i], now);
}

void SteeringController::begin() noexcept {
  holds_ = false;
  angle_ = 0;
  desired_angle_ = measured_angle();
  if (position_feedback() && !traction_state_.empty()) wheel_positions_ = read(traction_state_);
  for (std::size_t i = 0; i < steering_.size(); ++i) {
    if (std::isfinite(command(steering_[i]))) continue;
    const double now = steering_state_.empty() ? 0 : state(steering_state_[i]);
    set_command(steering_[i], std::isfinite(now) ? now : 0);
  }
}

void SteeringController::write(const PlanarTwist& limited, const std::optional<PlanarTwist>& wish) noexcept {
  const double measured = measured_angle();
  if (wish) {
    holds_ = false;
    desired_angle_ = steering_angle(geometry_, wish->x, wish->angular);
    const RightLeft joints = steering_joints(geometry_, desired_angle_);
    for (std::size_t i = 0; i < steering_.size(); ++i) set_command(steering_[i], joints[i]);
  } else if (stopped()) {
    hold_steering();
  }
  const double angle = open_loop() ? desired_angle_ : measured;
  double wheel = limited.x / geometry_.radius;
  if (slow_while_steering_ && !open_loop()) wheel *= share_while_steering(measured - desired_angle_);
  const RightLeft wheels = controllers::traction_wheels(geometry_, wheel, angle);
  for (std::size_t i = 0; i < traction_.size(); ++i) set_command(traction_[i], wheels[i]);
}

/// A wheel or a steering that is not measured now leaves the odometry as it is, as in ROS.
bool SteeringController::track(const PlanarTwist& commanded, double dt) noexcept {
  if (open_loop()) {
    odometry_.update_open_loop({commanded.x, 0, commanded.x * std::tan(desired_angle_) / geometry_.wheelbase},
                               dt);
    return true;
  }
  RightLeft wheels = read(traction_state_);
  if (!is_measured(wheels) || !is_measured(read(steering_state_))) return true;
  if (position_feedback()) {
    const RightLeft before = std::exchange(wheel_positions_, wheels);
    if (!is_measured(before)) return true;
    for (std::size_t i = 0; i < wheels.size(); ++i) wheels[i] = (wheels[i] - before[i]) / dt;
  }
  const double v = traction_speed(geometry_, wheels, angle_);
  odometry_.update({v, 0, v * std::tan(angle_) / geometry_.wheelbase}, dt);
  return true;
}

void SteeringController::publish_more(const Cycle& cycle) noexcept {
  auto out = state_->draft().values.begin();
  for (const std::size_t i : traction_state_) *out++ = state(i);
  for (const std::size_t i : steering_state_) *out++ = state(i);
  for (const std::size_t i : traction_) *out++ = command(i);
  for (const std::size_t i : steering_) *out++ = command(i);
  state_->publish(cycle.time);
  set_curvature(std::tan(steering_state_.empty() ? desired_angle_ : angle_) / geometry_.wheelbase);
}

}  // namespace polyarm::controllers
