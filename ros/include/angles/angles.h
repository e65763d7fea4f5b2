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
}  // namespace angles
