#pragma once
/// Work on a thread of its own at a rate of its own, triggered by nobody.
#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>

#include "polyarm/realtime/periodic.hpp"
#include "polyarm/realtime/thread_health.hpp"

namespace polyarm::realtime {

/// Runs `work` at absolute times of its own period on the monotonic clock. Runs that take longer than a
/// period are not made up for: what passed meanwhile is counted as missed, and the grid goes on.
class PeriodicRunner {
 public:
  /// `work` returns whether there was anything to do: only that is measured. It may touch nothing that other
  /// threads touch but through `Latest` and atomics.
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
  /// How long the end of a thread with a long period is waited for.
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
