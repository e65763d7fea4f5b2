#pragma once
/// ROS time of a node. The node of a controller follows the cell's time, also in lock-step; else ROS time is the
/// system's.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>

namespace polyarm_ros {

/// ns; 0 while nobody sets it. Written by the control thread, read by any.
using TimeSource = std::shared_ptr<std::atomic<std::int64_t>>;

inline std::int64_t system_time() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}
inline std::int64_t steady_time() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}
inline std::int64_t time_of(const TimeSource& source, std::int64_t (*otherwise)()) {
  const std::int64_t set = source ? source->load(std::memory_order_relaxed) : 0;
  return set ? set : otherwise();
}

}  // namespace polyarm_ros
