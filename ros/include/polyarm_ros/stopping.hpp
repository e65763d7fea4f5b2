#pragma once
/// How a controller of ROS, which knows no stop, is stopped. One that commands positions gets slower time until
/// its time stands: it stops on its path. One that commands velocities is not updated while its commands are
/// braked to 0. One that commands efforts goes on, as its loop may be what holds the joints. Control thread;
/// allocates nothing after resize().
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace polyarm_ros {

enum class Kind : unsigned char { position, velocity, acceleration, effort, other };

inline Kind kind_of(const std::string& interface) {
  if (interface == "position") return Kind::position;
  if (interface == "velocity") return Kind::velocity;
  if (interface == "acceleration") return Kind::acceleration;
  for (const char* name : {"effort", "torque", "force", "current"})
    if (interface == name) return Kind::effort;
  return Kind::other;
}

class Stopping {
 public:
  struct Command {
    Kind kind = Kind::other;
    double deceleration = 0;  ///< rad/s² or m/s² that it may be braked with
    double last = 0, speed = 0;
  };

  void resize(std::size_t count) { commands_.assign(count, {}); }
  /// Without limits of the joint, its velocity ends within a quarter of a second.
  void set(std::size_t i, Kind kind, double deceleration, double velocity) {
    Command& c = commands_[i];
    c.kind = kind;
    c.deceleration = std::isfinite(deceleration) && deceleration > 0 ? deceleration
                     : std::isfinite(velocity) && velocity > 0       ? 4 * velocity
                                                                     : 4;
    has_position_ = has_position_ || kind == Kind::position;
    has_effort_ = has_effort_ || kind == Kind::effort;
    has_rate_ = has_rate_ || kind == Kind::velocity || kind == Kind::acceleration;
  }
  bool brakes() const noexcept { return has_rate_ && !has_position_ && !has_effort_; }
  bool pushes() const noexcept { return has_effort_; }
  double share() const noexcept { return share_; }

  void begin(double share) noexcept {
    share_ = share;
    for (Command& c : commands_) c.speed = 0, c.last = std::numeric_limits<double>::quiet_NaN();
  }
  /// The next share of time, towards `wanted` and no faster than the joints can brake.
  double next_share(double wanted, double dt) noexcept {
    bool moves = false;
    double least = 1 / dt;
    for (const Command& c : commands_) {
      const double full = std::abs(c.speed) / std::max(share_, 0.01);
      if (c.kind != Kind::position || full < 1e-6) continue;
      moves = true;
      least = std::min(least, c.deceleration / full);
    }
    double slope = std::max(1 / kLongest, least);
    if (!moves) slope = wanted < share_ ? 1 / dt : 1 / kStart;
    return share_ += std::clamp(wanted - share_, -slope * dt, slope * dt);
  }
  /// What was commanded, after an update: for the speeds that a stop begins from.
  void note(std::size_t i, double value, double dt) noexcept {
    Command& c = commands_[i];
    if (c.kind == Kind::position)
      c.speed = std::isfinite(value) && std::isfinite(c.last) ? (value - c.last) / dt : 0;
    else
      c.speed = std::isfinite(value) ? value : 0;
    c.last = value;
  }
  /// The next value of command i while each joint is braked by itself.
  double braked(std::size_t i, double dt) noexcept {
    Command& c = commands_[i];
    const double most = c.deceleration * dt;
    if (c.kind == Kind::position) {
      c.speed -= std::clamp(c.speed, -most, most);
      c.last += c.speed * dt;
    } else if (c.kind == Kind::velocity) {
      c.last -= std::clamp(c.last, -most, most);
      c.speed = c.last;
    } else if (c.kind == Kind::acceleration) {
      c.last = c.speed = 0;
    }
    return c.last;
  }
  bool at_rest() const noexcept {
    for (const Command& c : commands_)
      if (c.kind != Kind::other && c.kind != Kind::effort && std::abs(c.speed) > 1e-6) return false;
    return true;
  }

 private:
  static constexpr double kLongest = 2.0;  ///< s that a stop on the path takes at most
  static constexpr double kStart = 0.5;    ///< s from rest to full speed, before its speeds are known
  std::vector<Command> commands_;
  double share_ = 1;
  bool has_position_ = false, has_effort_ = false, has_rate_ = false;
};

}  // namespace polyarm_ros
