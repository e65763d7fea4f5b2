#pragma once
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "rclcpp/time.hpp"

namespace rclcpp {

/// ROS time is the system's time here; there is no simulated clock.
class Clock {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Clock)

  explicit Clock(rcl_clock_type_t type = RCL_SYSTEM_TIME) : type_(type) {}
  Time now() const {
    const auto since = type_ == RCL_STEADY_TIME ? std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                      std::chrono::steady_clock::now().time_since_epoch())
                                                : std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                      std::chrono::system_clock::now().time_since_epoch());
    return Time(since.count(), type_);
  }
  bool sleep_until(Time until) { return sleep_for(until - now()); }
  bool sleep_for(Duration span) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(span.nanoseconds()));
    return true;
  }
  rcl_clock_type_t get_clock_type() const { return type_; }
  bool ros_time_is_active() const { return false; }
  bool started() const { return true; }
  std::mutex& get_clock_mutex() { return *mutex_; }

 private:
  rcl_clock_type_t type_;
  std::shared_ptr<std::mutex> mutex_ = std::make_shared<std::mutex>();  ///< copies are the same clock
};

}  // namespace rclcpp
