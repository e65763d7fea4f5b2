#pragma once
#include <cstdint>
#include <stdexcept>

#include "builtin_interfaces/msg/time.hpp"
#include "polyarm_ros/standard.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/visibility_control.hpp"

enum rcl_clock_type_t { RCL_CLOCK_UNINITIALIZED = 0, RCL_ROS_TIME, RCL_SYSTEM_TIME, RCL_STEADY_TIME };
using rcl_clock_type_e = rcl_clock_type_t;
using rcl_time_point_value_t = std::int64_t;

namespace rclcpp {

/// A moment of one clock. Moments of different clocks cannot be compared or subtracted: that throws, as in
/// ROS.
class Time {
 public:
  Time() : clock_(RCL_SYSTEM_TIME) {}
  Time(std::int32_t seconds, std::uint32_t nanoseconds, rcl_clock_type_t clock = RCL_SYSTEM_TIME)
      : ns_(static_cast<std::int64_t>(seconds) * 1'000'000'000 + nanoseconds), clock_(clock) {
    if (seconds < 0) throw std::runtime_error("cannot store a negative time point in rclcpp::Time");
  }
  explicit Time(std::int64_t nanoseconds, rcl_clock_type_t clock = RCL_SYSTEM_TIME)
      : ns_(nanoseconds), clock_(clock) {}
  Time(const builtin_interfaces::msg::Time& m, rcl_clock_type_t clock = RCL_ROS_TIME)  // NOLINT: as in ROS
      : Time(m.sec, m.nanosec, clock) {}
  Time& operator=(const builtin_interfaces::msg::Time& m) { return *this = Time(m); }

  std::int64_t nanoseconds() const { return ns_; }
  double seconds() const { return static_cast<double>(ns_) * 1e-9; }
  rcl_clock_type_t get_clock_type() const { return clock_; }
  static Time max(rcl_clock_type_t clock = RCL_SYSTEM_TIME) { return Time(INT32_MAX, 999'999'999, clock); }

  operator builtin_interfaces::msg::Time() const {
    builtin_interfaces::msg::Time out;
    out.sec = static_cast<std::int32_t>(ns_ / 1'000'000'000);
    out.nanosec = static_cast<std::uint32_t>(ns_ % 1'000'000'000);
    return out;
  }

  bool operator==(const Time& o) const { return same(o), ns_ == o.ns_; }
  bool operator!=(const Time& o) const { return !(*this == o); }
  bool operator<(const Time& o) const { return same(o), ns_ < o.ns_; }
  bool operator<=(const Time& o) const { return same(o), ns_ <= o.ns_; }
  bool operator>(const Time& o) const { return same(o), ns_ > o.ns_; }
  bool operator>=(const Time& o) const { return same(o), ns_ >= o.ns_; }
  Time operator+(const Duration& d) const { return Time(ns_ + d.nanoseconds(), clock_); }
  Time operator-(const Duration& d) const { return Time(ns_ - d.nanoseconds(), clock_); }
  Time& operator+=(const Duration& d) { return *this = *this + d; }
  Time& operator-=(const Duration& d) { return *this = *this - d; }
  Duration operator-(const Time& o) const { return same(o), Duration::from_nanoseconds(ns_ - o.ns_); }

 private:
  void same(const Time& o) const {
    if (clock_ != o.clock_) throw std::runtime_error("can't compare times with different time sources");
  }
  std::int64_t ns_ = 0;
  rcl_clock_type_t clock_;
};
inline Time operator+(const Duration& d, const Time& t) {
  return t + d;
}

}  // namespace rclcpp
