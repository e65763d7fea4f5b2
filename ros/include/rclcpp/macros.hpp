#pragma once
/// The pointer aliases that ROS classes declare for themselves.
#include <memory>
#include <utility>

#include "polyarm_ros/standard.hpp"

#define RCLCPP_DISABLE_COPY(...)            \
  __VA_ARGS__(const __VA_ARGS__&) = delete; \
  __VA_ARGS__& operator=(const __VA_ARGS__&) = delete;

#define RCLCPP_SHARED_PTR_ALIASES_(...)           \
  using SharedPtr = std::shared_ptr<__VA_ARGS__>; \
  using ConstSharedPtr = std::shared_ptr<const __VA_ARGS__>;
#define RCLCPP_MAKE_SHARED_(...)                                            \
  template <typename... Arguments>                                          \
  static std::shared_ptr<__VA_ARGS__> make_shared(Arguments&&... args) {    \
    return std::make_shared<__VA_ARGS__>(std::forward<Arguments>(args)...); \
  }
#define RCLCPP_WEAK_PTR_DEFINITIONS(...)      \
  using WeakPtr = std::weak_ptr<__VA_ARGS__>; \
  using ConstWeakPtr = std::weak_ptr<const __VA_ARGS__>;
#define RCLCPP_UNIQUE_PTR_ALIAS_(...) using UniquePtr = std::unique_ptr<__VA_ARGS__>;
#define RCLCPP_MAKE_UNIQUE_(...)                                                            \
  template <typename... Arguments>                                                          \
  static std::unique_ptr<__VA_ARGS__> make_unique(Arguments&&... args) {                    \
    return std::unique_ptr<__VA_ARGS__>(new __VA_ARGS__(std::forward<Arguments>(args)...)); \
  }

#define RCLCPP_SHARED_PTR_DEFINITIONS(...) \
  RCLCPP_SHARED_PTR_ALIASES_(__VA_ARGS__)  \
  RCLCPP_MAKE_SHARED_(__VA_ARGS__)
#define RCLCPP_UNIQUE_PTR_DEFINITIONS(...) \
  RCLCPP_UNIQUE_PTR_ALIAS_(__VA_ARGS__)    \
  RCLCPP_MAKE_UNIQUE_(__VA_ARGS__)
#define RCLCPP_SMART_PTR_DEFINITIONS(...)    \
  RCLCPP_SHARED_PTR_DEFINITIONS(__VA_ARGS__) \
  RCLCPP_WEAK_PTR_DEFINITIONS(__VA_ARGS__)   \
  RCLCPP_UNIQUE_PTR_DEFINITIONS(__VA_ARGS__)
#define RCLCPP_SMART_PTR_ALIASES_ONLY(...) \
  RCLCPP_SHARED_PTR_ALIASES_(__VA_ARGS__)  \
  RCLCPP_WEAK_PTR_DEFINITIONS(__VA_ARGS__) \
  RCLCPP_UNIQUE_PTR_ALIAS_(__VA_ARGS__)    \
  RCLCPP_MAKE_SHARED_(__VA_ARGS__)
#define RCLCPP_SMART_PTR_DEFINITIONS_NOT_COPYABLE(...) \
  RCLCPP_SHARED_PTR_DEFINITIONS(__VA_ARGS__)           \
  RCLCPP_WEAK_PTR_DEFINITIONS(__VA_ARGS__)             \
  RCLCPP_UNIQUE_PTR_DEFINITIONS(__VA_ARGS__)

#define RCLCPP_STRING_JOIN(a, b) a##b
#define RCLCPP_PUBLIC
#define RCLCPP_LOCAL
