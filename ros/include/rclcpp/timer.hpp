#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>

#include "polyarm_ros/cell_clock.hpp"
#include "rclcpp/clock.hpp"

namespace rclcpp {

/// Runs in the executor that spins its node.
class TimerBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(TimerBase)
  TimerBase(std::chrono::nanoseconds period, std::function<void(TimerBase&)> call,
            polyarm_ros::TimeSource source = nullptr)
      : period_(period), call_(std::move(call)), source_(std::move(source)), next_(now() + period) {}
  virtual ~TimerBase() = default;
  void cancel() { canceled_ = true; }
  bool is_canceled() const { return canceled_; }
  void reset() { next_ = now() + period_, canceled_ = false; }
  bool is_ready() const { return !canceled_ && now() >= next_; }
  bool is_steady() const { return true; }
  std::chrono::nanoseconds time_until_trigger() const { return next_ - now(); }
  /// Takes the trigger: the next one is a period away. Null if the timer is canceled.
  std::shared_ptr<void> call() {
    if (canceled_) return nullptr;
    next_ = now() + period_;
    return std::make_shared<bool>(true);
  }
  /// With or without what `call` returned.
  void execute_callback(const std::shared_ptr<void>& = nullptr) {
    next_ = now() + period_;
    if (call_) call_(*this);
  }

 private:
  std::chrono::nanoseconds period_;
  std::function<void(TimerBase&)> call_;
  std::chrono::nanoseconds now() const {
    return std::chrono::nanoseconds(polyarm_ros::time_of(source_, polyarm_ros::steady_time));
  }
  polyarm_ros::TimeSource source_;
  std::chrono::nanoseconds next_;
  std::atomic<bool> canceled_{false};
};
template <typename Functor = std::function<void()>>
class WallTimer : public TimerBase {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(WallTimer<Functor>)
  using TimerBase::TimerBase;
};
template <typename Functor = std::function<void()>>
using GenericTimer = TimerBase;

}  // namespace rclcpp
