#pragma once
/// The logging macros of C code, which are used from C++ here.
#include <cinttypes>

#include "rclcpp/logging.hpp"

#define RCUTILS_LOG_SEVERITY_DEBUG 10
#define RCUTILS_LOG_SEVERITY_INFO 20
#define RCUTILS_LOG_SEVERITY_WARN 30
#define RCUTILS_LOG_SEVERITY_ERROR 40
#define RCUTILS_LOG_SEVERITY_FATAL 50

#define RCUTILS_LOG_DEBUG(...) ::polyarm_ros::log_format(::polyarm_ros::Severity::debug, "", __VA_ARGS__)
#define RCUTILS_LOG_DEBUG_NAMED(NAME, ...) \
  ::polyarm_ros::log_format(::polyarm_ros::Severity::debug, NAME, __VA_ARGS__)
#define RCUTILS_LOG_DEBUG_ONCE_NAMED(NAME, ...)                                                           \
  do {                                                                                                    \
    if (POLYARM_ROS_FIRST_) ::polyarm_ros::log_format(::polyarm_ros::Severity::debug, NAME, __VA_ARGS__); \
  } while (0)

#define RCUTILS_LOG_INFO(...) ::polyarm_ros::log_format(::polyarm_ros::Severity::info, "", __VA_ARGS__)
#define RCUTILS_LOG_INFO_NAMED(NAME, ...) \
  ::polyarm_ros::log_format(::polyarm_ros::Severity::info, NAME, __VA_ARGS__)
#define RCUTILS_LOG_INFO_ONCE_NAMED(NAME, ...)                                                           \
  do {                                                                                                   \
    if (POLYARM_ROS_FIRST_) ::polyarm_ros::log_format(::polyarm_ros::Severity::info, NAME, __VA_ARGS__); \
  } while (0)

#define RCUTILS_LOG_WARN(...) ::polyarm_ros::log_format(::polyarm_ros::Severity::warn, "", __VA_ARGS__)
#define RCUTILS_LOG_WARN_NAMED(NAME, ...) \
  ::polyarm_ros::log_format(::polyarm_ros::Severity::warn, NAME, __VA_ARGS__)
#define RCUTILS_LOG_WARN_ONCE_NAMED(NAME, ...)                                                           \
  do {                                                                                                   \
    if (POLYARM_ROS_FIRST_) ::polyarm_ros::log_format(::polyarm_ros::Severity::warn, NAME, __VA_ARGS__); \
  } while (0)

#define RCUTILS_LOG_ERROR(...) ::polyarm_ros::log_format(::polyarm_ros::Severity::error, "", __VA_ARGS__)
#define RCUTILS_LOG_ERROR_NAMED(NAME, ...) \
  ::polyarm_ros::log_format(::polyarm_ros::Severity::error, NAME, __VA_ARGS__)
#define RCUTILS_LOG_ERROR_ONCE_NAMED(NAME, ...)                                                           \
  do {                                                                                                    \
    if (POLYARM_ROS_FIRST_) ::polyarm_ros::log_format(::polyarm_ros::Severity::error, NAME, __VA_ARGS__); \
  } while (0)

#define RCUTILS_LOG_FATAL(...) ::polyarm_ros::log_format(::polyarm_ros::Severity::fatal, "", __VA_ARGS__)
#define RCUTILS_LOG_FATAL_NAMED(NAME, ...) \
  ::polyarm_ros::log_format(::polyarm_ros::Severity::fatal, NAME, __VA_ARGS__)
#define RCUTILS_LOG_FATAL_ONCE_NAMED(NAME, ...)                                                           \
  do {                                                                                                    \
    if (POLYARM_ROS_FIRST_) ::polyarm_ros::log_format(::polyarm_ros::Severity::fatal, NAME, __VA_ARGS__); \
  } while (0)
