#pragma once
#include <chrono>

#include "tf2/LinearMath/Matrix3x3.hpp"
#include "tf2/exceptions.hpp"

namespace tf2 {
using Duration = std::chrono::nanoseconds;
using TimePoint = std::chrono::time_point<std::chrono::system_clock, Duration>;
inline const TimePoint TimePointZero{};
inline Duration durationFromSec(double s) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
}
}  // namespace tf2
