#pragma once
#include <chrono>
#include <memory>
#include <thread>

#include "rclcpp/clock.hpp"

namespace rclcpp {

/// Sleeps until the next multiple of its period. After a delay of more than a period it starts again from
/// now.
class Rate {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Rate)

  explicit Rate(double hz, Clock::SharedPtr = nullptr)
      : Rate(Duration::from_seconds(hz > 0 ? 1.0 / hz
                                           : throw std::invalid_argument("rate must be greater than 0"))) {}
  explicit Rate(Duration period, Clock::SharedPtr = nullptr)
      : period_(period.nanoseconds()), last_(std::chrono::steady_clock::now()) {}
  template <class Rep, class Period>
  explicit Rate(std::chrono::duration<Rep, Period> period) : Rate(Duration(period)) {}

  bool sleep() {
    const auto now = std::chrono::steady_clock::now();
    auto next = last_ + period_;
    if (now < last_) next = now + period_;
    if (next <= now) {
      last_ = now > next + period_ ? now : next;
      return false;
    }
    std::this_thread::sleep_until(next);
    last_ = next;
    return true;
  }
  bool is_steady() const { return true; }
  void reset() { last_ = std::chrono::steady_clock::now(); }
  std::chrono::nanoseconds period() const { return period_; }

 private:
  std::chrono::nanoseconds period_;
  std::chrono::steady_clock::time_point last_;
};
using RateBase = Rate;
using WallRate = Rate;
using ROSRate = Rate;

}  // namespace rclcpp
