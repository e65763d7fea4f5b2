#pragma once
/// A function that a thread of its own calls once for each trigger. The caller of the trigger never waits:
/// while the thread is busy it gets the last result. An exception of the function is thrown by the next
/// trigger.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm_ros/standard.hpp"
#include "rclcpp/clock.hpp"
#include "rclcpp/duration.hpp"
#include "rclcpp/logger.hpp"
#include "rclcpp/logging.hpp"
#include "rclcpp/time.hpp"
#include "realtime_tools/realtime_helpers.hpp"

namespace realtime_tools {

class AsyncSchedulingPolicy {
 public:
  enum Value : std::int8_t { UNKNOWN = -1, SYNCHRONIZED, DETACHED };
  AsyncSchedulingPolicy() = default;
  constexpr AsyncSchedulingPolicy(Value value) : value_(value) {}  // NOLINT
  explicit AsyncSchedulingPolicy(const std::string& text)
      : value_(text == "synchronized" ? SYNCHRONIZED
               : text == "detached"   ? DETACHED
                                      : UNKNOWN) {}
  operator Value() const { return value_; }  // NOLINT
  constexpr bool operator==(Value other) const { return value_ == other; }
  constexpr bool operator!=(Value other) const { return value_ != other; }
  std::string to_string() const {
    return value_ == SYNCHRONIZED ? "synchronized" : value_ == DETACHED ? "detached" : "unknown";
  }
  AsyncSchedulingPolicy from_string(const std::string& text) { return AsyncSchedulingPolicy(text); }

 private:
  Value value_ = UNKNOWN;
};

struct AsyncFunctionHandlerParams {
  int thread_priority = 50;
  std::vector<int> cpu_affinity_cores = {};
  AsyncSchedulingPolicy scheduling_policy = AsyncSchedulingPolicy::SYNCHRONIZED;
  unsigned int exec_rate = 0;  ///< Hz; of a detached thread
  rclcpp::Clock::SharedPtr clock = nullptr;
  rclcpp::Logger logger = rclcpp::get_logger("AsyncFunctionHandler");
  std::function<bool()> trigger_predicate = [] { return true; };
  bool wait_until_initial_trigger = true, print_warnings = true;
  std::string thread_name;

  bool validate() const {
    if (scheduling_policy == AsyncSchedulingPolicy::UNKNOWN)
      throw std::runtime_error("the scheduling policy is neither 'synchronized' nor 'detached'");
    if (scheduling_policy == AsyncSchedulingPolicy::DETACHED && (!clock || exec_rate == 0)) return false;
    return thread_priority >= 0 && thread_priority <= 99 && trigger_predicate != nullptr;
  }
};

template <typename T>
class AsyncFunctionHandler {
 public:
  using Function = std::function<T(const rclcpp::Time&, const rclcpp::Duration&)>;
  AsyncFunctionHandler() = default;
  ~AsyncFunctionHandler() { stop_thread(); }
  AsyncFunctionHandler(const AsyncFunctionHandler&) = delete;
  AsyncFunctionHandler& operator=(const AsyncFunctionHandler&) = delete;

  void init(Function call, int thread_priority = 50) {
    if (!call) throw std::runtime_error("there is no function to call");
    if (is_running()) throw std::runtime_error("the thread runs: stop it before init()");
    call_ = std::move(call);
    params_.thread_priority = thread_priority;
  }
  void init(Function call, std::function<bool()> predicate, int thread_priority = 50) {
    if (!predicate) throw std::runtime_error("there is no predicate of the trigger");
    init(std::move(call), thread_priority);
    params_.trigger_predicate = std::move(predicate);
  }
  void init(Function call, const AsyncFunctionHandlerParams& params) {
    if (!params.validate()) throw std::runtime_error("the parameters of the thread are not valid");
    init(std::move(call), params.trigger_predicate, params.thread_priority);
    params_ = params;
    paused_ = params.wait_until_initial_trigger;
  }

  /// True if the function begins, and its last result.
  std::pair<bool, T> trigger_async_callback(const rclcpp::Time& time, const rclcpp::Duration& period) {
    if (!is_initialized()) throw std::runtime_error("call init() first");
    if (!is_running()) throw std::runtime_error("call start_thread() first");
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock.owns_lock() && thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
    if (params_.scheduling_policy == AsyncSchedulingPolicy::DETACHED) {
      // Without the lock the thread may be about to wait, and would miss this: the next trigger begins it.
      if (lock.owns_lock() && paused_.exchange(false)) begin_.notify_one();
      return {true, result_.load()};
    }
    if (!lock.owns_lock() || busy_ || !params_.trigger_predicate()) return {false, result_.load()};
    busy_ = true;
    time_ = time, period_ = period;
    lock.unlock();
    begin_.notify_one();
    return {true, result_.load()};
  }
  void start_thread() {
    if (!is_initialized()) throw std::runtime_error("call init() first");
    if (is_running()) return;
    reset_variables();
    thread_ = std::thread([this] {
      configure_sched_fifo(params_.thread_priority);
      if (!params_.cpu_affinity_cores.empty()) set_current_thread_affinity(params_.cpu_affinity_cores);
      if (!params_.thread_name.empty()) set_current_thread_name(params_.thread_name);
      params_.scheduling_policy == AsyncSchedulingPolicy::DETACHED ? run_detached() : run_triggered();
    });
  }
  void stop_thread() {
    if (!is_running()) return;
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    begin_.notify_one();
    thread_.join();
  }
  void join_async_callback_thread() {
    if (is_running()) thread_.join();
  }
  bool wait_for_trigger_cycle_to_finish() {
    if (!is_running()) return false;
    std::unique_lock lock(mutex_);
    end_.wait(lock, [this] { return !busy_ || stopped_; });
    return true;
  }
  bool pause_execution() {
    paused_ = true;
    return wait_for_trigger_cycle_to_finish() || paused_;
  }
  void reset_variables() {
    const std::lock_guard lock(mutex_);
    stopped_ = busy_ = false;
    thrown_ = nullptr;
    result_ = T{};
    last_execution_time_ = std::chrono::nanoseconds(0);
  }

  bool is_initialized() const { return call_ && params_.trigger_predicate; }
  bool is_running() const { return thread_.joinable(); }
  bool is_stopped() const { return stopped_; }
  bool is_paused() const { return paused_; }
  bool is_trigger_cycle_in_progress() const { return busy_; }
  T get_last_return_value() const { return result_.load(); }
  const rclcpp::Time& get_current_callback_time() const { return time_; }
  const rclcpp::Duration& get_current_callback_period() const { return period_; }
  std::chrono::nanoseconds get_last_execution_time() const { return last_execution_time_.load(); }
  const AsyncFunctionHandlerParams& get_params() const { return params_; }
  std::thread& get_thread() { return thread_; }
  const std::thread& get_thread() const { return thread_; }

 private:
  void run_triggered() {
    std::unique_lock lock(mutex_);
    while (!stopped_) {
      begin_.wait(lock, [this] { return busy_ || stopped_; });
      if (stopped_) break;
      const rclcpp::Time time = time_;
      const rclcpp::Duration period = period_;
      lock.unlock();
      call(time, period);
      lock.lock();
      busy_ = false;
      end_.notify_all();
    }
    end_.notify_all();
  }
  void run_detached() {
    const std::chrono::nanoseconds period(1'000'000'000 / params_.exec_rate);
    auto next = std::chrono::steady_clock::now();
    std::unique_lock lock(mutex_);
    while (!stopped_) {
      begin_.wait(lock, [this] { return !paused_ || stopped_; });
      if (stopped_) break;
      busy_ = true;
      lock.unlock();
      call(params_.clock->now(), rclcpp::Duration(period));
      lock.lock();
      busy_ = false;
      end_.notify_all();
      next = std::max(next + period, std::chrono::steady_clock::now());
      begin_.wait_until(lock, next, [this] { return stopped_.load(); });
    }
  }
  void call(const rclcpp::Time& time, const rclcpp::Duration& period) {
    const auto begin = std::chrono::steady_clock::now();
    try {
      result_ = call_(time, period);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      thrown_ = std::current_exception();
    }
    last_execution_time_ = std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin);
  }

  Function call_;
  AsyncFunctionHandlerParams params_;
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable begin_, end_;
  std::atomic<bool> stopped_{false}, busy_{false}, paused_{false};
  std::exception_ptr thrown_;
  std::atomic<T> result_{};
  std::atomic<std::chrono::nanoseconds> last_execution_time_{std::chrono::nanoseconds(0)};
  rclcpp::Time time_{0, 0, RCL_CLOCK_UNINITIALIZED};
  rclcpp::Duration period_{0, 0};
};

}  // namespace realtime_tools
