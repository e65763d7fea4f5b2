#pragma once
#include <chrono>
#include <cstdint>
#include <stdexcept>

#include "builtin_interfaces/msg/duration.hpp"
#include "polyarm_ros/standard.hpp"
#include "rclcpp/macros.hpp"
#include "rclcpp/visibility_control.hpp"

using rcutils_duration_value_t = std::int64_t;
using rcl_duration_value_t = rcutils_duration_value_t;
struct rmw_time_t {
  std::uint64_t sec, nsec;
};

namespace rclcpp {

/// A signed span of time in nanoseconds.
class Duration {
 public:
  Duration() = default;
  Duration(std::int32_t seconds, std::uint32_t nanoseconds)
      : ns_(static_cast<std::int64_t>(seconds) * 1'000'000'000 + nanoseconds) {}
  explicit Duration(std::chrono::nanoseconds span) : ns_(span.count()) {}
  explicit Duration(rcl_duration_value_t nanoseconds) : ns_(nanoseconds) {}  // in Foxy
  template <class Rep, class Period>
  Duration(const std::chrono::duration<Rep, Period>& span)  // NOLINT: implicit in ROS
      : ns_(std::chrono::duration_cast<std::chrono::nanoseconds>(span).count()) {}
  Duration(const builtin_interfaces::msg::Duration& m)  // NOLINT: implicit in ROS
      : Duration(m.sec, m.nanosec) {}

  static Duration from_seconds(double seconds) {
    return from_nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
  }
  static Duration from_nanoseconds(std::int64_t ns) {
    Duration out;
    out.ns_ = ns;
    return out;
  }
  static Duration max() { return from_nanoseconds(INT64_MAX); }

  std::int64_t nanoseconds() const { return ns_; }
  double seconds() const { return static_cast<double>(ns_) * 1e-9; }
  template <class Span>
  Span to_chrono() const {
    return std::chrono::duration_cast<Span>(std::chrono::nanoseconds(ns_));
  }
  rmw_time_t to_rmw_time() const {
    return {static_cast<std::uint64_t>(ns_ / 1'000'000'000), static_cast<std::uint64_t>(ns_ % 1'000'000'000)};
  }
  operator builtin_interfaces::msg::Duration() const {
    builtin_interfaces::msg::Duration out;
    std::int64_t sec = ns_ / 1'000'000'000, rest = ns_ % 1'000'000'000;
    if (rest < 0) rest += 1'000'000'000, --sec;
    out.sec = static_cast<std::int32_t>(sec);
    out.nanosec = static_cast<std::uint32_t>(rest);
    return out;
  }

  bool operator==(const Duration& o) const { return ns_ == o.ns_; }
  bool operator!=(const Duration& o) const { return ns_ != o.ns_; }
  bool operator<(const Duration& o) const { return ns_ < o.ns_; }
  bool operator<=(const Duration& o) const { return ns_ <= o.ns_; }
  bool operator>(const Duration& o) const { return ns_ > o.ns_; }
  bool operator>=(const Duration& o) const { return ns_ >= o.ns_; }
  Duration operator+(const Duration& o) const { return from_nanoseconds(checked(ns_, o.ns_)); }
  Duration operator-(const Duration& o) const { return from_nanoseconds(checked(ns_, -o.ns_)); }
  Duration& operator+=(const Duration& o) { return *this = *this + o; }
  Duration& operator-=(const Duration& o) { return *this = *this - o; }
  Duration operator*(double scale) const {
    return from_nanoseconds(static_cast<std::int64_t>(static_cast<double>(ns_) * scale));
  }
  Duration& operator*=(double scale) { return *this = *this * scale; }

 private:
  static std::int64_t checked(std::int64_t a, std::int64_t b) {
    std::int64_t out = 0;
    if (__builtin_add_overflow(a, b, &out)) throw std::overflow_error("a duration leaves its range");
    return out;
  }
  std::int64_t ns_ = 0;
};

}  // namespace rclcpp
