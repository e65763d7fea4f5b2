#pragma once
/// Wakes a thread that sleeps until its next tick. Not for the control thread: it locks.
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

#include "polyarm/base/time.hpp"

namespace polyarm::realtime {

class Bell {
 public:
  /// Any thread.
  void ring() {
    {
      const std::lock_guard lock(mutex_);
      rung_ = true;
    }
    wake_.notify_one();
  }
  /// Sleeps until it is rung, at most until `due` (monotonic clock, ns). Returns true if it was rung since
  /// the last wait; several rings count as one.
  bool wait_until(Nanoseconds due) {
    const std::chrono::steady_clock::time_point end{std::chrono::nanoseconds(due)};
    std::unique_lock lock(mutex_);
    wake_.wait_until(lock, end, [this] { return rung_; });
    return std::exchange(rung_, false);
  }

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool rung_ = false;
};

/// Rings the bell that it is tied to, if any. Bells are shared because a thread may ring while a run ends.
class WakeupHandle {
 public:
  /// Any thread; null: to none.
  void tie(std::shared_ptr<Bell> bell) {
    const std::lock_guard lock(mutex_);
    bell_ = std::move(bell);
  }
  /// Any thread.
  void pull() {
    const std::lock_guard lock(mutex_);
    if (bell_) bell_->ring();
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<Bell> bell_;
};

}  // namespace polyarm::realtime
