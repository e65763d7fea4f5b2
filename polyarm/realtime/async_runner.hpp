#pragma once
/// Runs work on its own thread. The real-time thread triggers it and never waits for it.
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <semaphore>
#include <thread>

#include "polyarm/realtime/periodic.hpp"
#include "polyarm/realtime/thread_health.hpp"

namespace polyarm::realtime {

/// Each trigger runs `work` once. The real-time thread checks that the last run has ended, takes its results
/// and triggers the next run. A trigger during a run is counted as missed. In lock-step, trigger() runs the
/// work itself; the results are taken at the next check, so they are one period old in both modes.
class AsyncRunner {
 public:
  /// `period`: time between triggers, ns; 0 means irregular, and no run counts as late.
  AsyncRunner(std::function<void()> work, bool lock_step, ThreadOptions options = {}, Nanoseconds period = 0)
      : work_(std::move(work)), lock_step_(lock_step), period_(period) {
    if (!lock_step_)
      thread_ = std::thread([this, options] {
        health_.refused.store(apply_each(options), std::memory_order_release);
        for (go_.acquire(); !ending_.load(std::memory_order_acquire); go_.acquire()) {
          const Nanoseconds due = triggered_at_, began = monotonic_now();
          if (rested_.exchange(false, std::memory_order_relaxed)) health_.pause();
          work_();
          health_.note(due, began, monotonic_now(), period_);
          busy_->store(false, std::memory_order_release);
          busy_->notify_all();
        }
      });
  }
  ~AsyncRunner() {
    if (!thread_.joinable()) return;
    ending_.store(true, std::memory_order_release);
    go_.release();
    thread_.join();
  }
  AsyncRunner(const AsyncRunner&) = delete;
  AsyncRunner& operator=(const AsyncRunner&) = delete;

  /// Real-time thread: true if no run is active; the data of the work may then be accessed.
  bool idle() const noexcept { return !busy_->load(std::memory_order_acquire); }
  /// True while a run is active. A thread that triggers no more runs may wait for its end.
  std::shared_ptr<const std::atomic<bool>> busy() const noexcept { return busy_; }
  /// Real-time thread, when idle.
  void trigger() noexcept {
    if (lock_step_) {
      ++health_.runs;
      return work_();
    }
    triggered_at_ = monotonic_now();
    busy_->store(true, std::memory_order_release);
    go_.release();
  }
  /// Real-time thread: resets the lateness; the time until the next run does not count as a period.
  void forgive() noexcept {
    health_.late_in_a_row.store(0, std::memory_order_relaxed);
    rested_.store(true, std::memory_order_relaxed);
  }
  void note_missed() noexcept { ++health_.missed; }
  std::uint64_t missed() const noexcept { return health_.missed; }
  std::uint64_t runs() const noexcept { return health_.runs; }
  /// Any thread.
  const ThreadHealth& health() const noexcept { return health_; }

 private:
  std::function<void()> work_;
  bool lock_step_;
  Nanoseconds period_;
  Nanoseconds triggered_at_ = 0;  // handed over with the trigger
  std::shared_ptr<std::atomic<bool>> busy_ = std::make_shared<std::atomic<bool>>(false);
  std::atomic<bool> ending_{false}, rested_{false};
  ThreadHealth health_;
  std::counting_semaphore<8> go_{0};
  std::thread thread_;
};

}  // namespace polyarm::realtime
