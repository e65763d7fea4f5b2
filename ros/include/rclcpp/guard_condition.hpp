#pragma once
/// Wakes a wait set from any thread. A wait that it wakes takes the trigger.
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "rclcpp/context.hpp"
#include "rclcpp/macros.hpp"

namespace rclcpp {

class GuardCondition {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(GuardCondition)
  explicit GuardCondition(Context::SharedPtr context = contexts::get_global_default_context())
      : context_(std::move(context)) {}
  GuardCondition(const GuardCondition&) = delete;
  GuardCondition& operator=(const GuardCondition&) = delete;

  Context::SharedPtr get_context() const { return context_; }
  void trigger() {
    const std::lock_guard lock(mutex_);
    if (on_trigger_)
      on_trigger_(1);
    else
      ++count_;
    triggered_ = true;
  }
  bool exchange_in_use_by_wait_set_state(bool in_use) { return in_use_.exchange(in_use); }
  /// Called with the number of triggers, on the thread that triggers; at once for those that came before.
  void set_on_trigger_callback(std::function<void(std::size_t)> call) {
    const std::lock_guard lock(mutex_);
    on_trigger_ = std::move(call);
    if (on_trigger_ && count_ > 0) on_trigger_(std::exchange(count_, 0));
  }
  /// For the wait set: true once for each trigger.
  bool polyarm_take() { return triggered_.exchange(false); }

 private:
  Context::SharedPtr context_;
  std::mutex mutex_;
  std::function<void(std::size_t)> on_trigger_;
  std::size_t count_ = 0;
  std::atomic<bool> triggered_{false}, in_use_{false};
};

}  // namespace rclcpp
