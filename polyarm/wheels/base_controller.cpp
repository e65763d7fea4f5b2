#include "polyarm/wheels/base_controller.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace polyarm::controllers {

namespace {

constexpr const char* kTwist = "geometry_msgs/Twist";
constexpr const char* kTwistStamped = "geometry_msgs/TwistStamped";
constexpr std::size_t kOdometryPlain = 13;   // fields before the covariances
constexpr double kFastest = 1e9;             // anything faster is a mistake
constexpr Nanoseconds kBrief = 500'000'000;  // of cmd_vel where the time-out says nothing
constexpr PlanarTwist kRest{};

bool is_speed(double value) noexcept {
  return std::abs(value) <= kFastest;
}
bool is_twist(const PlanarTwist& twist) noexcept {
  return is_speed(twist.x) && is_speed(twist.y) && is_speed(twist.angular);
}

/// The field of x, y or yaw among those of control_msgs/SetOdometry; 3 for one that a plane does not have.
std::size_t field_of(const std::string& name) {
  if (name == "x") return 0;
  if (name == "y") return 1;
  if (name == "yaw" || name == "heading") return 2;
  if (name == "z" || name == "roll" || name == "pitch") return 3;
  throw Error("wrong-message", "set_odometry knows no '" + name + "'", "it has x, y and yaw");
}

/// x, y, heading out of a message with three values, or with names.
std::array<double, 3> place_of(const Input& message) {
  std::array<double, 4> out{};
  if (const auto* numbers = std::get_if<Numbers>(&message)) {
    if (numbers->values.size() != 3)
      throw Error("wrong-size", "set_odometry takes three values: x, y (m) and heading (rad)");
    std::copy(numbers->values.begin(), numbers->values.end(), out.begin());
  } else {
    const auto* named = std::get_if<NamedValues>(&message);
    if (!named || named->names.size() != named->values.size())
      throw Error("wrong-message", "set_odometry takes x, y (m) and yaw (rad)");
    for (std::size_t i = 0; i < named->names.size(); ++i) out[field_of(named->names[i])] = named->values[i];
  }
  for (const double value : out)
    if (!std::isfinite(value))
      throw Error("not-a-number", "set_odometry was given a value that is not finite; it is ignored");
  return {out[0], out[1], out[2]};
}

}  // namespace

std::vector<InputPort> BaseController::inputs() const {
  const std::string port = style_.port;
  std::vector<InputPort> out{{port, {kTwistStamped, kTwist}}, {port + "_unstamped", {kTwist}}};
  if (port != "cmd_vel") out.push_back({"cmd_vel", {kTwistStamped, kTwist}});
  out.push_back({"set_odometry", {"control_msgs/SetOdometry", "std_msgs/Float64MultiArray"}});
  out.push_back({"reset_odometry", {"std_srvs/Empty"}});
  return out;
}

std::uint64_t BaseController::receive(const std::string& port, const Input& message, bool goal) {
  if (port == "set_odometry") {
    const auto [x, y, heading] = place_of(message);
    place_inbox_.write({x, y, heading});
    return 0;
  }
  if (port == "reset_odometry") {
    place_inbox_.write({});
    return 0;
  }
  const std::string own = style_.port;
  if (port != own && port != own + "_unstamped" && port != "cmd_vel")
    return Controller::receive(port, message, goal);
  const auto* twist = std::get_if<Twist>(&message);
  if (!twist) throw Error("wrong-message", port + " takes a twist (" + kTwistStamped + " or " + kTwist + ")");
  const PlanarTwist wanted{twist->linear.x, style_.lateral ? twist->linear.y : 0, twist->angular.z};
  if (!is_twist(wanted))
    throw Error("not-a-number", "the twist has a value that is not a speed; it is ignored",
                "the command before it holds until it times out");
  const bool stamped = twist->stamp && *twist->stamp != 0;  // a stamp of zero means: now
  commands_inbox_.write({wanted, stamped ? twist->stamp : std::optional<Nanoseconds>{},
                         style_.zero_timeout_is_once && port.starts_with(own)});
  return 0;
}

void BaseController::on_parameters_changed() noexcept {
  for (std::size_t i = 0; i < limiters_.size(); ++i) limiters_[i].set(limits_[i]);
}

PlanarTwist BaseController::references() const noexcept {
  if (!style_.chains) return {};
  return style_.lateral ? PlanarTwist{reference(0), reference(1), reference(2)}
                        : PlanarTwist{reference(0), 0, reference(1)};
}

void BaseController::set_references(const PlanarTwist& twist) noexcept {
  if (!style_.chains) return;
  set_reference(0, twist.x);
  if (style_.lateral) set_reference(1, twist.y);
  set_reference(style_.lateral ? 2 : 1, twist.angular);
}

void BaseController::forget() noexcept {
  command_watch().forget();
  command_ = {};
  brief_until_ = 0;
  if (!chained()) set_references(kRest);
  reference_ = references();
  reference_old_ = true;
}

CallbackReturn BaseController::on_activate(const Cycle&) noexcept {
  commands_inbox_.fetch();  // what was sent while it was not active is forgotten
  place_inbox_.fetch();
  on_parameters_changed();
  set_references(kRest);
  forget();
  stopped_ = false;
  begin();
  drive({}, true, 0);
  return CallbackReturn::success;
}

void BaseController::on_deactivate(const Cycle&) noexcept {
  forget();
  stopped_ = true;
  drive({}, true, 0);
}

void BaseController::take_command(const Cycle& cycle) noexcept {
  if (!commands_inbox_.fetch()) return;
  const Command& sent = commands_inbox_.value();
  const Nanoseconds stamp = std::min(sent.stamp.value_or(cycle.time), cycle.time);
  if (!command_watch().take(stamp, cycle.time)) return;
  command_ = sent.twist;
  const bool unbounded = style_.zero_timeout_is_once && command_watch().timeout == 0;
  once_ = unbounded && sent.once;
  brief_until_ = unbounded && !sent.once ? cycle.time + kBrief : 0;
}

/// What a message commands; empty after its time-out.
std::optional<PlanarTwist> BaseController::sent(const Cycle& cycle) noexcept {
  command_watch().expires(cycle.time, command_ != kRest);
  if (brief_until_ != 0 && cycle.time > brief_until_) command_watch().forget(), brief_until_ = 0;
  std::optional<PlanarTwist> out;
  if (command_watch().counts()) out = command_;
  if (std::exchange(once_, false)) command_watch().forget();
  set_references(out.value_or(kRest));
  reference_ =
      out.value_or(kRest);  // a controller that is put before this one begins with a value of its own
  reference_old_ = true;
  return out;
}

/// What another controller wrote. An invalid reference stops, or leaves the last one as it is.
std::optional<PlanarTwist> BaseController::referenced() noexcept {
  command_watch().forget();
  const PlanarTwist now = references();
  const bool valid = is_twist(now);
  if (!valid && style_.nan_stops) return {};
  if (valid && now != reference_) reference_ = now, reference_old_ = false;
  if (reference_old_) return {};
  return reference_;
}

std::optional<PlanarTwist> BaseController::wanted(const Cycle& cycle, const Verdict& verdict) noexcept {
  take_command(cycle);
  stopped_ = verdict.speed <= 0 || verdict.immediate || verdict.discard;
  if (stopped_) {
    forget();
    return {};
  }
  std::optional<PlanarTwist> out = chained() ? referenced() : sent(cycle);
  const double share = std::min(verdict.speed, 1.0);
  if (out) out = PlanarTwist{out->x * share, out->y * share, out->angular * share};
  return out;
}

PlanarTwist BaseController::limited() const noexcept {
  return {limiters_[0].speed(), limiters_[1].speed(), limiters_[2].speed()};
}

void BaseController::drive(const std::optional<PlanarTwist>& wish, bool at_once, double dt) noexcept {
  at_once_ = at_once;
  step_ = dt;
  const PlanarTwist target = wish.value_or(kRest);
  const std::array<double, 3> targets{target.x, target.y, target.angular};
  for (std::size_t i = 0; i < limiters_.size(); ++i) {
    if (at_once)
      limiters_[i].reset();
    else
      limiters_[i].next(targets[i], dt);
  }
  const PlanarTwist now = limited();
  write(now, wish);
  standing_.store(now == kRest && wheels_at_rest(), std::memory_order_relaxed);
}

ReturnType BaseController::update(const Cycle& cycle, const Verdict& verdict) noexcept {
  const double dt = seconds(cycle.period);
  drive(wanted(cycle, verdict), verdict.immediate, dt);
  if (!track(limited(), dt)) return ReturnType::error;
  if (place_inbox_.fetch()) {
    const Place& there = place_inbox_.value();
    place().set_pose(there.x, there.y, there.heading);
  }
  publish(cycle);
  publish_more(cycle);
  return ReturnType::ok;
}

void BaseController::publish(const Cycle& cycle) noexcept {
  const PlanarOdometry& at = odometry();
  const double z = std::sin(at.heading() / 2), w = std::cos(at.heading() / 2);
  std::vector<double>& odom = odom_->draft().values;
  const double plain[kOdometryPlain] = {at.x(),      at.y(),       0, 0, 0, z,           w,
                                        at.linear(), at.lateral(), 0, 0, 0, at.angular()};
  std::copy(std::begin(plain), std::end(plain), odom.begin());
  if (!publishes_pose_) std::fill_n(odom.begin(), 5, 0.0), odom[5] = 0, odom[6] = 1;
  std::copy(pose_covariance_.begin(), pose_covariance_.end(), odom.begin() + kOdometryPlain);
  std::copy(twist_covariance_.begin(), twist_covariance_.end(), odom.begin() + kOdometryPlain + 6);
  odom_->publish(cycle.time);
  if (publish_tf_) {
    const double transform[] = {at.x(), at.y(), 0, 0, 0, z, w};
    std::copy(std::begin(transform), std::end(transform), tf_->draft().values.begin());
    tf_->publish(cycle.time);
  }
  if (report_limited_) {
    const PlanarTwist now = limited();
    const double twist[] = {now.x, now.y, 0, 0, 0, now.angular};
    std::copy(std::begin(twist), std::end(twist), limited_->draft().values.begin());
    limited_->publish(cycle.time);
  }
}

}  // namespace polyarm::controllers
