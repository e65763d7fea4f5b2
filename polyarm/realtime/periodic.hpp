#pragma once
/// Wake-ups on a fixed grid of the monotonic clock. The only code that sleeps or reads the system clock.
#include <cstdint>

#include "polyarm/base/time.hpp"

namespace polyarm::realtime {

/// Monotonic time, ns. Not the cell's time: for measuring and for waking up.
Nanoseconds monotonic_now() noexcept;
/// Wall-clock time since the Unix epoch, ns; for display and messages only.
Nanoseconds wall_now() noexcept;

struct WakeUp {
  Nanoseconds due = 0;      ///< when it should have been
  Nanoseconds latency = 0;  ///< how much later it was, >= 0
  std::uint64_t skipped =
      0;  ///< whole periods that passed while nobody ran (a stopped process, a sleeping laptop)
};

/// Absolute wake-ups: lateness does not add up. After a gap it never catches up: missed periods are skipped
/// and reported, and the grid goes on from now.
class Periodic {
 public:
  explicit Periodic(Nanoseconds period) : period_(period) {}
  void start() noexcept { due_ = monotonic_now() + period_; }
  WakeUp wait() noexcept;
  /// Sleeps until the next wake-up is due, at most `most` ns; true when it is due, and wait() returns at
  /// once.
  bool doze(Nanoseconds most) const noexcept;
  /// Somebody else's clock has woken the thread: the grid goes on from now. How it lies to the grid so far.
  WakeUp woken() noexcept;

 private:
  Nanoseconds period_;
  Nanoseconds due_ = 0;
};

struct ThreadOptions {
  int priority = 0;          ///< SCHED_FIFO priority; 0: ordinary scheduling
  int cpu = -1;              ///< pin to this processor; -1: none
  bool lock_memory = false;  ///< keep all pages in memory
};
/// What the machine did not permit.
enum class Refusal : unsigned { cpu = 1, priority = 2, memory = 4 };
/// Applies to the calling thread what the machine permits; returns the bits of what it refused. Its timers
/// are made as exact as the kernel can in any case.
unsigned apply_each(const ThreadOptions& options) noexcept;
/// The same; returns a sentence for what it refused of the control thread, else "".
const char* apply(const ThreadOptions& options) noexcept;

}  // namespace polyarm::realtime
