#pragma once
/// Jobs that one thread prepares and the real-time thread runs between two cycles.
#include <atomic>
#include <deque>
#include <memory>

#include "polyarm/realtime/queue.hpp"

namespace polyarm::realtime {

/// The posting thread prepares and frees a job; the real-time thread runs it once. run() must not allocate,
/// lock or wait.
class Job {
 public:
  virtual ~Job() = default;
  virtual void run() noexcept = 0;
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }

 private:
  friend class Jobs;
  std::atomic<bool> done_{false};
};

/// Passes jobs from one posting thread to one real-time thread. Before start(), post() runs them at once.
class Jobs {
 public:
  /// Posting thread: returns false if too many jobs are waiting.
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
  /// Real-time thread: runs the oldest waiting job, if any.
  void run_one() noexcept {
    Job* job = nullptr;
    if (queue_.pop(job)) finish(*job);
  }
  /// From now on a real-time thread calls run_one().
  void start() noexcept { started_.store(true, std::memory_order_release); }
  bool started() const noexcept { return started_.load(std::memory_order_relaxed); }
  /// Posting thread, after the real-time thread has ended: runs the remaining jobs here.
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
