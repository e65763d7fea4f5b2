#pragma once
/// Waits for messages of subscriptions and for timers, without an executor. It takes nothing: the caller
/// takes the message or lets an executor run. Any thread.
#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm_ros/wires.hpp"
#include "rclcpp/subscription.hpp"
#include "rclcpp/timer.hpp"
#include "rclcpp/utilities.hpp"
#include "rclcpp/wait_result.hpp"

namespace rclcpp {

struct SubscriptionWaitSetMask {
  bool include_subscription = true, include_events = true, include_intra_process_waitable = true;
};

class WaitSet {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(WaitSet)
  struct SubscriptionEntry {
    SubscriptionBase::SharedPtr subscription;
    SubscriptionWaitSetMask mask;
    SubscriptionEntry(SubscriptionBase::SharedPtr of = nullptr, SubscriptionWaitSetMask which = {})
        : subscription(std::move(of)), mask(which) {}
  };
  WaitSet() = default;
  explicit WaitSet(const std::vector<SubscriptionEntry>& subscriptions) {
    for (const SubscriptionEntry& each : subscriptions) add_subscription(each.subscription, each.mask);
  }
  WaitSet(const WaitSet&) = delete;
  WaitSet& operator=(const WaitSet&) = delete;

  void add_subscription(SubscriptionBase::SharedPtr subscription, SubscriptionWaitSetMask = {}) {
    add(subscriptions_, std::move(subscription), "subscription");
  }
  void remove_subscription(const SubscriptionBase::SharedPtr& subscription, SubscriptionWaitSetMask = {}) {
    remove(subscriptions_, subscription, "subscription");
  }
  void add_timer(TimerBase::SharedPtr timer) { add(timers_, std::move(timer), "timer"); }
  void remove_timer(const TimerBase::SharedPtr& timer) { remove(timers_, timer, "timer"); }

  /// Negative: for ever; on a thread that serves the graph, as in on_configure of a controller, 1 s: what
  /// comes from the graph does not arrive while that thread waits. Empty if the set has nothing to wait for.
  template <typename Rep = long, typename Ratio = std::milli>
  WaitResult<WaitSet> wait(
      std::chrono::duration<Rep, Ratio> timeout = std::chrono::duration<Rep, Ratio>(-1)) {
    auto span = std::chrono::duration_cast<std::chrono::nanoseconds>(timeout);
    if (span.count() < 0 && polyarm_ros::serves_graph()) span = std::chrono::seconds(1);
    const auto end = std::chrono::steady_clock::now() + span;
    while (ok()) {
      if (const WaitResultKind now = state(); now != Timeout) return WaitResult<WaitSet>(now, this);
      if (span.count() >= 0 && std::chrono::steady_clock::now() >= end) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return WaitResult<WaitSet>(Timeout, this);
  }

 private:
  template <typename T>
  void add(std::vector<std::shared_ptr<T>>& all, std::shared_ptr<T> one, const char* kind) {
    if (!one) throw std::invalid_argument(std::string(kind) + " is nullptr");
    const std::lock_guard lock(mutex_);
    if (std::find(all.begin(), all.end(), one) != all.end())
      throw std::runtime_error(std::string(kind) + " already in use by the wait set");
    all.push_back(std::move(one));
  }
  template <typename T>
  void remove(std::vector<std::shared_ptr<T>>& all, const std::shared_ptr<T>& one, const char* kind) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find(all.begin(), all.end(), one);
    if (found == all.end()) throw std::runtime_error(std::string(kind) + " not in wait set");
    all.erase(found);
  }
  WaitResultKind state() {
    const std::lock_guard lock(mutex_);
    if (subscriptions_.empty() && timers_.empty()) return Empty;
    for (const auto& each : subscriptions_)
      if (each->has_message()) return Ready;
    for (const auto& each : timers_)
      if (each->is_ready()) return Ready;
    return Timeout;
  }
  std::mutex mutex_;
  std::vector<std::shared_ptr<SubscriptionBase>> subscriptions_;
  std::vector<std::shared_ptr<TimerBase>> timers_;
};
using ThreadSafeWaitSet = WaitSet;

}  // namespace rclcpp
