#pragma once
/// Random cases from state to state, and the error of a motion.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>

#include "polyarm/trajectory/state_to_state.hpp"

namespace polyarm::test::states {

using trajectory::AxisMotion;
using trajectory::MotionLimits;
using trajectory::MotionState;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double even(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  double logarithmic(double low, double high) { return std::exp(even(std::log(low), std::log(high))); }
  bool coin() { return even(0, 1) < 0.5; }
  /// A random state from which an axis can stay within its limits, and which it can reach within them.
  MotionState state(const MotionLimits& l, double position) {
    const double v = even(l.min_velocity, l.max_velocity);
    const double room = std::sqrt(2 * l.max_jerk * std::min(v - l.min_velocity, l.max_velocity - v));
    return {position, v, even(std::max(-room, l.min_acceleration), std::min(room, l.max_acceleration))};
  }

 private:
  std::mt19937_64 engine_;
};

/// A family of limits, and the range of its distances.
struct Kind {
  const char* name;
  double velocity[2], acceleration[2], jerk[2], distance[2];
};
inline constexpr Kind kKinds[] = {{"arm", {1, 4}, {5, 30}, {50, 1000}, {1e-6, 6}},
                                  {"micro", {1, 4}, {5, 30}, {50, 1000}, {1e-10, 1e-4}},
                                  {"moderate", {.1, 10}, {.1, 100}, {1, 1e4}, {1e-3, 10}},
                                  {"millimetres", {10, 5000}, {100, 5e4}, {1e3, 1e6}, {1e-3, 5000}},
                                  {"high_jerk", {1, 4}, {5, 30}, {1e4, 1e7}, {1e-3, 6}}};

inline MotionLimits limits_of(const Kind& kind, Draw& draw, bool lopsided) {
  const auto one = [&](const double(&range)[2]) { return draw.logarithmic(range[0], range[1]); };
  MotionLimits out = MotionLimits::symmetric(one(kind.velocity), one(kind.acceleration), one(kind.jerk));
  if (lopsided) out.min_velocity *= draw.even(0.3, 2), out.min_acceleration *= draw.even(0.3, 2);
  return out;
}

inline std::string shown(const MotionState& from, const MotionState& to, const MotionLimits& l) {
  char out[512];
  std::snprintf(
      out, sizeof out,
      "from {%.17g, %.17g, %.17g} to {%.17g, %.17g, %.17g} within {%.17g, %.17g, %.17g, %.17g, %.17g}",
      from.position, from.velocity, from.acceleration, to.position, to.velocity, to.acceleration,
      l.max_velocity, l.max_acceleration, l.max_jerk, l.min_velocity, l.min_acceleration);
  return out;
}

inline double end_of(const AxisMotion& m, std::size_t piece) {
  return piece + 1 < m.pieces() ? m.begin_of(piece + 1) : m.duration();
}
inline MotionState passed(const MotionState& s, double t, double jerk) {
  return {s.position + t * (s.velocity + t * (s.acceleration / 2 + t * jerk / 6)),
          s.velocity + t * (s.acceleration + t * jerk / 2), s.acceleration + t * jerk};
}
/// The largest relative excess of a motion over its limits. Accelerations are extreme at the ends of pieces;
/// velocities there and where the acceleration is zero. Tolerates the change of acceleration in the last
/// digit of the time.
inline double excess(const AxisMotion& m, const MotionLimits& l) {
  double worst = 0;
  for (std::size_t k = 0; k < m.pieces(); ++k) {
    const double length = end_of(m, k) - m.begin_of(k), jerk = m.jerk_of(k);
    const double zero = jerk != 0 ? -m.state_of(k).acceleration / jerk : -1;
    for (const double t : {0.0, length, zero > 0 && zero < length ? zero : 0.0}) {
      const MotionState s = passed(m.state_of(k), t, jerk);
      const double digit = l.max_jerk * m.duration() * 4e-15;
      worst = std::max({worst, s.velocity / l.max_velocity - 1, s.velocity / l.min_velocity - 1,
                        (s.acceleration - digit) / l.max_acceleration - 1,
                        (s.acceleration + digit) / l.min_acceleration - 1, std::abs(jerk) / l.max_jerk - 1});
    }
  }
  return worst;
}
/// The error of the motion's end: position relative to the distances of the motion, velocity and acceleration
/// relative to the limits. Tolerates the change of acceleration in the last digit of the time.
inline double miss(const AxisMotion& m, const MotionState& from, const MotionState& to,
                   const MotionLimits& l) {
  const std::size_t last = m.pieces() - 1;
  const MotionState end = passed(m.state_of(last), m.duration() - m.begin_of(last), m.jerk_of(last));
  const double way = std::abs(from.position) + std::abs(to.position) + l.max_velocity * m.duration();
  return std::max({std::abs(end.position - to.position) / way,
                   std::abs(end.velocity - to.velocity) / (l.max_velocity - l.min_velocity),
                   (std::abs(end.acceleration - to.acceleration) - l.max_jerk * m.duration() * 4e-15) /
                       (l.max_acceleration - l.min_acceleration)});
}

}  // namespace polyarm::test::states
