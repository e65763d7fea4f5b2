#pragma once
/// Runs jobs that take longer than a tick, so the cell thread does not wait for them.
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "polyarm/realtime/bell.hpp"

namespace polyarm::cell {

/// A thread that runs jobs in order, such as disk access and planning. With `run_inline` (lock-step) each job
/// runs at once on the caller's thread. post() never blocks for longer than a push.
class Worker {
 public:
  explicit Worker(bool run_inline);
  ~Worker();  ///< finishes the posted jobs
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void post(std::function<void()> job);
  /// Bell to ring after each posted job; null: no bell. Any thread.
  void set_wakeup(const std::shared_ptr<realtime::Bell>& bell) { rope_.tie(bell); }
  /// Waits until all jobs posted so far are done.
  void drain();

 private:
  void work();

  bool inline_;
  realtime::WakeupHandle rope_;
  std::mutex mutex_;
  std::condition_variable wake_, idle_;
  std::deque<std::function<void()>> jobs_;
  bool busy_ = false, ending_ = false;
  std::thread thread_;
};

/// For jobs of seconds, such as reading meshes: what waits for the Worker must not wait for them.
struct LongWorker : Worker {
  using Worker::Worker;
};

}  // namespace polyarm::cell
