#include "polyarm/jog/jog_axis.hpp"

#include <algorithm>
#include <cmath>

namespace polyarm::jog {
namespace {

AxisState after(const AxisState& s, double jerk, double t) noexcept {
  return {s.position + t * (s.velocity + t * (s.acceleration / 2 + t * jerk / 6)),
          s.velocity + t * (s.acceleration + t * jerk / 2), s.acceleration + t * jerk};
}

constexpr int kHalvings = 40;

}  // namespace

AxisBrake::AxisBrake(const AxisState& from, double acceleration, double jerk) noexcept {
  const double at_once = from.velocity + from.acceleration * std::abs(from.acceleration) / (2 * jerk);
  const double way = at_once >= 0 ? 1 : -1;  // sign of the motion to end
  const double v = way * from.velocity, a = way * from.acceleration;
  const double limit = std::max(acceleration, std::abs(a));
  double peak = std::max(std::sqrt(std::max(jerk * v + a * a / 2, 0.0)), std::max(-a, 0.0));
  double hold = 0;
  if (peak > limit) {
    peak = limit;
    hold = std::max((v + a * a / (2 * jerk) - peak * peak / jerk) / peak, 0.0);
  }
  time_ = {std::max((a + peak) / jerk, 0.0), hold, peak / jerk};
  jerk_ = {-way * jerk, 0, way * jerk};
  state_[0] = from;
  for (std::size_t i = 0; i < 3; ++i) state_[i + 1] = after(state_[i], jerk_[i], time_[i]);
  state_[3].velocity = state_[3].acceleration = 0;
  highest_ = std::max(from.position, state_[3].position);
  lowest_ = std::min(from.position, state_[3].position);
  if (v < 0) {  // it reverses in the first phase
    const double turn = (a - std::sqrt(std::max(a * a + 2 * jerk * v, 0.0))) / jerk;
    const double there = after(from, jerk_[0], std::clamp(turn, 0.0, time_[0])).position;
    highest_ = std::max(highest_, there);
    lowest_ = std::min(lowest_, there);
  }
  fastest_ = std::max(from.velocity, 0.0);
  slowest_ = std::min(from.velocity, 0.0);
  if (a > 0) {
    const double peak_velocity = way * (v + a * a / (2 * jerk));
    fastest_ = std::max(fastest_, peak_velocity);
    slowest_ = std::min(slowest_, peak_velocity);
  }
}

AxisState AxisBrake::at(double t) const noexcept {
  for (std::size_t i = 0; i < 3; ++i) {
    if (t < time_[i]) return after(state_[i], jerk_[i], t);
    t -= time_[i];
  }
  return state_[3];
}

AxisState towards_velocity(const AxisState& now, double velocity, double slope, const AxisLimits& limits,
                           double dt) noexcept {
  // Relative to the wanted velocity this is a brake, with the acceleration that the velocity itself needs
  // removed.
  const AxisBrake brake({0, now.velocity - velocity + slope * dt, now.acceleration - slope},
                        std::max(limits.acceleration - std::abs(slope), limits.acceleration / 8),
                        limits.jerk);
  const AxisState seen = brake.at(dt);
  const AxisState out{now.position + seen.position + dt * (velocity - slope * dt / 2),
                      seen.velocity + velocity, seen.acceleration + slope};
  const double bound = std::max(limits.acceleration, std::abs(now.acceleration));
  if (std::abs(out.acceleration) <= bound) return out;
  const double most = limits.jerk * dt;
  const double a = std::clamp(std::clamp(out.acceleration, -bound, bound), now.acceleration - most,
                              now.acceleration + most);
  return after(now, (a - now.acceleration) / dt, dt);
}

AxisState mixed(const AxisState& a, const AxisState& b, double share) noexcept {
  const auto mix = [share](double x, double y) { return x + share * (y - x); };
  return {mix(a.position, b.position), mix(a.velocity, b.velocity), mix(a.acceleration, b.acceleration)};
}

AxisGuard::AxisGuard(const AxisState& now, const AxisLimits& limits, double dt) noexcept : limits_(limits) {
  const AxisBrake brake(now, limits.acceleration, limits.jerk);
  limits_.upper = std::max(limits.upper, brake.highest());
  limits_.lower = std::min(limits.lower, brake.lowest());
  // Within a cycle the velocity may be higher than at its ends.
  const double velocity = std::max(limits.velocity - limits.jerk * dt * dt / 8, limits.velocity / 2);
  fastest_ = std::max(velocity, brake.fastest());
  slowest_ = std::min(-velocity, brake.slowest());
  braked_ = brake.at(dt);
}

bool AxisGuard::safe(const AxisState& next) const noexcept {
  const AxisBrake brake(next, limits_.acceleration, limits_.jerk);
  return brake.highest() <= limits_.upper && brake.lowest() >= limits_.lower && brake.fastest() <= fastest_ &&
         brake.slowest() >= slowest_;
}

AxisState AxisGuard::nearest(const AxisState& wanted, bool& cut) const noexcept {
  if (safe(wanted)) return wanted;
  cut = true;
  double low = 0, high = 1;  // low is safe: the safe states are convex
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (safe(mixed(braked_, wanted, middle)) ? low : high) = middle;
  }
  return mixed(braked_, wanted, low);
}

double stopping_speed(double distance, double acceleration, double jerk) noexcept {
  if (!(distance > 0)) return 0;
  if (!std::isfinite(distance)) return distance;
  const double full = acceleration * acceleration / jerk;  // from here on the braking reaches its limit
  const double gentle = std::cbrt(distance * distance * jerk);
  if (gentle <= full) return gentle;
  return std::sqrt(full * full / 4 + 2 * acceleration * distance) - full / 2;
}

}  // namespace polyarm::jog
