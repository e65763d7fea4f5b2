#pragma once
/// Executors run the timers, subscriptions and services of their nodes.
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "polyarm_ros/wires.hpp"
#include "rclcpp/future_return_code.hpp"
#include "rclcpp/node.hpp"

namespace rclcpp {

struct ExecutorOptions {};

class Executor {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Executor)
  using NodeCore = node_interfaces::NodeCore;

  explicit Executor(const ExecutorOptions& = {}) {}
  virtual ~Executor() = default;
  void add_node(NodeCore::SharedPtr node, bool = true) {
    const std::lock_guard lock(mutex_);
    nodes_.push_back(std::move(node));
  }
  template <typename NodePointer>
  auto add_node(const NodePointer& node, bool = true) -> decltype(node->get_node_base_interface(), void()) {
    add_node(node->get_node_base_interface(), true);
  }
  void remove_node(NodeCore::SharedPtr node, bool = true) {
    const std::lock_guard lock(mutex_);
    for (auto at = nodes_.begin(); at != nodes_.end();) at = *at == node ? nodes_.erase(at) : at + 1;
  }
  template <typename NodePointer>
  auto remove_node(const NodePointer& node, bool = true)
      -> decltype(node->get_node_base_interface(), void()) {
    remove_node(node->get_node_base_interface(), true);
  }
  void add_callback_group(CallbackGroup::SharedPtr, NodeCore::SharedPtr, bool = true) {}

  virtual void spin() {
    spinning_ = true;
    while (ok() && !stop_.exchange(false))
      if (!once()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    spinning_ = false;
  }
  void spin_some(std::chrono::nanoseconds = {}) { once(); }
  void spin_all(std::chrono::nanoseconds) { once(); }
  void spin_once(std::chrono::nanoseconds timeout = std::chrono::nanoseconds(-1)) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (ok() && !stop_ && !once() && (timeout.count() < 0 || std::chrono::steady_clock::now() < end))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  template <typename NodePointer>
  void spin_node_some(NodePointer) {
    once();
  }
  /// A negative timeout: for ever; on a thread that serves the graph, as in on_configure, 1 s: what comes from
  /// the graph does not arrive while that thread waits.
  template <typename Future, typename Rep = long, typename Ratio = std::milli>
  FutureReturnCode spin_until_future_complete(
      const Future& future,
      std::chrono::duration<Rep, Ratio> timeout = std::chrono::duration<Rep, Ratio>(-1)) {
    auto span = std::chrono::duration_cast<std::chrono::nanoseconds>(timeout);
    if (span.count() < 0 && polyarm_ros::serves_graph()) span = std::chrono::seconds(1);
    const auto end = std::chrono::steady_clock::now() + span;
    while (ok()) {
      if (future.wait_for(std::chrono::milliseconds(1)) == std::future_status::ready)
        return FutureReturnCode::SUCCESS;
      once();
      if (span.count() >= 0 && std::chrono::steady_clock::now() >= end) return FutureReturnCode::TIMEOUT;
    }
    return FutureReturnCode::INTERRUPTED;
  }
  void cancel() { stop_ = true; }
  bool is_spinning() const { return spinning_; }
  bool has_nodes() {
    const std::lock_guard lock(mutex_);
    return !nodes_.empty();
  }

 private:
  bool once() {
    std::vector<NodeCore::SharedPtr> nodes;
    {
      const std::lock_guard lock(mutex_);
      nodes = nodes_;
    }
    bool any = false;
    for (const auto& node : nodes) any = node->run_due() || any;
    return any;
  }
  std::mutex mutex_;
  std::vector<NodeCore::SharedPtr> nodes_;
  std::atomic<bool> stop_{false}, spinning_{false};
};

namespace executors {
#define POLYARM_ROS_EXECUTOR_(NAME)                                           \
  class NAME : public Executor {                                              \
   public:                                                                    \
    RCLCPP_SMART_PTR_DEFINITIONS(NAME)                                        \
    explicit NAME(const ExecutorOptions& = {}, std::size_t = 0, bool = false, \
                  std::chrono::nanoseconds = std::chrono::nanoseconds(-1)) {} \
    std::size_t get_number_of_threads() const { return 1; }                   \
  };
POLYARM_ROS_EXECUTOR_(SingleThreadedExecutor)
POLYARM_ROS_EXECUTOR_(MultiThreadedExecutor)
POLYARM_ROS_EXECUTOR_(StaticSingleThreadedExecutor)
POLYARM_ROS_EXECUTOR_(EventsExecutor)
#undef POLYARM_ROS_EXECUTOR_
}  // namespace executors
using executors::MultiThreadedExecutor;
using executors::SingleThreadedExecutor;

template <typename NodePointer>
void spin(const NodePointer& node) {
  executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  executor.spin();
}
template <typename NodePointer>
void spin_some(const NodePointer& node) {
  executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  executor.spin_some();
}
template <typename NodePointer>
void spin_all(const NodePointer& node, std::chrono::nanoseconds) {
  spin_some(node);
}
template <typename NodePointer, typename Future, typename... Timeout>
FutureReturnCode spin_until_future_complete(const NodePointer& node, const Future& future,
                                            Timeout... timeout) {
  executors::SingleThreadedExecutor executor;
  executor.add_node(node);
  return executor.spin_until_future_complete(future, timeout...);
}

}  // namespace rclcpp
