#pragma once
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "polyarm_ros/cell_clock.hpp"
#include "rclcpp/time.hpp"

namespace rclcpp {

/// ROS time is the system's time; that of a controller's node follows the cell (cell_clock.hpp).
class Clock {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Clock)

  explicit Clock(rcl_clock_type_t type = RCL_SYSTEM_TIME) : type_(type) {}
  Time now() const {
    if (type_ == RCL_ROS_TIME) return Time(polyarm_ros::time_of(source_, polyarm_ros::system_time), type_);
    if (type_ != RCL_STEADY_TIME) return Time(polyarm_ros::system_time(), type_);
    return Time(polyarm_ros::steady_time(), type_);
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

  /// For the wrapper of a controller: where ROS time comes from.
  const polyarm_ros::TimeSource& polyarm_source() const { return source_; }

 private:
  rcl_clock_type_t type_;
  polyarm_ros::TimeSource source_ = std::make_shared<std::atomic<std::int64_t>>(0);
  std::shared_ptr<std::mutex> mutex_ = std::make_shared<std::mutex>();  ///< copies are the same clock
};

}  // namespace rclcpp
