#pragma once
#include <cmath>

#include "polyarm_ros/standard.hpp"
#include "tf2/LinearMath/Vector3.hpp"
#define TF2SIMD_PI 3.14159265358979323846
#define TF2SIMD_2_PI (2 * TF2SIMD_PI)
#define TF2SIMD_HALF_PI (TF2SIMD_PI / 2)
#define TF2SIMD_RADS_PER_DEG (TF2SIMD_PI / 180)
#define TF2SIMD_DEGS_PER_RAD (180 / TF2SIMD_PI)
#define TF2SIMD_EPSILON 2.2204460492503131e-16

inline tf2Scalar tf2Sqrt(tf2Scalar x) {
  return std::sqrt(x);
}
inline tf2Scalar tf2Fabs(tf2Scalar x) {
  return std::fabs(x);
}
inline tf2Scalar tf2Cos(tf2Scalar x) {
  return std::cos(x);
}
inline tf2Scalar tf2Sin(tf2Scalar x) {
  return std::sin(x);
}
inline tf2Scalar tf2Atan2(tf2Scalar y, tf2Scalar x) {
  return std::atan2(y, x);
}
/// Arguments outside of -1 … 1 count as its ends.
inline tf2Scalar tf2Acos(tf2Scalar x) {
  return std::acos(std::fmax(-1.0, std::fmin(1.0, x)));
}
inline tf2Scalar tf2Asin(tf2Scalar x) {
  return std::asin(std::fmax(-1.0, std::fmin(1.0, x)));
}
inline tf2Scalar tf2Radians(tf2Scalar degrees) {
  return degrees * TF2SIMD_RADS_PER_DEG;
}
inline tf2Scalar tf2Degrees(tf2Scalar radians) {
  return radians * TF2SIMD_DEGS_PER_RAD;
}
