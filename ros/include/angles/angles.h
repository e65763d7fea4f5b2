#pragma once
#include <cmath>

namespace angles {
constexpr double kPi = 3.14159265358979323846;
inline double from_degrees(double degrees) {
  return degrees * kPi / 180.0;
}
inline double to_degrees(double radians) {
  return radians * 180.0 / kPi;
}
inline double normalize_angle_positive(double a) {
  const double out = std::fmod(a, 2 * kPi);
  return out < 0 ? out + 2 * kPi : out;
}
/// In (-π, π].
inline double normalize_angle(double a) {
  const double out = std::fmod(a + kPi, 2 * kPi);
  return out <= 0 ? out + kPi : out - kPi;
}
inline double shortest_angular_distance(double from, double to) {
  return normalize_angle(to - from);
}
/// The way from `from` to an angle that equals `to` and lies in [left, right], the shortest first; the limits
/// may span more than a turn. False if `from` is outside, or if there is no such angle: then the shortest way
/// without limits.
inline bool shortest_angular_distance_with_large_limits(double from, double to, double left, double right,
                                                        double& way) {
  way = shortest_angular_distance(from, to);
  if (left > right || from < left || from > right) return false;
  const double first = to + 2 * kPi * std::ceil((left - to) / (2 * kPi));
  bool found = false;
  for (double at = first; at <= right; at += 2 * kPi) {
    if (!found || std::abs(at - from) < std::abs(way)) way = at - from;
    found = true;
  }
  return found;
}
/// The same for limits within one turn, which may wrap around: left > right.
inline bool shortest_angular_distance_with_limits(double from, double to, double left, double right,
                                                  double& way) {
  const double start = normalize_angle(from);
  if (right < left) right += 2 * kPi;
  const double lifted = start < left ? start + 2 * kPi : start;
  return shortest_angular_distance_with_large_limits(lifted, to, left, right, way);
}
inline double two_pi_complement(double a) {
  if (a > 2 * kPi || a < -2 * kPi) a = std::fmod(a, 2 * kPi);
  return a < 0 ? 2 * kPi + a : a > 0 ? -2 * kPi + a : 2 * kPi;
}
}  // namespace angles
