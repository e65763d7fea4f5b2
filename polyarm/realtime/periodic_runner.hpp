#pragma once
/// Runs periodic work on its own thread at its own rate, without an external trigger.
#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>

#include "polyarm/realtime/periodic.hpp"
#include "polyarm/realtime/thread_health.hpp"

namespace polyarm::realtime {

/// Runs `work` at absolute times of its own period (ns) on the monotonic clock. If a run takes longer than a
/// period, the periods that passed are counted as missed and skipped.
class PeriodicRunner {
 public:
  /// `work` returns true if it had something to do; only such runs are measured. It may share data with other
  /// threads only through `Latest` and atomics.
  PeriodicRunner(std::function<bool()> work, Nanoseconds period, ThreadOptions options, ThreadHealth& health)
      : thread_([this, work = std::move(work), period, options, &health] {
          health.refused.store(apply_each(options), std::memory_order_release);
          loop(work, period, health);
        }) {}
  ~PeriodicRunner() {
    ending_.store(true, std::memory_order_release);
    thread_.join();
  }
  PeriodicRunner(const PeriodicRunner&) = delete;
  PeriodicRunner& operator=(const PeriodicRunner&) = delete;

 private:
  /// Longest sleep, ns: bounds how long the destructor waits for a thread with a long period.
  static constexpr Nanoseconds kDoze = 50'000'000;

  void loop(const std::function<bool()>& work, Nanoseconds period, ThreadHealth& health) {
    Periodic clock(period);
    clock.start();
    while (!ending_.load(std::memory_order_acquire)) {
      if (!clock.doze(kDoze)) continue;
      const WakeUp wake = clock.wait();
      const Nanoseconds began = wake.due + wake.latency;
      if (!work()) {
        health.pause();
        continue;
      }
      health.missed += wake.skipped;
      health.note(wake.due, began, monotonic_now(), period);
    }
  }

  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace polyarm::realtime
