#include "polyarm/wheels/tricycle_controller.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "polyarm/wheels/steering_kinematics.hpp"

namespace polyarm::controllers {

namespace {
constexpr double kQuarter = std::numbers::pi / 2, kSlowerFrom = std::numbers::pi / 6;  // rad
constexpr double kCreep = 0.01;

/// Share of the wheel's speed while the steering is `error` away from its angle.
double share_for(double error) noexcept {
  const double off = std::abs(error);
  if (!(off >= kSlowerFrom)) return 1;
  return off > kQuarter ? kCreep : std::cos(off);
}
}  // namespace

double AngleLimiter::next(double wanted, double dt) noexcept {
  if (std::isnan(wanted) || !(dt > 0)) return angle_;
  if (!std::isnan(limits_.max_position))
    wanted = std::clamp(wanted, limits_.min_position, limits_.max_position);
  const double left = wanted - angle_;
  double velocity = left / dt;
  if (!std::isnan(limits_.max_velocity))
    velocity = std::clamp(velocity, -limits_.max_velocity, limits_.max_velocity);
  if (const double a = limits_.max_acceleration; !std::isnan(a)) {
    // The speed from which it can still brake: what it moves in this update and while braking is `left`.
    const double step = a * dt;
    const double most = std::max(0.0, std::sqrt(step * step / 4 + 2 * a * std::abs(left)) - step / 2);
    velocity = std::clamp(std::clamp(velocity, -most, most), velocity_ - step, velocity_ + step);
  }
  velocity_ = velocity;
  return angle_ += velocity * dt;
}

TricycleController::TricycleController()
    : BaseController({.milliseconds = true,
                      .chains = false,
                      .limits_speed = false,
                      .limits_turning = false,
                      .has_position_feedback = false,
                      .transform = false}) {}

void TricycleController::read_limits(Parameters& p) {
  const auto read = [&](const std::string& key, double& value, const char* text) {
    p.read(key, value, {.text = text, .least = 0});
  };
  traction_limits_ = {};
  double deceleration = NAN;
  read("traction.max_velocity", traction_limits_.max_velocity, "rad/s of the wheel; .nan: no limit");
  read("traction.max_acceleration", traction_limits_.max_acceleration, "rad/s²; .nan: no limit");
  read("traction.max_deceleration", deceleration, "rad/s²; .nan: max_acceleration");
  read("traction.max_jerk", traction_limits_.max_jerk, "rad/s³, while getting faster; .nan: no limit");
  if (deceleration > 0) traction_limits_.max_deceleration = -deceleration;
  steering_limits_ = {};
  p.read("steering.max_position", steering_limits_.max_position, {"rad; .nan: no limit, or -min_position"});
  p.read("steering.min_position", steering_limits_.min_position, {"rad; .nan: -max_position"});
  read("steering.max_velocity", steering_limits_.max_velocity, "rad/s; .nan: no limit");
  read("steering.max_acceleration", steering_limits_.max_acceleration, "rad/s²; .nan: no limit");
  double& low = steering_limits_.min_position;
  double& high = steering_limits_.max_position;
  if (std::isnan(low)) low = -high;
  if (std::isnan(high)) high = -low;
  if (low > high)
    p.problems().error("bad-value", place_in_file(p, "steering.min_position"),
                       "steering.min_position is above steering.max_position");
  for (const char* key : {"traction.min_velocity", "traction.min_acceleration", "traction.min_deceleration",
                          "traction.min_jerk", "steering.min_velocity", "steering.min_acceleration"})
    p.superseded(key, "it may always be slower");
}

void TricycleController::read_joints(ControllerContext& context) {
  Parameters& p = context.parameters;
  std::string traction, steering;
  p.read("traction_joint_name", traction, {"the joint of the wheel"});
  p.read("steering_joint_name", steering, {"the joint that steers it"});
  for (const auto& [key, name] :
       {std::pair{"traction_joint_name", &traction}, {"steering_joint_name", &steering}})
    if (name->empty())
      p.problems().error("bad-value", place_in_file(p, key), std::string("'") + key + "' is missing",
                         "name the joint");
  if (p.problems().has_errors()) return;
  traction_ = claim_wheel(context, traction, "velocity", "traction_joint_name");
  steering_ = claim_wheel(context, steering, "position", "steering_joint_name");
  traction_state_ =
      claim_state(whole_wheel(context, traction, "velocity", "traction_joint_name") + "/velocity");
  steering_state_ =
      claim_state(whole_wheel(context, steering, "position", "steering_joint_name") + "/position");
  double limit = steering_limit(context, {steering});
  if (!std::isnan(steering_limits_.max_position))
    limit = std::min({limit, steering_limits_.max_position, -steering_limits_.min_position});
  const SteeringGeometry geometry{.kind = SteeringGeometry::Kind::bicycle, .wheelbase = wheelbase_};
  sharpest_ = sharpest_curvature(geometry, limit);
}

CallbackReturn TricycleController::on_configure(ControllerContext& context) {
  Parameters& p = context.parameters;
  p.superseded("publish_rate", "odometry is published every update");
  p.superseded("use_stamped_vel", "twists with and without stamp are both understood");
  read_base(context);
  bool only_twist = false;
  p.read("odom_only_twist", only_twist, {"publish a velocity and no pose as odom"});
  set_publishes_pose(!only_twist);
  p.read("publish_ackermann_command", report_drive_ = false, {"publish the limited command as cmd_ackermann"});
  wheelbase_ = radius_ = 0;
  p.read("wheelbase", wheelbase_, {"m from the rear axle to the front wheel"});
  p.read("wheel_radius", radius_, {"m, radius of the front wheel"});
  require_size(p, "wheelbase", wheelbase_);
  require_size(p, "wheel_radius", radius_);
  read_limits(p);
  collect(p.problems(), [&] { read_joints(context); });
  drive_ = &add_output("cmd_ackermann", "ackermann_msgs/AckermannDrive", {"steering_angle", "speed"});
  odometry_.configure(window());
  wheel_.set(traction_limits_);
  angle_.set(steering_limits_);
  return finish_base(p);
}

/// Of the base on a straight line, from those of its wheel.
SpeedLimits TricycleController::linear_limits() const noexcept {
  SpeedLimits out;
  out.max_velocity = traction_limits_.max_velocity * radius_;
  out.max_acceleration = traction_limits_.max_acceleration * radius_;
  out.max_deceleration = traction_limits_.max_deceleration * radius_;
  out.max_jerk = traction_limits_.max_jerk * radius_;
  return out;
}

void TricycleController::begin() noexcept {
  commanded_ = holds_ = false;
  wheel_.reset();
  const double last = command(steering_), now = state(steering_state_);
  target_ = std::isfinite(last) ? last : std::isfinite(now) ? now : 0;
  angle_.reset(target_);
  set_command(steering_, target_);
}

/// The wheel's angle and velocity for a twist. Without speed, a turn has the wheel across.
TricycleController::Drive TricycleController::drive_for(const PlanarTwist& twist) const noexcept {
  if (twist.x == 0 && twist.angular != 0)
    return {std::copysign(kQuarter, twist.angular), std::abs(twist.angular) * wheelbase_ / radius_};
  const double angle = twist.angular == 0 ? 0 : std::atan(twist.angular * wheelbase_ / twist.x);
  return {angle, twist.x / (radius_ * std::cos(angle))};
}

void TricycleController::write(const PlanarTwist&, const std::optional<PlanarTwist>& wish) noexcept {
  const double measured = state(steering_state_);
  Drive wanted;
  if (wish) {
    wanted = drive_for(*wish);
    commanded_ = true, holds_ = false;
    target_ = wanted.angle;
  } else if (stopped()) {
    if (!std::exchange(holds_, true) && std::isfinite(measured)) angle_.reset(target_ = measured);
  } else if (commanded_) {
    target_ = 0;  // after a time-out it steers straight, as in ROS
  }
  if (at_once())
    wheel_.reset();
  else
    wheel_.next(wanted.wheel * share_for(target_ - measured), step());
  if (step() > 0) angle_.next(target_, step());
  set_command(traction_, wheel_.speed());
  set_command(steering_, angle_.angle());
}

bool TricycleController::track(const PlanarTwist& commanded, double dt) noexcept {
  if (open_loop()) {
    odometry_.update_open_loop(commanded, dt);
    return true;
  }
  const double speed = state(traction_state_) * radius_, angle = state(steering_state_);
  if (!std::isfinite(speed) || !std::isfinite(angle)) return false;
  odometry_.update({speed * std::cos(angle), 0, speed * std::sin(angle) / wheelbase_}, dt);
  return true;
}

void TricycleController::publish_more(const Cycle& cycle) noexcept {
  const double measured = state(steering_state_);
  set_curvature(std::tan(std::isfinite(measured) ? measured : angle_.angle()) / wheelbase_);
  if (!report_drive_) return;
  drive_->draft().values[0] = angle_.angle();
  drive_->draft().values[1] = wheel_.speed();
  drive_->publish(cycle.time);
}

}  // namespace polyarm::controllers
