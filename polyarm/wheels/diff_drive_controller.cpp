#include "polyarm/wheels/diff_drive_controller.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::controllers {

namespace {

constexpr const char* kTwist = "geometry_msgs/Twist";
constexpr const char* kTwistStamped = "geometry_msgs/TwistStamped";
constexpr std::size_t kOdometryPlain = 13;  // fields before the covariances
constexpr double kFastest = 1e9;            // beyond this it is no speed but a mistake

bool is_speed(double value) noexcept {
  return std::abs(value) <= kFastest;
}

/// x, y, heading out of a message with three values, or with names.
std::array<double, 3> place_of(const Input& message) {
  std::array<double, 3> out{};
  if (const auto* numbers = std::get_if<Numbers>(&message)) {
    if (numbers->values.size() != 3)
      throw Error("wrong-size", "set_odometry takes three values: x, y (m) and heading (rad)");
    std::copy(numbers->values.begin(), numbers->values.end(), out.begin());
    return out;
  }
  const auto* named = std::get_if<NamedValues>(&message);
  if (!named || named->names.size() != named->values.size())
    throw Error("wrong-message", "set_odometry takes x, y (m) and yaw (rad)");
  for (std::size_t i = 0; i < named->names.size(); ++i) {
    const std::string& name = named->names[i];
    const int at = name == "x" ? 0 : name == "y" ? 1 : name == "yaw" || name == "heading" ? 2 : -1;
    if (at < 0) throw Error("wrong-message", "set_odometry knows no '" + name + "'", "it has x, y and yaw");
    out[static_cast<std::size_t>(at)] = named->values[i];
  }
  return out;
}

}  // namespace

std::vector<InputPort> DiffDriveController::inputs() const {
  return {{"cmd_vel", {kTwistStamped, kTwist}},
          {"cmd_vel_unstamped", {kTwist}},
          {"set_odometry", {"control_msgs/SetOdometry", "std_msgs/Float64MultiArray"}}};
}

std::uint64_t DiffDriveController::receive(const std::string& port, const Input& message, bool goal) {
  if (port == "set_odometry") {
    const auto [x, y, heading] = place_of(message);
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(heading))
      throw Error("not-a-number", "set_odometry was given a value that is not finite; it is ignored");
    place_inbox_.write({x, y, heading});
    return 0;
  }
  if (port != "cmd_vel" && port != "cmd_vel_unstamped") return Controller::receive(port, message, goal);
  const auto* twist = std::get_if<Twist>(&message);
  if (!twist)
    throw Error("wrong-message",
                std::string("cmd_vel takes a twist (") + kTwistStamped + " or " + kTwist + ")");
  if (!is_speed(twist->linear.x) || !is_speed(twist->angular.z))
    throw Error("not-a-number", "the twist has a value that is no speed; it is ignored",
                "the command before it holds until it times out");
  const bool stamped = twist->stamp && *twist->stamp != 0;  // a stamp of zero means: now
  commands_inbox_.write(
      {{twist->linear.x, twist->angular.z}, stamped ? twist->stamp : std::optional<Nanoseconds>{}});
  return 0;
}

void DiffDriveController::on_parameters_changed() noexcept {
  linear_.set(linear_limits_);
  angular_.set(angular_limits_);
}

void DiffDriveController::forget() noexcept {
  command_watch().forget();
  command_ = {};
  if (!chained()) {
    set_reference(0, 0);
    set_reference(1, 0);
  }
  reference_ = {reference(0), reference(1)};
  reference_old_ = true;
}

CallbackReturn DiffDriveController::on_activate(const Cycle&) noexcept {
  commands_inbox_.fetch();  // what was sent while it was not active is forgotten
  place_inbox_.fetch();
  on_parameters_changed();
  linear_.reset();
  angular_.reset();
  set_reference(0, 0);
  set_reference(1, 0);
  forget();
  if (!open_loop_ && position_feedback_)
    odometry_.start(mean_feedback(left_feedback_), mean_feedback(right_feedback_));
  drive({}, true, 0);
  return CallbackReturn::success;
}

void DiffDriveController::on_deactivate(const Cycle&) noexcept {
  forget();
  drive({}, true, 0);
}

void DiffDriveController::take_command(const Cycle& cycle) noexcept {
  if (!commands_inbox_.fetch()) return;
  const Command& sent = commands_inbox_.value();
  const Nanoseconds stamp = std::min(sent.stamp.value_or(cycle.time), cycle.time);
  if (command_watch().take(stamp, cycle.time)) command_ = sent.speeds;
}

/// What another controller wrote; what is no speed leaves the last as it is.
DiffDriveController::Speeds DiffDriveController::referenced() noexcept {
  const Speeds now{reference(0), reference(1)};
  if (is_speed(now.linear) && is_speed(now.angular) && now != reference_) {
    reference_ = now;
    reference_old_ = false;
  }
  return reference_old_ ? Speeds{} : reference_;
}

DiffDriveController::Speeds DiffDriveController::wanted(const Cycle& cycle, const Verdict& verdict) noexcept {
  take_command(cycle);
  if (verdict.speed <= 0 || verdict.immediate || verdict.discard) {
    forget();
    return {};
  }
  Speeds out;
  if (chained()) {
    command_watch().forget();
    out = referenced();
  } else {
    command_watch().expires(cycle.time, command_ != Speeds{});
    if (command_watch().counts()) out = command_;
    set_reference(0, out.linear);
    set_reference(1, out.angular);
    reference_ = out;  // a controller that is put before this one begins with its own first value
    reference_old_ = true;
  }
  const double share = std::min(verdict.speed, 1.0);
  return {out.linear * share, out.angular * share};
}

void DiffDriveController::drive(const Speeds& wanted, bool at_once, double dt) noexcept {
  if (at_once) {
    linear_.reset();
    angular_.reset();
  } else {
    linear_.next(wanted.linear, dt);
    angular_.next(wanted.angular, dt);
  }
  const double forwards = linear_.speed(), turning = angular_.speed() * separation_ / 2;
  for (const std::size_t wheel : left_) set_command(wheel, (forwards - turning) / left_radius_);
  for (const std::size_t wheel : right_) set_command(wheel, (forwards + turning) / right_radius_);
  standing_.store(linear_.speed() == 0 && angular_.speed() == 0, std::memory_order_relaxed);
}

double DiffDriveController::mean_feedback(const std::vector<std::size_t>& side) const noexcept {
  double sum = 0;
  for (const std::size_t wheel : side) sum += state(wheel);
  return sum / static_cast<double>(side.size());
}

bool DiffDriveController::track(double dt) noexcept {
  if (open_loop_) {
    odometry_.update_open_loop(linear_.speed(), angular_.speed(), dt);
  } else {
    const double left = mean_feedback(left_feedback_), right = mean_feedback(right_feedback_);
    if (!std::isfinite(left) || !std::isfinite(right)) return false;
    if (position_feedback_)
      odometry_.update_from_positions(left, right, dt);
    else
      odometry_.update_from_velocities(left, right, dt);
  }
  if (place_inbox_.fetch()) {
    const Place& place = place_inbox_.value();
    odometry_.set_pose(place.x, place.y, place.heading);
  }
  return true;
}

ReturnType DiffDriveController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  const double dt = seconds(cycle.period);
  drive(wanted(cycle, verdict), verdict.immediate, dt);
  if (!track(dt)) return ReturnType::error;
  publish(cycle);
  return ReturnType::ok;
}

void DiffDriveController::publish(const Cycle& cycle) noexcept {
  const double z = std::sin(odometry_.heading() / 2), w = std::cos(odometry_.heading() / 2);
  std::vector<double>& odom = odom_->draft().values;
  const double plain[kOdometryPlain] = {
      odometry_.x(), odometry_.y(), 0, 0, 0, z, w, odometry_.linear(), 0, 0, 0, 0, odometry_.angular()};
  std::copy(std::begin(plain), std::end(plain), odom.begin());
  std::copy(pose_covariance_.begin(), pose_covariance_.end(), odom.begin() + kOdometryPlain);
  std::copy(twist_covariance_.begin(), twist_covariance_.end(), odom.begin() + kOdometryPlain + 6);
  odom_->publish(cycle.time);
  if (tell_tf_) {
    const double transform[] = {odometry_.x(), odometry_.y(), 0, 0, 0, z, w};
    std::copy(std::begin(transform), std::end(transform), tf_->draft().values.begin());
    tf_->publish(cycle.time);
  }
  if (tell_limited_) {
    const double twist[] = {linear_.speed(), 0, 0, 0, 0, angular_.speed()};
    std::copy(std::begin(twist), std::end(twist), limited_->draft().values.begin());
    limited_->publish(cycle.time);
  }
}

}  // namespace polyarm::controllers
