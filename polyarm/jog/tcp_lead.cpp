#include "polyarm/jog/tcp_lead.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::jog {
namespace {

using trajectory::MotionLimits;
using trajectory::MotionState;

/// Share of the joints' abilities for changes of the TCP's velocity. The rest is for following and for
/// braking.
constexpr double kRamp = 0.35;
/// Factors of kRamp towards a target: along the path, across it, and the maximum for harder braking.
constexpr double kLead = 1.2, kAside = 0.4, kBrakesHarder = 2;
constexpr double kHere = 2e-6, kHereTurned = 1e-5;  // m, rad
constexpr double kCreeps = 5e-3;                    // m/s, rad/s

/// Three orthogonal axes; the first is parallel to `v`.
std::array<Vec3, 3> axes_along(const Vec3& v) {
  const Quaternion r = rotation_between({1, 0, 0}, norm(v) > 1e-9 ? normalized(v) : Vec3{1, 0, 0});
  return {r * Vec3{1, 0, 0}, r * Vec3{0, 1, 0}, r * Vec3{0, 0, 1}};
}
Vec3 part_of(const Twist& t, std::size_t part) {
  return {t[3 * part], t[3 * part + 1], t[3 * part + 2]};
}
/// If an arm cannot change its speed as quickly as at the start, a motion that would pass the target brakes
/// with some of the reserve.
void brake_harder(const double (&away)[2], const std::array<MotionState, 6>& from,
                  const std::array<MotionState, 6>& to, std::array<MotionLimits, 6>& most) {
  for (std::size_t k = 0; k < 6; ++k) {
    const double left = to[k].position, v = from[k].velocity;
    if (left * v <= 0 || away[k / 3] < 1e-5) continue;
    const double can = stopping_speed(std::abs(left), most[k].max_acceleration, most[k].max_jerk);
    if (!(std::abs(v) > can)) continue;
    const double more = std::min(v * v / (can * can), kBrakesHarder);
    most[k].max_acceleration *= more;
    most[k].min_acceleration *= more;
    most[k].max_jerk *= more;
  }
}

}  // namespace

TcpLead::TcpLead(std::span<const AxisLimits> axes, double period)
    : joints_(std::min(axes.size(), kMostJogJoints)), dt_(period) {
  for (std::size_t j = 0; j < joints_; ++j) {
    acceleration_[j] = kRamp * axes[j].acceleration;
    jerk_[j] = kRamp * axes[j].jerk;
  }
}

void TcpLead::begin(const Pose& tcp, const Twist& twist) noexcept {
  on_ = true;
  pose_ = tcp;
  twist_ = twist;
  slope_ = {};
}

void TcpLead::hold_back(const Pose& tcp, double share) noexcept {
  pose_ = tcp;
  for (double& x : twist_) x *= share;
  const bool creeps = share < 1 && linear(twist_) < kCreeps && angular(twist_) < kCreeps;
  for (double& x : slope_) x *= creeps ? 0 : share;
}

/// The acceleration and jerk of the TCP along `direction` that the joints allow.
void TcpLead::capability(const Twist& direction, const TwistSolver& solver, double& acceleration,
                         double& jerk) const noexcept {
  JogValues rates;
  solver.reach(direction, rates);
  for (std::size_t j = 0; j < joints_; ++j) {
    const double r = std::max(std::abs(rates[j]), 1e-9);
    acceleration = std::min(acceleration, acceleration_[j] / r);
    jerk = std::min(jerk, jerk_[j] / r);
  }
}

void TcpLead::ramp(const Twist& wanted, const TwistSolver& solver) noexcept {
  std::array<MotionState, 6> from, to, out;
  std::array<MotionLimits, 6> most;
  std::array<std::array<Vec3, 3>, 2> axes;
  const bool both = linear(wanted) + linear(twist_) > 1e-9 && angular(wanted) + angular(twist_) > 1e-9;
  for (std::size_t part = 0; part < 2; ++part) {
    const Vec3 goal = part_of(wanted, part), now = part_of(twist_, part), slope = part_of(slope_, part);
    axes[part] = axes_along(norm(goal) > 1e-9 ? goal : now);
    Pace pace;
    for (const Vec3& axis : axes[part]) {
      Twist along{};
      along[3 * part] = axis.x, along[3 * part + 1] = axis.y, along[3 * part + 2] = axis.z;
      // Across the path only if a change is needed there.
      const bool across = &axis != &axes[part][0];
      if (across && std::abs(dot(axis, now)) + std::abs(dot(axis, slope)) < 1e-12) continue;
      capability(along, solver, pace.acceleration[part], pace.jerk[part]);
    }
    const double share = both ? 0.5 : 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& axis = axes[part][k];
      from[3 * part + k] = {0, dot(axis, now), dot(axis, slope)};
      to[3 * part + k] = {0, k == 0 ? dot(axis, goal) : 0.0, 0};
      most[3 * part + k] = MotionLimits::symmetric(1 + 2 * std::max(norm(goal), norm(now)),
                                                   share * pace.acceleration[part], share * pace.jerk[part]);
    }
  }
  const trajectory::MotionOptions options{trajectory::Synchronization::none, trajectory::TargetKind::velocity,
                                          0};
  if (plan_.plan(from, to, most, options) != trajectory::MotionStatus::ok) return;
  plan_.sample(dt_, out);
  Twist by{};
  for (std::size_t part = 0; part < 2; ++part) {
    const auto sum = [&](double MotionState::*value, Twist& into) {
      Vec3 v;
      for (std::size_t k = 0; k < 3; ++k) v = v + out[3 * part + k].*value * axes[part][k];
      into[3 * part] = v.x, into[3 * part + 1] = v.y, into[3 * part + 2] = v.z;
    };
    sum(&MotionState::position, by);
    sum(&MotionState::velocity, twist_);
    sum(&MotionState::acceleration, slope_);
  }
  advance(pose_, by);
}

/// The allowed change of the TCP's position (part 0) or rotation (part 1) along `ahead`, and along any axis.
TcpLead::Pull TcpLead::pull_along(const Twist& ahead, std::size_t part,
                                  const TwistSolver& solver) const noexcept {
  Pace any, own;
  for (std::size_t k = 3 * part; k < 3 * part + 3; ++k) {
    Twist along{};
    along[k] = 1;
    capability(along, solver, any.acceleration[part], any.jerk[part]);
  }
  const Vec3 way = part_of(ahead, part);
  const double length = norm(way);
  Twist along{};
  for (std::size_t k = 0; k < 3; ++k)
    along[3 * part + k] = length > 1e-6 ? (k == 0 ? way.x : k == 1 ? way.y : way.z) / length : 0.0;
  if (length > 1e-6)
    capability(along, solver, own.acceleration[part], own.jerk[part]);
  else
    own = any;
  return {own.acceleration[part], own.jerk[part], any.acceleration[part], any.jerk[part]};
}

Twist TcpLead::way_to(const Target& target) const noexcept {
  Twist out = between(pose_, target.pose);
  for (std::size_t k = 0; k < 6; ++k) out[k] += kAhead * target.twist[k];
  const double time = std::max({linear(out) / target.speed, angular(out) / target.turning, 1e-9});
  for (double& x : out) x /= time;
  return out;
}

/// Works in a chart around the present pose.
bool TcpLead::approach(const Target& target, double share, const TwistSolver& solver) noexcept {
  Twist error = between(pose_, target.pose);
  std::array<double, kMostJogJoints> rates;
  if (solver.columns() < 6) {  // as far as the arm can move
    solver.reach(error, rates);
    error = solver.twist_of({rates.data(), joints_});
  }
  std::array<MotionState, 6> from, to, out;
  std::array<MotionLimits, 6> most;
  // Each axis has its share of the speed along the path, and at least a part of it for corrections.
  const double away[2] = {linear(error), angular(error)};
  Twist ahead, moving{};
  for (std::size_t k = 0; k < 6; ++k) ahead[k] = error[k] + kAhead * target.twist[k];
  const double way[2] = {linear(ahead), angular(ahead)},
               rate[2] = {linear(target.twist), angular(target.twist)};
  const double speed[2] = {target.speed, target.turning};
  std::array<Pull, 2> pull{};
  for (std::size_t part = 0; part < 2; ++part) pull[part] = pull_along(ahead, part, solver);
  for (std::size_t k = 0; k < 6; ++k) {
    const double part = way[k / 3] > 1e-6 ? std::abs(ahead[k]) / way[k / 3] : 0.0;
    const double can = share * speed[k / 3];
    const double v = std::max(can * std::max(part, 0.1), 1e-6);
    moving[k] = target.twist[k] * (rate[k / 3] > kFollows * can ? kFollows * can / rate[k / 3] : 1.0);
    moving[k] = std::clamp(moving[k], -kFollows * v, kFollows * v);
    from[k] = {0, twist_[k] - moving[k], slope_[k]};
    to[k] = {error[k], 0, 0};
    const Pull& p = pull[k / 3];
    most[k] = MotionLimits::symmetric(v, kLead * std::max(part * p.acceleration, kAside * p.any_acceleration),
                                      kLead * std::max(part * p.jerk, kAside * p.any_jerk));
    most[k].max_velocity -= moving[k];
    most[k].min_velocity -= moving[k];
  }
  brake_harder(away, from, to, most);
  const trajectory::MotionOptions options{trajectory::Synchronization::phase,
                                          trajectory::TargetKind::position, 0};
  if (plan_.plan(from, to, most, options) != trajectory::MotionStatus::ok) return false;
  plan_.sample(dt_, out);
  Twist by{};
  for (std::size_t k = 0; k < 6; ++k) {
    by[k] = out[k].position + dt_ * moving[k];
    twist_[k] = out[k].velocity + moving[k];
    slope_[k] = out[k].acceleration;
  }
  advance(pose_, by);
  const Twist left = between({solver.position(), solver.rotation()}, pose_);
  return away[0] < kHere && away[1] < kHereTurned && linear(twist_) < 1e-5 && angular(twist_) < 1e-4 &&
         (solver.columns() < 6 || (linear(left) < kHere && angular(left) < kHereTurned));
}

}  // namespace polyarm::jog
