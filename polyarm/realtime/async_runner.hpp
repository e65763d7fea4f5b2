#pragma once
/// Work on a thread of its own, triggered by the real-time thread, which never waits for it.
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <semaphore>
#include <thread>

#include "polyarm/realtime/periodic.hpp"

namespace polyarm::realtime {

/// One trigger, one run of `work`. The real-time thread looks whether the last run has ended, takes its
/// results, and triggers the next; a trigger while it runs is missed and counted. In lock-step the work is
/// done inside trigger(), and as its results are taken at the next look, they are one period old just the
/// same.
class AsyncRunner {
 public:
  AsyncRunner(std::function<void()> work, bool lock_step, ThreadOptions options = {})
      : work_(std::move(work)), lock_step_(lock_step) {
    if (!lock_step_)
      thread_ = std::thread([this, options] {
        refused_ = apply(options);
        for (go_.acquire(); !ending_.load(std::memory_order_acquire); go_.acquire()) {
          work_();
          busy_.store(false, std::memory_order_release);
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

  /// Real-time thread: no run is under way; what the work reads and writes may be touched.
  bool idle() const noexcept { return !busy_.load(std::memory_order_acquire); }
  /// Real-time thread, when idle.
  void trigger() noexcept {
    ++runs_;
    if (lock_step_) return work_();
    busy_.store(true, std::memory_order_release);
    go_.release();
  }
  void note_missed() noexcept { missed_.fetch_add(1, std::memory_order_relaxed); }
  std::uint64_t missed() const noexcept { return missed_.load(std::memory_order_relaxed); }
  std::uint64_t runs() const noexcept { return runs_.load(std::memory_order_relaxed); }

 private:
  std::function<void()> work_;
  bool lock_step_;
  std::atomic<bool> busy_{false}, ending_{false};
  std::atomic<std::uint64_t> missed_{0}, runs_{0};
  const char* refused_ = "";
  std::counting_semaphore<8> go_{0};
  std::thread thread_;
};

}  // namespace polyarm::realtime
