#pragma once
/// Wake-ups on a fixed grid of the monotonic clock. The only code that sleeps or reads the system clock.
#include <cstdint>

#include "polyarm/base/time.hpp"

namespace polyarm::realtime {

/// Monotonic time, ns, for measuring and waking up. It is not the cell's time.
Nanoseconds monotonic_now() noexcept;
/// Wall-clock time since the Unix epoch, ns; for display and messages only.
Nanoseconds wall_now() noexcept;

struct WakeUp {
  Nanoseconds due = 0;      ///< ns, monotonic: the scheduled time
  Nanoseconds latency = 0;  ///< ns by which the wake-up was late, >= 0
  std::uint64_t skipped =
      0;  ///< whole periods missed (a stopped process, a sleeping laptop)
};

/// Wakes up at absolute times, so lateness does not accumulate. After a gap it skips and reports the missed
/// periods and continues on the same grid.
class Periodic {
 public:
  explicit Periodic(Nanoseconds period) : period_(period) {}
  void start() noexcept { due_ = monotonic_now() + period_; }
  WakeUp wait() noexcept;
  /// Sleeps until the next wake-up is due, at most `most` ns. Returns true if it is due; wait() then returns
  /// at once.
  bool doze(Nanoseconds most) const noexcept;
  /// Call it when another clock woke the thread: the grid restarts from now. Returns this wake-up measured
  /// against the old grid.
  WakeUp woken() noexcept;

 private:
  Nanoseconds period_;
  Nanoseconds due_ = 0;
};

struct ThreadOptions {
  int priority = 0;          ///< SCHED_FIFO priority; 0 means ordinary scheduling
  int cpu = -1;              ///< processor to pin to; -1 means no pinning
  bool lock_memory = false;  ///< keep all pages in memory
};
/// What the machine did not permit.
enum class Refusal : unsigned { cpu = 1, priority = 2, memory = 4 };
/// Applies to the calling thread what the machine permits. Returns the `Refusal` bits of what it refused.
/// Always sets the thread's timers as exact as the kernel allows.
unsigned apply_each(const ThreadOptions& options) noexcept;
/// The same for the control thread. Returns a sentence about what was refused, or "".
const char* apply(const ThreadOptions& options) noexcept;

}  // namespace polyarm::realtime
