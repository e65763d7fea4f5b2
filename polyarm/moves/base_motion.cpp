#include "polyarm/moves/base_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace polyarm::moves {

namespace {
using trajectory::MotionLimits;
using trajectory::MotionState;

constexpr double kToFullSpeed = 0.5, kToFullAcceleration = 0.2;  // s, to use if the controller states no
                                                                 // limits
constexpr double kAnySpeed = 1, kAnyTurning = 2;                 // m/s and rad/s, to use in the same case
constexpr double kGain = 2;                                      // 1/s
constexpr double kOfPeriod = 0.1;                                // largest product of gain and period
constexpr double kHere = 1e-3, kHereTurned = 3e-3;               // m and rad: arrived
constexpr double kBack = 2, kSharpest = 0.5;                     // 1/m, of steered bases: curvature per rad
                                                                 // off the line, and its maximum
constexpr double kTimeout = 3;                                  // s after the planned end before the move
                                                                 // fails

double stated(double value, double fallback) {
  return std::isfinite(value) && value > 0 ? value : fallback;
}
}  // namespace

BaseMotion::BaseMotion(controllers::BaseController& controller, double period)
    : controller_(controller),
      odometry_(controller.odometry_output()),
      gain_(std::min(kGain, kOfPeriod / std::max(period, 1e-6))) {}

std::uint64_t BaseMotion::start(const BaseMove& move) {
  if (active_) throw Error("busy", "the base is moving already", "one move of a base at a time");
  if (!odometry_) throw Error("no-odometry", "the base's controller publishes no odometry");
  if (move.turns && !controller_.turns_on_the_spot())
    throw Error("bad-move", "this base steers: it cannot turn on the spot",
                "drive it, or send twists to its controller");
  const controllers::SpeedLimits& own =
      move.turns ? controller_.angular_limits() : controller_.linear_limits();
  double speed = stated(own.max_velocity, move.turns ? kAnyTurning : kAnySpeed);
  if (move.amount < 0 && !move.turns) speed = stated(-own.min_velocity, speed);
  const double most = stated(own.max_acceleration, speed / kToFullSpeed);
  double acceleration = std::min(most, stated(-own.max_deceleration, most));
  const double jerk = stated(own.max_jerk, acceleration / kToFullAcceleration);
  speed *= move.share;
  if (move.speed > 0) speed = std::min(speed, move.speed);
  if (move.acceleration > 0) acceleration = std::min(acceleration, move.acceleration);
  limits_ = MotionLimits::symmetric(speed, acceleration, jerk);
  move_ = move;
  active_ = true;
  planned_ = seen_ = false;
  late_ = unheard_ = 0;
  last_ = -1;
  problem_.reset();
  return ++last_id_;
}

/// Reads the odometry; headings continue beyond half a turn.
bool BaseMotion::look() {
  odometry_->fetch();
  const controllers::Output::Sample& sample = odometry_->value();
  if (sample.time == 0 || sample.values.size() < 7) return false;
  const double heading = 2 * std::atan2(sample.values[5], sample.values[6]);
  Place now{sample.values[0], sample.values[1], heading};
  if (seen_) now.heading = place_.heading + std::remainder(heading - place_.heading, 2 * std::numbers::pi);
  place_ = now;
  if (!seen_) begin_ = now;
  seen_ = true;
  return true;
}

/// True if the controller has published nothing for too long: it was not configured, or it is not active.
bool BaseMotion::is_silent(double dt) {
  const Nanoseconds stamp = odometry_->value().time;
  unheard_ = std::exchange(heard_, stamp) == stamp ? unheard_ + dt : 0;
  return unheard_ > kTimeout;
}

double BaseMotion::covered() const {
  if (move_.turns) return place_.heading - begin_.heading;
  return (place_.x - begin_.x) * std::cos(begin_.heading) + (place_.y - begin_.y) * std::sin(begin_.heading);
}

std::optional<BaseMotion::Left> BaseMotion::left() const {
  if (!active_) return std::nullopt;
  const double sign = move_.amount < 0 ? -1 : 1;
  const double rest = std::max(0.0, sign * (move_.amount - (planned_ ? covered() : 0)));
  return move_.turns ? Left{0, rest} : Left{rest, 0};
}

bool BaseMotion::plan(double from) {
  const std::array<MotionState, 1> start{{{from, 0, 0}}}, target{{{move_.amount, 0, 0}}};
  const std::array<MotionLimits, 1> limits{limits_};
  trajectory::MotionOptions options;
  if (from == 0) options.minimum_duration = move_.duration;
  time_ = 0, pace_ = 1;
  return motion_.plan(start, target, limits, options) == trajectory::MotionStatus::ok;
}

void BaseMotion::send(double linear, double angular) {
  controllers::Twist twist;
  twist.linear.x = linear;
  twist.angular.z = angular;
  controller_.receive("cmd_vel", twist, false);
}

void BaseMotion::end(State outcome) {
  active_ = false;
  outcome_ = outcome;
  send(0, 0);
}

void BaseMotion::tick(Nanoseconds now, bool running, double share) {
  if (!active_ || now == last_) return;
  const double dt = last_ < 0 ? 0 : seconds(now - last_);
  last_ = now;
  const bool seen = look();
  if (!running) {  // the base stops; it continues from there later
    planned_ = false;
    return;
  }
  if (is_silent(dt)) {
    problem_ =
        Problem{"base-silent",
                {},
                fmt::format("the controller of the base has published no odometry for {:g} s", kTimeout),
                "polyarm control list says whether it is active; the start of the run says why it is not"};
    active_ = false;
    outcome_ = State::failed;
    return;
  }
  if (!seen) return;
  const double done = covered();
  if (!planned_) {
    if (!controller_.standing()) return;
    if (!plan(done)) return end(State::failed);
    planned_ = true;
  }
  const double rate = std::clamp(share, 0.0, 1.0), most = limits_.max_velocity;
  time_ += dt * rate * pace_;
  std::array<MotionState, 1> state;
  motion_.sample(time_, state);
  // The command does not include the share: the controller applies it to every command.
  const double asked = state[0].velocity + gain_ * (state[0].position - done);
  const double speed = std::clamp(asked, -most, most);
  pace_ = speed == asked ? 1 : most / std::abs(asked);  // the plan's time runs slower while the base lags
                                                        // behind at full speed
  if (time_ >= motion_.duration()) {
    const double off = move_.amount - done;
    late_ += dt * rate;
    if (std::abs(off) < (move_.turns ? kHereTurned : kHere)) return end(State::done);
    if (late_ > kTimeout) {
      problem_ = Problem{
          "base-short",
          {},
          move_.turns ? fmt::format("the base has turned by {:.1f} of {:.1f} deg and does not get further",
                                    done * 180 / std::numbers::pi, move_.amount * 180 / std::numbers::pi)
                      : fmt::format("the base has driven {:.3f} of {:.3f} m and does not get further", done,
                                    move_.amount),
          "is it blocked, or do its wheels slip?"};
      return end(State::failed);
    }
  }
  if (move_.turns) return send(0, speed);
  const double astray = begin_.heading - place_.heading;
  // A steered base turns in proportion to its speed: the correction is a curvature.
  const double turn = stated(controller_.angular_limits().max_velocity, kAnyTurning) / 4;
  send(speed, controller_.turns_on_the_spot()
                  ? std::clamp(gain_ * astray, -turn, turn)
                  : std::abs(speed) * std::clamp(kBack * astray, -kSharpest, kSharpest));
}

void BaseMotion::drop() {
  if (active_) end(State::discarded);
}

BaseMotion::State BaseMotion::state_of(std::uint64_t id) const {
  if (id == last_id_) return active_ ? State::running : outcome_;
  return State::done;
}

}  // namespace polyarm::moves
