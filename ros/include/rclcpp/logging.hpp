#pragma once
/// The logging macros. Conditions (ONCE, EXPRESSION, SKIPFIRST, THROTTLE) are evaluated before any text is
/// made.
#include <atomic>
#include <cinttypes>
#include <cstdint>
#include <functional>
#include <sstream>
#include <string>

#include "rclcpp/logger.hpp"

namespace polyarm_ros {

inline bool logs(Severity severity) {
  return static_cast<int>(severity) >= least_severity().load(std::memory_order_relaxed);
}
/// True at most once in `period_ms` by `now_ns`, the time of the clock that the caller names.
inline bool throttle(std::atomic<std::int64_t>& last, std::int64_t now_ns, double period_ms) {
  const std::int64_t before = last.load(std::memory_order_relaxed);
  const bool due =
      before == INT64_MIN || now_ns < before || static_cast<double>(now_ns - before) >= period_ms * 1e6;
  if (due) last.store(now_ns, std::memory_order_relaxed);
  return due;
}
template <typename Clock>
std::int64_t now_of(Clock&& clock) {
  return clock.now().nanoseconds();
}

}  // namespace polyarm_ros

#define POLYARM_ROS_LOG_IF_(SEVERITY, CONDITION, LOGGER, ...)                \
  do {                                                                       \
    if (::polyarm_ros::logs(SEVERITY) && (CONDITION))                        \
      ::polyarm_ros::log_format(SEVERITY, (LOGGER).get_name(), __VA_ARGS__); \
  } while (0)
#define POLYARM_ROS_STREAM_IF_(SEVERITY, CONDITION, LOGGER, ...)                                 \
  do {                                                                                           \
    if (::polyarm_ros::logs(SEVERITY) && (CONDITION)) {                                          \
      std::stringstream polyarm_ros_stream_;                                                     \
      polyarm_ros_stream_ << __VA_ARGS__;                                                        \
      ::polyarm_ros::log_text(SEVERITY, (LOGGER).get_name(), polyarm_ros_stream_.str().c_str()); \
    }                                                                                            \
  } while (0)
#define POLYARM_ROS_FIRST_                                  \
  ([]() -> bool {                                           \
    static std::atomic<bool> done{false};                   \
    return !done.exchange(true, std::memory_order_relaxed); \
  }())
#define POLYARM_ROS_NOT_FIRST_                             \
  ([]() -> bool {                                          \
    static std::atomic<bool> done{false};                  \
    return done.exchange(true, std::memory_order_relaxed); \
  }())
#define POLYARM_ROS_DUE_(CLOCK, MS)                                                              \
  ([&]() -> bool {                                                                               \
    static std::atomic<std::int64_t> last{INT64_MIN};                                            \
    return ::polyarm_ros::throttle(last, ::polyarm_ros::now_of(CLOCK), static_cast<double>(MS)); \
  }())

#define RCLCPP_DEBUG(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::debug, true, LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_ONCE(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::debug, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::debug, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::debug, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::debug, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::debug, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...)                                             \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::debug, POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), \
                      LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_STREAM(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::debug, true, LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_STREAM_ONCE(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::debug, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_STREAM_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::debug, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_STREAM_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::debug, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_STREAM_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::debug, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_STREAM_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::debug, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_DEBUG_STREAM_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::debug,               \
                         POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)

#define RCLCPP_INFO(LOGGER, ...) POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::info, true, LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_ONCE(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::info, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::info, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::info, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::info, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::info, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...)                                             \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::info, POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), \
                      LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_STREAM(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::info, true, LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_STREAM_ONCE(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::info, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_STREAM_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::info, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_STREAM_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::info, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_STREAM_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::info, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_STREAM_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::info, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_INFO_STREAM_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::info,               \
                         POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)

#define RCLCPP_WARN(LOGGER, ...) POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::warn, true, LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_ONCE(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::warn, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::warn, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::warn, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::warn, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::warn, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...)                                             \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::warn, POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), \
                      LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_STREAM(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::warn, true, LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_STREAM_ONCE(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::warn, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_STREAM_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::warn, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_STREAM_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::warn, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_STREAM_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::warn, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_STREAM_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::warn, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_WARN_STREAM_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::warn,               \
                         POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)

#define RCLCPP_ERROR(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::error, true, LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_ONCE(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::error, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::error, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::error, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::error, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::error, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...)                                             \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::error, POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), \
                      LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_STREAM(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::error, true, LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_STREAM_ONCE(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::error, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_STREAM_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::error, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_STREAM_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::error, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_STREAM_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::error, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_STREAM_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::error, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_ERROR_STREAM_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::error,               \
                         POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)

#define RCLCPP_FATAL(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::fatal, true, LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_ONCE(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::fatal, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::fatal, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::fatal, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::fatal, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::fatal, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...)                                             \
  POLYARM_ROS_LOG_IF_(::polyarm_ros::Severity::fatal, POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), \
                      LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_STREAM(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::fatal, true, LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_STREAM_ONCE(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::fatal, POLYARM_ROS_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_STREAM_EXPRESSION(LOGGER, TRUTH, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::fatal, (TRUTH), LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_STREAM_FUNCTION(LOGGER, FUNCTION, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::fatal, (FUNCTION)(), LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_STREAM_SKIPFIRST(LOGGER, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::fatal, POLYARM_ROS_NOT_FIRST_, LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_STREAM_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::fatal, POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
#define RCLCPP_FATAL_STREAM_SKIPFIRST_THROTTLE(LOGGER, CLOCK, MS, ...) \
  POLYARM_ROS_STREAM_IF_(::polyarm_ros::Severity::fatal,               \
                         POLYARM_ROS_NOT_FIRST_&& POLYARM_ROS_DUE_(CLOCK, MS), LOGGER, __VA_ARGS__)
