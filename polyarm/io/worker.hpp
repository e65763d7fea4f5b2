#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "polyarm/realtime/bell.hpp"

namespace polyarm::cell {

/// A thread for jobs that take longer than a tick, in order: those that touch the disk, those that plan. Made
/// inline, it runs each job at once on the caller's thread: that is lock-step. post() never blocks for longer
/// than a push.
class Worker {
 public:
  explicit Worker(bool run_inline);
  ~Worker();  ///< finishes what was posted
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void post(std::function<void()> job);
  /// Rung after each job that was posted; null: none is. Any thread.
  void set_bell(const std::shared_ptr<realtime::Bell>& bell) { rope_.tie(bell); }
  /// Waits until everything posted so far is done.
  void drain();

 private:
  void work();

  bool inline_;
  realtime::BellRope rope_;
  std::mutex mutex_;
  std::condition_variable wake_, idle_;
  std::deque<std::function<void()>> jobs_;
  bool busy_ = false, ending_ = false;
  std::thread thread_;
};

}  // namespace polyarm::cell
