#pragma once
/// Run-time statistics of threads and of parts of a cycle; times in ns.
#include <atomic>
#include <utility>

#include "polyarm/base/time.hpp"
#include "polyarm/realtime/histogram.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::realtime {

/// Statistics of a periodic or triggered thread. That thread updates them; for a triggered thread, the
/// triggering thread updates `missed`. Any thread may read them at any time, without a lock.
struct ThreadHealth {
  Counter runs;
  Counter late;       ///< runs that began more than half a period late
  Counter missed;     ///< runs skipped because the previous one had not finished
  Histogram wake_up;  ///< from the due time to the start of a run, ns; empty in lock-step
  Histogram period;   ///< between the starts of two runs, ns; empty in lock-step
  Histogram cost;     ///< duration of a run, ns; empty in lock-step
  std::atomic<unsigned> late_in_a_row{0};
  std::atomic<unsigned> refused{0};  ///< `Refusal` bits: what the machine refused

  /// The thread: records one run (ns, monotonic). `each` is the period; 0 means no period, so never late.
  void note(Nanoseconds due, Nanoseconds began, Nanoseconds ended, Nanoseconds each) noexcept {
    const Nanoseconds latency = began > due ? began - due : 0;
    wake_up.add(latency);
    if (last_ > 0) period.add(began - last_);
    last_ = began;
    cost.add(ended - began);
    ++runs;
    const bool is_late = each > 0 && latency > each / 2;
    late += is_late ? 1 : 0;
    late_in_a_row.store(is_late ? late_in_a_row.load(std::memory_order_relaxed) + 1 : 0,
                        std::memory_order_relaxed);
  }
  /// The next run starts a new series: the time before it does not count as a period.
  void pause() noexcept {
    last_ = 0;
    late_in_a_row.store(0, std::memory_order_relaxed);
  }

 private:
  Nanoseconds last_ = 0;
};

/// Duration and period of one part of a cycle. The thread of the cycle updates it; any thread may read it at
/// any time, without a lock.
class PartHealth {
 public:
  Histogram cost;    ///< duration of a turn, ns
  Histogram period;  ///< between the starts of two turns, ns

  void note(Nanoseconds began, Nanoseconds took) noexcept {
    if (last_ > 0) period.add(began - last_);
    last_ = began;
    cost.add(took);
  }
  /// The next turn starts a new series: the time before it does not count as a period.
  void pause() noexcept { last_ = 0; }

 private:
  Nanoseconds last_ = 0;
};

/// Times consecutive parts of a cycle with one clock read per part; reads no clock when off.
class Laps {
 public:
  explicit Laps(bool on) noexcept : on_(on), began_(on ? monotonic_now() : 0) {}
  /// Start of the current part, ns, monotonic.
  Nanoseconds began() const noexcept { return began_; }
  /// Ends the current part and starts the next. Returns the duration of the ended part, ns.
  Nanoseconds next() noexcept {
    if (!on_) return 0;
    const Nanoseconds before = std::exchange(began_, monotonic_now());
    return began_ - before;
  }
  bool on() const noexcept { return on_; }

 private:
  bool on_;
  Nanoseconds began_;
};

}  // namespace polyarm::realtime
