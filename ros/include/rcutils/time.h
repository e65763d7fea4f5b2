#pragma once
#include <chrono>
#include <cstdint>

#include "rcutils/macros.h"

using rcutils_time_point_value_t = std::int64_t;
/// As in ROS, they keep the type of a floating-point value: 0.5 s are 5e8 ns.
#define RCUTILS_S_TO_NS(value) ((value) * 1000000000LL)
#define RCUTILS_MS_TO_NS(value) ((value) * 1000000LL)
#define RCUTILS_US_TO_NS(value) ((value) * 1000LL)
#define RCUTILS_NS_TO_S(value) ((value) / 1000000000LL)
#define RCUTILS_NS_TO_MS(value) ((value) / 1000000LL)
#define RCUTILS_NS_TO_US(value) ((value) / 1000LL)

/// Nanoseconds since 1970; 0 is "no error", as in ROS.
inline int rcutils_system_time_now(rcutils_time_point_value_t* now) {
  *now = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
             .count();
  return 0;
}
inline int rcutils_steady_time_now(rcutils_time_point_value_t* now) {
  *now = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
             .count();
  return 0;
}
