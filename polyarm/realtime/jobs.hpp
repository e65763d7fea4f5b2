#pragma once
/// Work that one thread prepares and the real-time thread does between two of its cycles.
#include <atomic>
#include <deque>
#include <memory>

#include "polyarm/realtime/queue.hpp"

namespace polyarm::realtime {

/// Prepared and freed by the thread that posts it; run once by the real-time thread, which must find nothing
/// to allocate, lock or wait for in it.
class Job {
 public:
  virtual ~Job() = default;
  virtual void run() noexcept = 0;
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }

 private:
  friend class Jobs;
  std::atomic<bool> done_{false};
};

/// From one posting thread to one real-time thread. Before start() jobs are run by the poster, at once.
class Jobs {
 public:
  /// Poster: false when too many are waiting.
  bool post(std::shared_ptr<Job> job) {
    while (!kept_.empty() && kept_.front()->done()) kept_.pop_front();
    if (!started_.load(std::memory_order_acquire)) {
      finish(*job);
      return true;
    }
    if (!queue_.push(job.get())) return false;
    kept_.push_back(std::move(job));
    return true;
  }
  /// Real-time thread: does what has been waiting longest, if anything.
  void run_one() noexcept {
    Job* job = nullptr;
    if (queue_.pop(job)) finish(*job);
  }
  /// From now on a real-time thread calls run_one().
  void start() noexcept { started_.store(true, std::memory_order_release); }
  bool started() const noexcept { return started_.load(std::memory_order_relaxed); }
  /// The real-time thread has ended: what still waits is done here, in the posting thread.
  void stop() noexcept {
    for (Job* job = nullptr; queue_.pop(job);) finish(*job);
    started_.store(false, std::memory_order_release);
  }

 private:
  static void finish(Job& job) noexcept {
    job.run();
    job.done_.store(true, std::memory_order_release);
  }
  Queue<Job*> queue_{64};
  std::deque<std::shared_ptr<Job>> kept_;  // until they are done
  std::atomic<bool> started_{false};
};

}  // namespace polyarm::realtime
