#pragma once
#include <atomic>
#include <utility>

#include "polyarm/base/time.hpp"
#include "polyarm/realtime/histogram.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::realtime {

/// How a thread that works again and again is doing. Raised by that thread (`missed` of one that is
/// triggered: by who triggers), read by any at any time, without a lock.
struct ThreadHealth {
  Counter runs;
  Counter late;       ///< runs that began more than half a period late
  Counter missed;     ///< runs that did not take place, as the one before was not over
  Histogram wake_up;  ///< from when a run was due to its beginning, ns; empty in lock-step
  Histogram period;   ///< between the beginnings of two runs, ns; empty in lock-step
  Histogram cost;     ///< of a run, ns; empty in lock-step
  std::atomic<unsigned> late_in_a_row{0};
  std::atomic<unsigned> refused{0};  ///< what the machine did not permit, bits of `Refusal`

  /// The thread: a run was due, began and ended. `period` 0: it has none to be late for.
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
  /// The next run begins a new row: the time before it is no period.
  void pause() noexcept {
    last_ = 0;
    late_in_a_row.store(0, std::memory_order_relaxed);
  }

 private:
  Nanoseconds last_ = 0;
};

/// What one part of a cycle costs, and how far apart its turns are. Raised by the thread of the cycle, read
/// by any at any time, without a lock.
class PartHealth {
 public:
  Histogram cost;    ///< of a turn, ns
  Histogram period;  ///< between the beginnings of two turns, ns

  void note(Nanoseconds began, Nanoseconds took) noexcept {
    if (last_ > 0) period.add(began - last_);
    last_ = began;
    cost.add(took);
  }
  /// The next turn begins a new row: the time before it is no period.
  void pause() noexcept { last_ = 0; }

 private:
  Nanoseconds last_ = 0;
};

/// Times the parts of a cycle one after the other with one look at the clock each; off, with none.
class Laps {
 public:
  explicit Laps(bool on) noexcept : on_(on), began_(on ? monotonic_now() : 0) {}
  /// When the part that is under way began.
  Nanoseconds began() const noexcept { return began_; }
  /// The part under way is over, the next begins; what it took, ns.
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
