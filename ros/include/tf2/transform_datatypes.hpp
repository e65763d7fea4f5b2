#pragma once
#include <chrono>
#include <string>

#include "tf2/LinearMath/Transform.hpp"
#include "tf2/exceptions.hpp"

namespace tf2 {
using Duration = std::chrono::nanoseconds;
using TimePoint = std::chrono::time_point<std::chrono::system_clock, Duration>;
using IDuration = Duration;
inline const TimePoint TimePointZero{};
inline TimePoint get_now() {
  return std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now());
}
inline Duration durationFromSec(double s) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
}
inline double durationToSec(const Duration& d) {
  return std::chrono::duration<double>(d).count();
}
inline TimePoint timeFromSec(double s) {
  return TimePoint(durationFromSec(s));
}
inline double timeToSec(const TimePoint& t) {
  return durationToSec(t.time_since_epoch());
}
inline std::string displayTimePoint(const TimePoint& t) {
  return std::to_string(timeToSec(t));
}
/// A value with a time and the frame that it is in.
template <typename T>
class Stamped : public T {
 public:
  TimePoint stamp_{};
  std::string frame_id_;
  Stamped() = default;
  Stamped(const T& value, const TimePoint& stamp, const std::string& frame) : T(value), stamp_(stamp), frame_id_(frame) {}
  void setData(const T& value) { static_cast<T&>(*this) = value; }
};
}  // namespace tf2
