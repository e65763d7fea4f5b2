#pragma once
/// Transforms of /tf and /tf_static. What other programs publish on the ROS 2 graph and what nodes of the
/// same module send arrives; a look-up waits at most for its timeout of the steady clock.
#include <memory>
#include <string>

#include "rclcpp/clock.hpp"
#include "rclcpp/rclcpp.hpp"
#include "tf2/buffer_core.hpp"
#include "tf2/convert.hpp"
#include "tf2/time.hpp"

namespace tf2_ros {
using tf2::Duration;

inline rclcpp::Time toRclcpp(const tf2::TimePoint& time) {
  return rclcpp::Time(time.time_since_epoch().count(), RCL_ROS_TIME);
}
inline rclcpp::Duration toRclcpp(const tf2::Duration& span) {
  return rclcpp::Duration(span);
}
inline tf2::TimePoint fromRclcpp(const rclcpp::Time& time) {
  return tf2::time_point_of(time);
}
inline tf2::Duration fromRclcpp(const rclcpp::Duration& span) {
  return tf2::duration_of(span);
}
using tf2::fromMsg;
using tf2::toMsg;

class BufferInterface : public tf2::BufferCore {
 public:
  using tf2::BufferCore::BufferCore;
  using tf2::BufferCore::canTransform;
  using tf2::BufferCore::lookupTransform;

  template <typename Time, typename Span>
  auto lookupTransform(const std::string& target, const std::string& source, const Time& time,
                       const Span& timeout) const -> decltype(tf2::duration_of(timeout), TransformStamped()) {
    wait(target, source, tf2::time_point_of(time), tf2::duration_of(timeout));
    return lookupTransform(target, source, time);
  }
  template <typename Time, typename Span>
  auto lookupTransform(const std::string& target, const Time& target_time, const std::string& source,
                       const Time& source_time, const std::string& fixed, const Span& timeout) const
      -> decltype(tf2::duration_of(timeout), TransformStamped()) {
    wait(target, fixed, tf2::time_point_of(target_time), tf2::duration_of(timeout));
    wait(fixed, source, tf2::time_point_of(source_time), tf2::duration_of(timeout));
    return lookupTransform(target, target_time, source, source_time, fixed);
  }
  template <typename Time, typename Span>
  auto canTransform(const std::string& target, const std::string& source, const Time& time,
                    const Span& timeout, std::string* reason = nullptr) const
      -> decltype(tf2::duration_of(timeout), bool()) {
    wait(target, source, tf2::time_point_of(time), tf2::duration_of(timeout));
    return canTransform(target, source, time, reason);
  }
  /// `in` in the frame `target`, at the time of its header.
  template <typename T>
  T& transform(const T& in, T& out, const std::string& target, tf2::Duration timeout = {}) const {
    tf2::doTransform(in, out,
                     lookupTransform(target, in.header.frame_id, rclcpp::Time(in.header.stamp), timeout));
    return out;
  }
  template <typename T>
  T transform(const T& in, const std::string& target, tf2::Duration timeout = {}) const {
    T out;
    return transform(in, out, target, timeout);
  }

 private:
  void wait(const std::string& target, const std::string& source, tf2::TimePoint time,
            tf2::Duration span) const {
    if (span.count() > 0) wait_for(span, [&] { return can_now(target, source, time); });
  }
};

class Buffer : public BufferInterface {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Buffer)
  template <typename... Rest>
  explicit Buffer(const std::shared_ptr<rclcpp::Clock>&,
                  tf2::Duration cache = tf2::BUFFER_CORE_DEFAULT_CACHE_TIME, Rest&&...)
      : BufferInterface(cache) {}
  void setUsingDedicatedThread(bool) {}
  bool isUsingDedicatedThread() const { return true; }
  template <typename Timers>
  void setCreateTimerInterface(const std::shared_ptr<Timers>&) {}
};
}  // namespace tf2_ros
