#pragma once
/// The thread of a simulated controller: it serves the connections, and its clock moves the controller.
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "polyarm/base/descriptor.hpp"
#include "polyarm/base/time.hpp"

namespace polyarm::wire {

/// Declare it behind everything that the controller uses: its thread ends before they do. Any thread may
/// call.
class FarClock {
 public:
  /// The controller, called on the thread of the clock or of step(), with the lock.
  struct Controller {
    std::function<void(std::vector<int>&)> descriptors;  ///< adds those that it reads from
    std::function<void()> serve;                         ///< takes what has come
    std::function<bool()> waits;                         ///< true: the last packet has no answer yet
    std::function<void()> cycle;
  };
  /// `patience`: longest wait for the answer to a packet, ns.
  explicit FarClock(Nanoseconds patience);
  ~FarClock();
  FarClock(const FarClock&) = delete;
  FarClock& operator=(const FarClock&) = delete;

  /// Once; `period`: of the controller, ns.
  void start(Nanoseconds period, Controller controller);
  [[nodiscard]] std::unique_lock<std::mutex> lock() { return std::unique_lock(mutex_); }
  /// The clock stands still; step() moves it.
  void hold(bool on);
  /// One cycle. Waits until `ready`, which is called with the lock, at most `patience` ns; false if it was
  /// not.
  bool step(Nanoseconds patience, const std::function<bool()>& ready);
  /// Waits until everything is taken that had come before.
  void settle();

 private:
  void run();
  void await_work(Nanoseconds due);

  Nanoseconds patience_, period_ = 0;
  Controller controller_;
  std::mutex mutex_;
  std::condition_variable served_;
  bool held_ = false;
  std::uint64_t served_times_ = 0;
  Descriptor wake_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace polyarm::wire
